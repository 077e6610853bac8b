// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The corners of a triangle seen along the ray, and whether the ray passes between them (Woop, Benthin, Wald 2013),
/// on 18 ADD and 12 MUL.
///
/// | step     | starts at | values                                                                  |
/// |----------|-----------|-------------------------------------------------------------------------|
/// | H  9 ADD | 0         | A, B, C = corners - o                                                   |
/// | G1 6 MUL | TimeG1    | sx A.z, sy A.z, ...                                                     |
/// | X1 6 ADD | TimeX1    | Ax = A.x - sx A.z, Ay = A.y - sy A.z, ...                               |
/// | G2 6 MUL | TimeG2    | Cx By, Cy Bx, Ax Cy, Ay Cx, Bx Ay, By Ax                                |
/// | X2 3 ADD | TimeX2    | U = Cx By - Cy Bx, V = Ax Cy - Ay Cx, W = Bx Ay - By Ax                 |
/// | keep     | TimeEnd   | none of U, V, W is NaN, and no two of them have opposite signs          |
///
/// A corner has the same (x, y) in each of its triangles, and rounding is monotone, so that fl(ab) - fl(cd) never has
/// the wrong sign, only a false 0, which counts as inside: no ray passes between two triangles of an edge or a
/// vertex, in any format.  A product and a difference must not be fused.
/// One test a cycle, latency `Latency`, no stall.
module ti_woop_pipe #(
  /// Width of what travels along untouched.
  parameter  int unsigned TagWidth = 1,
  localparam int unsigned TimeG1   = ti_fp_pkg::AddLatency,
  localparam int unsigned TimeX1   = TimeG1 + ti_fp_pkg::MulLatency,
  localparam int unsigned TimeG2   = TimeX1 + ti_fp_pkg::AddLatency,
  localparam int unsigned TimeX2   = TimeG2 + ti_fp_pkg::MulLatency,
  localparam int unsigned TimeEnd  = TimeX2 + ti_fp_pkg::AddLatency,
  localparam int unsigned Latency  = TimeEnd + 1
) (
  input logic clk_i,
  input logic rst_ni,

  input logic                         valid_i,
  input logic          [TagWidth-1:0] tag_i,
  input logic          [         1:0] z_i,       // axis of the largest |d|
  input ti_pkg::vec3_t                o_i,
  input ti_pkg::vec3_t                shear_i,   // sx, sy, sz
  input ti_pkg::vec3_t [         2:0] corners_i,

  output logic                                    valid_o,
  output logic                                    keep_o,
  output logic                     [TagWidth-1:0] tag_o,
  output ti_intersect_pkg::edges_t                edges_o
);

  localparam int unsigned W = ti_num_pkg::FpWidth;
  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;
  typedef ti_pkg::fp_t fp_t;

  logic [TimeEnd:0] valid_q;
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) valid_q <= '0;
    else valid_q <= {valid_q[TimeEnd-1:0], valid_i};
  end

  // Components in the order x, y, z of the shear.
  function automatic ti_pkg::vec3_t seen(ti_pkg::vec3_t v, logic [1:0] z);
    unique case (z)
      2'd0: return {v[0], v[2], v[1]};
      2'd1: return {v[1], v[0], v[2]};
      default: return {v[2], v[1], v[0]};
    endcase
  endfunction

  ti_pkg::vec3_t o;
  fp_t [1:0] shear_g1;
  assign o = seen(o_i, z_i);
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (TimeG1)
  ) u_shear (
    .clk_i,
    .rst_ni,
    .data_i(shear_i[1:0]),
    .data_o(shear_g1)
  );

  ti_pkg::vec3_t x, y, z_end;
  for (genvar k = 0; k < 3; k++) begin : gen_corner
    ti_pkg::vec3_t p, a;
    fp_t [1:0] a_x1;
    assign p = seen(corners_i[k], z_i);
    for (genvar i = 0; i < 3; i++) begin : gen_axis
      ti_fp_add #(
        .ExpBits (E),
        .FracBits(M)
      ) u_h (
        .clk_i,
        .rst_ni,
        .valid_i,
        .a_i(p[i]),
        .b_i(o[i]),
        .negate_b_i(1'b1),
        .valid_o(),
        .result_o(a[i])
      );
    end
    ti_delay #(
      .payload_t(logic [2*W-1:0]),
      .Cycles   (TimeX1 - TimeG1)
    ) u_a_to_x1 (
      .clk_i,
      .rst_ni,
      .data_i(a[1:0]),
      .data_o(a_x1)
    );
    ti_delay #(
      .payload_t(fp_t),
      .Cycles   (TimeEnd - TimeG1)
    ) u_z (
      .clk_i,
      .rst_ni,
      .data_i(a[2]),
      .data_o(z_end[k])
    );

    fp_t [1:0] moved, xy;
    for (genvar i = 0; i < 2; i++) begin : gen_shear
      ti_fp_mul #(
        .ExpBits (E),
        .FracBits(M)
      ) u_g1 (
        .clk_i,
        .rst_ni,
        .valid_i(valid_q[TimeG1-1]),
        .a_i(shear_g1[i]),
        .b_i(a[2]),
        .valid_o(),
        .result_o(moved[i])
      );
      ti_fp_add #(
        .ExpBits (E),
        .FracBits(M)
      ) u_x1 (
        .clk_i,
        .rst_ni,
        .valid_i(valid_q[TimeX1-1]),
        .a_i(a_x1[i]),
        .b_i(moved[i]),
        .negate_b_i(1'b1),
        .valid_o(),
        .result_o(xy[i])
      );
    end
    assign x[k] = xy[0];
    assign y[k] = xy[1];
  end

  // The edge opposite to each corner.
  ti_pkg::vec3_t weight;
  logic [2:0] positive, negative, nan;
  for (genvar k = 0; k < 3; k++) begin : gen_edge
    localparam int unsigned B = (k + 1) % 3;
    localparam int unsigned C = (k + 2) % 3;
    fp_t left, right;
    logic zero;
    ti_fp_mul #(
      .ExpBits (E),
      .FracBits(M)
    ) u_left (
      .clk_i,
      .rst_ni,
      .valid_i(valid_q[TimeG2-1]),
      .a_i(x[C]),
      .b_i(y[B]),
      .valid_o(),
      .result_o(left)
    );
    ti_fp_mul #(
      .ExpBits (E),
      .FracBits(M)
    ) u_right (
      .clk_i,
      .rst_ni,
      .valid_i(valid_q[TimeG2-1]),
      .a_i(y[C]),
      .b_i(x[B]),
      .valid_o(),
      .result_o(right)
    );
    ti_fp_add #(
      .ExpBits (E),
      .FracBits(M)
    ) u_x2 (
      .clk_i,
      .rst_ni,
      .valid_i(valid_q[TimeX2-1]),
      .a_i(left),
      .b_i(right),
      .negate_b_i(1'b1),
      .valid_o(),
      .result_o(weight[k])
    );
    ti_fp_class #(
      .ExpBits (E),
      .FracBits(M)
    ) u_class (
      .x_i     (weight[k]),
      .zero_o  (zero),
      .finite_o(),
      .normal_o(),
      .nan_o   (nan[k])
    );
    assign positive[k] = !zero && !weight[k][W-1];
    assign negative[k] = !zero && weight[k][W-1];
  end

  typedef struct packed {
    logic [TagWidth-1:0] tag;
    fp_t                 sz;
  } along_t;
  along_t along;
  ti_delay #(
    .payload_t(along_t),
    .Cycles   (TimeEnd)
  ) u_along (
    .clk_i,
    .rst_ni,
    .data_i('{tag: tag_i, sz: shear_i[2]}),
    .data_o(along)
  );

  always_ff @(posedge clk_i) begin
    if (valid_q[TimeEnd-1]) begin
      keep_o  <= nan == '0 && (positive == '0 || negative == '0);
      tag_o   <= along.tag;
      edges_o <= '{weight: weight, z: z_end, sz: along.sz};
    end
  end
  assign valid_o = valid_q[TimeEnd];

  `TI_ASSERT_KNOWN(ValidKnown, valid_o)

endmodule : ti_woop_pipe
