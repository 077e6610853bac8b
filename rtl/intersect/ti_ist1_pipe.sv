// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Passes (a) and (b) of the ray-triangle test on one set of 7 ADD, 8 MUL and 2 CMP; 7 MUL and 1 CMP without the cull
/// against the near end (`ti_config_pkg::IntervalCull`).
///
/// The test is that of Shevtsov et al. (2007) in its local form (p_w stored in place of n.p), or with `Np` as
/// published: then G2 takes o in place of a, X2 gives m = nu*ou + nv*ov, X3 m + ow, and one more ADD, X4, dett = np -
/// that; latency and the rest are as if X4 stood behind X3 in both passes.
/// G1, H, G2 and X1 are in `ti_ist1_front`.  One pass a cycle in any mixture, latency `Latency` for both: every operator stands at one place in
/// time and serves both passes there.  No stall.
///
/// | step    | starts at | pass (a)                             | pass (b)                          |
/// |---------|-----------|--------------------------------------|-----------------------------------|
/// | G1 3 MUL| TimeG1    | nu*du, nv*dv                         | du*dett, dv*dett, av*det          |
/// | H  4 ADD| TimeH     | au,av,aw = p - o;  n = nu*du + nv*dv | Du = du*dett - audet, Dv          |
/// | G2 2 MUL| TimeG2    | nu*au, nv*av                         | e1v*Du, e1u*Dv                    |
/// | X1 1 ADD| TimeX1    | det = n + dw                         | detu = e1v*Du - e1u*Dv            |
/// | G3 3 MUL| TimeG3    | limit = tfar*det, audet = au*det, nearest = tnear*det | e0u*Dv, e0v*Du   |
/// | X2 1 ADD| TimeX2    | m = nu*au + nv*av                    | detv = e0u*Dv - e0v*Du            |
/// | X3 1 ADD| TimeX3    | dett = m + aw                        | sum = detu + detv                 |
/// | CMP     | TimeEnd   | mag(limit) + 4 ulp < mag(dett)       | mag(sum) <= mag(det)              |
/// | CMP     | TimeEnd   | mag(dett) + 4 ulp < mag(nearest)     |                                   |
///
/// What is kept after each pass: `ti_ist1_verdict`, `ti_fp_pkg::CmpLatency` after TimeEnd.
module ti_ist1_pipe #(
  /// Width of what travels along untouched.
  parameter int unsigned TagWidth = 1,
  /// The test as published.
  parameter bit Np = ti_config_pkg::TriangleTest == ti_config_pkg::TriangleTestNp,
  localparam int unsigned TimeG1 = ti_fp_pkg::ChoiceLatency,
  localparam int unsigned TimeH = TimeG1 + ti_fp_pkg::MulLatency,
  localparam int unsigned TimeG2 = TimeH + ti_fp_pkg::AddLatency,
  localparam int unsigned TimeX1 = TimeG2 + ti_fp_pkg::MulLatency,
  localparam int unsigned TimeG3 = TimeX1 + ti_fp_pkg::AddLatency,
  localparam int unsigned TimeX2 = TimeG3 + ti_fp_pkg::MulLatency,
  localparam int unsigned TimeX3 = TimeX2 + ti_fp_pkg::AddLatency,
  localparam int unsigned TimeX4 = TimeX3 + ti_fp_pkg::AddLatency,
  localparam int unsigned TimeEnd = TimeX4 + (Np ? ti_fp_pkg::AddLatency : 0),
  localparam int unsigned TimeVerdict = TimeEnd + ti_fp_pkg::CmpLatency,
  localparam int unsigned Latency = TimeVerdict + 1
) (
  input logic clk_i,
  input logic rst_ni,

  input logic                                    valid_i,
  input logic                                    pass_b_i,
  input logic                     [TagWidth-1:0] tag_i,
  input logic                     [         1:0] axis_i,    // w
  input ti_pkg::vec3_t                           o_i,
  input ti_pkg::vec3_t                           d_i,
  input ti_pkg::fp_t                             tnear_i,   // (a), 0 or more
  input ti_pkg::fp_t                             tfar_i,    // (a)
  input ti_intersect_pkg::plane_t                plane_i,   // (a)
  input ti_intersect_pkg::bary_t                 bary_i,    // (b), as are the next four
  input ti_pkg::fp_t                             det_i,
  input ti_pkg::fp_t                             dett_i,
  input ti_pkg::fp_t                             audet_i,
  input ti_pkg::fp_t                             av_i,

  output logic                       valid_o,
  output logic                       pass_b_o,
  output logic                       keep_o,
  output logic        [TagWidth-1:0] tag_o,
  output ti_pkg::fp_t                det_o,
  output ti_pkg::fp_t                dett_o,
  output ti_pkg::fp_t                x_o,       // (a) au*det; (b) detu
  output ti_pkg::fp_t                y_o        // (a) av; (b) detv
);

  typedef ti_pkg::fp_t fp_t;
  localparam int unsigned W = ti_num_pkg::FpWidth;
  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;

  // Which pass is where.
  logic [TimeVerdict:0] valid_q, pass_b_q;
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) valid_q <= '0;
    else valid_q <= {valid_q[TimeVerdict-1:0], valid_i};
  end
  always_ff @(posedge clk_i) pass_b_q <= {pass_b_q[TimeVerdict-1:0], pass_b_i};

  // G1, H, G2, X1.
  fp_t x1, hu_g3, hv_g3, w_g3, np_g3, g2_0_g3, g2_1_g3;
  ti_ist1_front #(
    .Np(Np)
  ) u_front (
    .clk_i,
    .rst_ni,
    .valid_i ({valid_q[TimeX1-1:0], valid_i}),
    .pass_b_i({pass_b_q[TimeX1-1:0], pass_b_i}),
    .axis_i,
    .o_i,
    .d_i,
    .n_i     ({plane_i.nv[W-1:0], plane_i.nu[W-1:0]}),
    .p_i     ({plane_i.pw[W-1:0], plane_i.pv[W-1:0], plane_i.pu[W-1:0]}),
    .e1_i    ({bary_i.e1v[W-1:0], bary_i.e1u[W-1:0]}),
    .det_i,
    .dett_i,
    .audet_i,
    .av_i,
    .x1_o    (x1),
    .hu_o    (hu_g3),
    .hv_o    (hv_g3),
    .w_o     (w_g3),
    .np_o    (np_g3),
    .g2_0_o  (g2_0_g3),
    .g2_1_o  (g2_1_g3)
  );

  // TimeG3.
  fp_t g3_k0, g3_k1, g3_0, g3_1;
  logic b_g3;
  assign b_g3 = pass_b_q[TimeG3-1];
  // (a) tfar; (b) e0u, e0v.
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (TimeG3)
  ) u_to_g3 (
    .clk_i,
    .rst_ni,
    .data_i(pass_b_i ? {bary_i.e0v[W-1:0], bary_i.e0u[W-1:0]} : {fp_t'('0), tfar_i}),
    .data_o({g3_k1, g3_k0})
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_g3_0 (
    .clk_i,
    .rst_ni,
    .valid_i(valid_q[TimeG3-1]),
    .a_i(g3_k0),
    .b_i(b_g3 ? hv_g3 : x1),
    .valid_o(),
    .result_o(g3_0)
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_g3_1 (
    .clk_i,
    .rst_ni,
    .valid_i(valid_q[TimeG3-1]),
    .a_i(b_g3 ? g3_k1 : x1),
    .b_i(hu_g3),
    .valid_o(),
    .result_o(g3_1)
  );

  // (a) The near end, beside the others.
  fp_t nearest;
  if (ti_config_pkg::IntervalCull) begin : gen_near
    fp_t tnear_g3, nearest_x2;
    ti_delay #(
      .payload_t(fp_t),
      .Cycles   (TimeG3)
    ) u_tnear_to_g3 (
      .clk_i,
      .rst_ni,
      .data_i(tnear_i),
      .data_o(tnear_g3)
    );
    ti_fp_mul #(
      .ExpBits (E),
      .FracBits(M)
    ) u_g3_2 (
      .clk_i,
      .rst_ni,
      .valid_i(valid_q[TimeG3-1] && !b_g3),
      .a_i(tnear_g3),
      .b_i(x1),
      .valid_o(),
      .result_o(nearest_x2)
    );
    ti_delay #(
      .payload_t(fp_t),
      .Cycles   (TimeEnd - TimeX2)
    ) u_nearest_to_end (
      .clk_i,
      .rst_ni,
      .data_i(nearest_x2),
      .data_o(nearest)
    );
  end else begin : gen_no_near
    logic unused_tnear;
    assign unused_tnear = ^tnear_i;
    assign nearest = '0;
  end

  // TimeX2.
  fp_t g2_0_x2, g2_1_x2, x2;
  logic b_x2;
  assign b_x2 = pass_b_q[TimeX2-1];
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (TimeX2 - TimeG3)
  ) u_g2_to_x2 (
    .clk_i,
    .rst_ni,
    .data_i({g2_1_g3, g2_0_g3}),
    .data_o({g2_1_x2, g2_0_x2})
  );
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_x2 (
    .clk_i,
    .rst_ni,
    .valid_i(valid_q[TimeX2-1]),
    .a_i(b_x2 ? g3_0 : g2_0_x2),
    .b_i(b_x2 ? g3_1 : g2_1_x2),
    .negate_b_i(b_x2),
    .valid_o(),
    .result_o(x2)
  );

  // TimeX3.
  fp_t w_x3, x1_x3, x3;
  logic b_x3;
  assign b_x3 = pass_b_q[TimeX3-1];
  ti_delay #(
    .payload_t(fp_t),
    .Cycles   (TimeX3 - TimeG3)
  ) u_w_to_x3 (
    .clk_i,
    .rst_ni,
    .data_i(w_g3),
    .data_o(w_x3)
  );
  ti_delay #(
    .payload_t(fp_t),
    .Cycles   (TimeX3 - TimeG3)
  ) u_x1_to_x3 (
    .clk_i,
    .rst_ni,
    .data_i(x1),
    .data_o(x1_x3)
  );
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_x3 (
    .clk_i,
    .rst_ni,
    .valid_i(valid_q[TimeX3-1]),
    .a_i(b_x3 ? x1_x3 : x2),
    .b_i(b_x3 ? x2 : w_x3),
    .negate_b_i(1'b0),
    .valid_o(),
    .result_o(x3)
  );

  // TimeX4, of the test as published.
  fp_t x3_end;
  if (Np) begin : gen_x4
    fp_t np_x4, x3_late, x4;
    ti_delay #(
      .payload_t(fp_t),
      .Cycles   (TimeX4 - TimeG3)
    ) u_np_to_x4 (
      .clk_i,
      .rst_ni,
      .data_i(np_g3),
      .data_o(np_x4)
    );
    ti_fp_add #(
      .ExpBits (E),
      .FracBits(M)
    ) u_x4 (
      .clk_i,
      .rst_ni,
      .valid_i(valid_q[TimeX4-1] && !pass_b_q[TimeX4-1]),
      .a_i(np_x4),
      .b_i(x3),
      .negate_b_i(1'b1),
      .valid_o(),
      .result_o(x4)
    );
    ti_delay #(
      .payload_t(fp_t),
      .Cycles   (TimeEnd - TimeX4)
    ) u_x3_to_end (
      .clk_i,
      .rst_ni,
      .data_i(x3),
      .data_o(x3_late)
    );
    assign x3_end = pass_b_q[TimeEnd-1] ? x3_late : x4;
  end else begin : gen_no_x4
    logic unused_np;
    assign unused_np = ^np_g3;
    assign x3_end = x3;
  end

  // TimeEnd.
  fp_t x1_end, x2_end, limit, audet, av_end, given_end, dett_end;  // given: (a) tfar; (b) det
  logic [TagWidth-1:0] tag_end;
  logic b_end;
  assign b_end = pass_b_q[TimeEnd-1];
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (TimeEnd - TimeX3)
  ) u_x_to_end (
    .clk_i,
    .rst_ni,
    .data_i({x2, x1_x3}),
    .data_o({x2_end, x1_end})
  );
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (TimeEnd - TimeX2)
  ) u_g3_to_end (
    .clk_i,
    .rst_ni,
    .data_i({g3_1, g3_0}),
    .data_o({audet, limit})
  );
  ti_delay #(
    .payload_t(fp_t),
    .Cycles   (TimeEnd - TimeG3)
  ) u_av_to_end (
    .clk_i,
    .rst_ni,
    .data_i(hv_g3),
    .data_o(av_end)
  );
  ti_delay #(
    .payload_t(logic [2*W+TagWidth-1:0]),
    .Cycles   (TimeEnd)
  ) u_to_end (
    .clk_i,
    .rst_ni,
    .data_i({tag_i, dett_i, pass_b_i ? det_i : tfar_i}),
    .data_o({tag_end, dett_end, given_end})
  );

  logic keep;
  ti_ist1_verdict #(
    .IntervalCull(ti_config_pkg::IntervalCull)
  ) u_verdict (
    .clk_i,
    .rst_ni,
    .pass_b_i (b_end),
    .x1_i     (x1_end),
    .x2_i     (x2_end),
    .x3_i     (x3_end),
    .given_i  (given_end),
    .limit_i  (limit),
    .nearest_i(nearest),
    .keep_o   (keep)
  );

  typedef struct packed {
    fp_t                 det;
    fp_t                 dett;
    fp_t                 x;
    fp_t                 y;
    logic [TagWidth-1:0] tag;
  } beside_t;
  beside_t at_end, beside;
  always_comb begin
    at_end = '{
        det: b_end ? given_end : x1_end,
        dett: b_end ? dett_end : x3_end,
        x: b_end ? x1_end : audet,
        y: b_end ? x2_end : av_end,
        tag: tag_end
    };
  end
  ti_delay #(
    .payload_t(beside_t),
    .Cycles   (ti_fp_pkg::CmpLatency)
  ) u_beside (
    .clk_i,
    .rst_ni,
    .data_i(at_end),
    .data_o(beside)
  );

  always_ff @(posedge clk_i) begin
    if (valid_q[TimeVerdict-1]) begin
      keep_o                           <= keep;
      {det_o, dett_o, x_o, y_o, tag_o} <= beside;
    end
  end

  assign valid_o  = valid_q[TimeVerdict];
  assign pass_b_o = pass_b_q[TimeVerdict];

  `TI_ASSERT_KNOWN(ValidKnown, valid_o)

endmodule : ti_ist1_pipe
