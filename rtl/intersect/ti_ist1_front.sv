// SPDX-License-Identifier: Apache-2.0

/// First half of `ti_ist1_pipe`: the products and sums G1, H, G2 and X1.
///
/// Times, operators and what each gives in which pass are in the table of `ti_ist1_pipe`; all outputs stand at TimeG3.
/// `valid_i` and `pass_b_i` have the pass of each cycle of the way, that of time 0 in front.
module ti_ist1_front #(
  /// The test as published.
  parameter bit Np = ti_config_pkg::TriangleTest == ti_config_pkg::TriangleTestNp,
  localparam int unsigned TimeG1 = ti_fp_pkg::ChoiceLatency,
  localparam int unsigned TimeH = TimeG1 + ti_fp_pkg::MulLatency,
  localparam int unsigned TimeG2 = TimeH + ti_fp_pkg::AddLatency,
  localparam int unsigned TimeX1 = TimeG2 + ti_fp_pkg::MulLatency,
  localparam int unsigned TimeG3 = TimeX1 + ti_fp_pkg::AddLatency
) (
  input logic clk_i,
  input logic rst_ni,

  input logic          [TimeX1:0] valid_i,
  input logic          [TimeX1:0] pass_b_i,
  input logic          [     1:0] axis_i,    // w
  input ti_pkg::vec3_t            o_i,
  input ti_pkg::vec3_t            d_i,
  input ti_pkg::fp_t   [     1:0] n_i,       // (a) nu, nv
  input ti_pkg::vec3_t            p_i,       // (a)
  input ti_pkg::fp_t   [     1:0] e1_i,      // (b) e1u, e1v; as are the next four
  input ti_pkg::fp_t              det_i,
  input ti_pkg::fp_t              dett_i,
  input ti_pkg::fp_t              audet_i,
  input ti_pkg::fp_t              av_i,

  output ti_pkg::fp_t x1_o,    // (a) det; (b) detu
  output ti_pkg::fp_t hu_o,    // (a) au; (b) Du
  output ti_pkg::fp_t hv_o,    // (a) av; (b) Dv
  output ti_pkg::fp_t w_o,     // (a) aw; of the test as published ow
  output ti_pkg::fp_t np_o,    // (a) n.p, of the test as published
  output ti_pkg::fp_t g2_0_o,  // (a) nu*au
  output ti_pkg::fp_t g2_1_o   // (a) nv*av
);

  typedef ti_pkg::fp_t fp_t;
  localparam int unsigned W = ti_num_pkg::FpWidth;
  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;

  logic b_0;
  assign b_0 = pass_b_i[0];

  // Time 0, components in the order u, v, w.
  ti_pkg::vec3_t o, d;
  always_comb begin
    unique case (axis_i)
      2'd0: begin
        o = {o_i[0], o_i[2], o_i[1]};
        d = {d_i[0], d_i[2], d_i[1]};
      end
      2'd1: begin
        o = {o_i[1], o_i[0], o_i[2]};
        d = {d_i[1], d_i[0], d_i[2]};
      end
      default: begin
        o = {o_i[2], o_i[1], o_i[0]};
        d = {d_i[2], d_i[1], d_i[0]};
      end
    endcase
  end

  // What is multiplied, chosen by pass and registered `ChoiceLatency` times: TimeG1.
  fp_t [2:0] g1_a, g1_b, g1;
  ti_delay #(
    .payload_t(logic [6*W-1:0]),
    .Cycles   (TimeG1)
  ) u_to_g1 (
    .clk_i,
    .rst_ni,
    .data_i({av_i, b_0 ? d[1:0] : n_i, det_i, b_0 ? {2{dett_i}} : d[1:0]}),
    .data_o({g1_a, g1_b})
  );

  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_g1_0 (
    .clk_i,
    .rst_ni,
    .valid_i(valid_i[TimeG1]),
    .a_i(g1_a[0]),
    .b_i(g1_b[0]),
    .valid_o(),
    .result_o(g1[0])
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_g1_1 (
    .clk_i,
    .rst_ni,
    .valid_i(valid_i[TimeG1]),
    .a_i(g1_a[1]),
    .b_i(g1_b[1]),
    .valid_o(),
    .result_o(g1[1])
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_g1_2 (
    .clk_i,
    .rst_ni,
    .valid_i(valid_i[TimeG1] && pass_b_i[TimeG1]),
    .a_i(g1_a[2]),
    .b_i(g1_b[2]),
    .valid_o(),
    .result_o(g1[2])
  );

  // TimeH: (a) p and o, (b) au*det.
  fp_t [2:0] p_h, o_h;
  ti_delay #(
    .payload_t(logic [6*W-1:0]),
    .Cycles   (TimeH)
  ) u_to_h (
    .clk_i,
    .rst_ni,
    .data_i({o, b_0 ? {2{fp_t'('0)}} : p_i[2:1], b_0 ? audet_i : p_i[0]}),
    .data_o({o_h, p_h})
  );

  logic at_h, b_h;
  assign at_h = valid_i[TimeH];
  assign b_h  = pass_b_i[TimeH];

  fp_t h_u, h_v, h_n;  // (a) au, av, n; (b) Du, Dv
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_h_u (
    .clk_i,
    .rst_ni,
    .valid_i(at_h),
    .a_i(b_h ? g1[0] : p_h[0]),
    .b_i(b_h ? p_h[0] : o_h[0]),
    .negate_b_i(1'b1),
    .valid_o(),
    .result_o(h_u)
  );
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_h_v (
    .clk_i,
    .rst_ni,
    .valid_i(at_h),
    .a_i(b_h ? g1[1] : p_h[1]),
    .b_i(b_h ? g1[2] : o_h[1]),
    .negate_b_i(1'b1),
    .valid_o(),
    .result_o(h_v)
  );
  if (Np) begin : gen_no_aw
    ti_delay #(
      .payload_t(logic [2*W-1:0]),
      .Cycles   (TimeG3 - TimeH)
    ) u_to_g3 (
      .clk_i,
      .rst_ni,
      .data_i({p_h[2], o_h[2]}),
      .data_o({np_o, w_o})
    );
  end else begin : gen_aw
    fp_t h_w;
    ti_fp_add #(
      .ExpBits (E),
      .FracBits(M)
    ) u_h_w (
      .clk_i,
      .rst_ni,
      .valid_i(at_h && !b_h),
      .a_i(p_h[2]),
      .b_i(o_h[2]),
      .negate_b_i(1'b1),
      .valid_o(),
      .result_o(h_w)
    );
    ti_delay #(
      .payload_t(fp_t),
      .Cycles   (TimeG3 - TimeG2)
    ) u_w_to_g3 (
      .clk_i,
      .rst_ni,
      .data_i(h_w),
      .data_o(w_o)
    );
    assign np_o = '0;
  end
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_h_n (
    .clk_i,
    .rst_ni,
    .valid_i(at_h && !b_h),
    .a_i(g1[0]),
    .b_i(g1[1]),
    .negate_b_i(1'b0),
    .valid_o(),
    .result_o(h_n)
  );

  // TimeG2.
  fp_t g2_k0, g2_k1;  // (a) nu, nv; (b) e1v, e1u
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (TimeG2)
  ) u_to_g2 (
    .clk_i,
    .rst_ni,
    .data_i(b_0 ? {e1_i[0], e1_i[1]} : n_i),
    .data_o({g2_k1, g2_k0})
  );

  fp_t g2_0, g2_1, g2_a0, g2_a1;
  if (Np) begin : gen_from_o
    fp_t [1:0] o_g2;
    ti_delay #(
      .payload_t(logic [2*W-1:0]),
      .Cycles   (TimeG2 - TimeH)
    ) u_o_to_g2 (
      .clk_i,
      .rst_ni,
      .data_i(o_h[1:0]),
      .data_o(o_g2)
    );
    assign {g2_a1, g2_a0} = pass_b_i[TimeG2] ? {h_v, h_u} : o_g2;
  end else begin : gen_from_a
    assign {g2_a1, g2_a0} = {h_v, h_u};
  end
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_g2_0 (
    .clk_i,
    .rst_ni,
    .valid_i(valid_i[TimeG2]),
    .a_i(g2_k0),
    .b_i(g2_a0),
    .valid_o(),
    .result_o(g2_0)
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_g2_1 (
    .clk_i,
    .rst_ni,
    .valid_i(valid_i[TimeG2]),
    .a_i(g2_k1),
    .b_i(g2_a1),
    .valid_o(),
    .result_o(g2_1)
  );

  // TimeX1.
  fp_t n_x1, dw_x1;
  logic b_x1;
  assign b_x1 = pass_b_i[TimeX1];
  ti_delay #(
    .payload_t(fp_t),
    .Cycles   (TimeX1 - TimeG2)
  ) u_n_to_x1 (
    .clk_i,
    .rst_ni,
    .data_i(h_n),
    .data_o(n_x1)
  );
  ti_delay #(
    .payload_t(fp_t),
    .Cycles   (TimeX1)
  ) u_dw_to_x1 (
    .clk_i,
    .rst_ni,
    .data_i(d[2]),
    .data_o(dw_x1)
  );
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_x1 (
    .clk_i,
    .rst_ni,
    .valid_i(valid_i[TimeX1]),
    .a_i(b_x1 ? g2_0 : n_x1),
    .b_i(b_x1 ? g2_1 : dw_x1),
    .negate_b_i(b_x1),
    .valid_o(),
    .result_o(x1_o)
  );

  // TimeG3: what else is used from there on.
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (TimeG3 - TimeG2)
  ) u_h_to_g3 (
    .clk_i,
    .rst_ni,
    .data_i({h_v, h_u}),
    .data_o({hv_o, hu_o})
  );
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (TimeG3 - TimeX1)
  ) u_g2_to_g3 (
    .clk_i,
    .rst_ni,
    .data_i({g2_1, g2_0}),
    .data_o({g2_1_o, g2_0_o})
  );

endmodule : ti_ist1_front
