// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The arithmetic of a traversal step: t = (split - o[axis]) * inv[axis], on 1 ADD and 1 MUL; of a thick ray (`Padded`)
/// the least and the greatest t, from the near and the far origin, on 2 of each.
///
/// One node a cycle, `Latency` cycles, no stall; the axis is chosen `ChoiceLatency` before the operators.  The node and the sign of the inverse come out beside t.
/// t is NaN exactly for a ray that is parallel to the plane and in it (0 * inf).  A leaf passes
/// through; its t means nothing.
module ti_kd_step #(
  /// Width of what travels along untouched.
  parameter int unsigned TagWidth = 1,
  /// Whether rays are thick; when not, the near origin alone counts.
  parameter bit Padded = 1'b0,
  localparam int unsigned ChoiceLatency = ti_fp_pkg::ChoiceLatency,
  localparam int unsigned Latency = ChoiceLatency + ti_fp_pkg::AddLatency + ti_fp_pkg::MulLatency
) (
  input logic clk_i,
  input logic rst_ni,

  input logic                                     valid_i,
  input logic                      [TagWidth-1:0] tag_i,
  input ti_kd_pkg::node_t                         node_i,
  input ti_traverse_pkg::origins_t                origins_i,
  input ti_pkg::vec3_t                            inv_i,

  output logic                            valid_o,
  output logic             [TagWidth-1:0] tag_o,
  output ti_kd_pkg::node_t                node_o,
  output logic                            negative_o,  // sign of the direction on the node's axis
  output ti_pkg::fp_t                     t_o,         // the least
  output ti_pkg::fp_t                     t_most_o     // the greatest
);

  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;

  // Of the axis of the node.
  typedef struct packed {
    ti_pkg::fp_t split;
    ti_pkg::fp_t least;
    ti_pkg::fp_t most;
    ti_pkg::fp_t inv;
  } operands_t;

  logic inner, to_plane_valid;
  logic [1:0] axis;
  logic [ChoiceLatency:0] add_valid;
  operands_t chosen, operands;
  ti_pkg::fp_t inv_mul, to_plane;

  assign inner = valid_i && node_i.axis != 2'd3;
  assign axis  = inner ? node_i.axis : 2'd0;
  always_comb begin
    chosen = '{
        split: node_i.value[E+M:0],
        least: origins_i.least[axis],
        most: origins_i.most[axis],
        inv: inv_i[axis]
    };
  end
  ti_delay #(
    .payload_t(operands_t),
    .Cycles   (ChoiceLatency)
  ) u_operands (
    .clk_i,
    .rst_ni,
    .data_i(chosen),
    .data_o(operands)
  );
  assign add_valid[0] = inner;
  if (ChoiceLatency > 0) begin : gen_registered
    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) add_valid[ChoiceLatency:1] <= '0;
      else add_valid[ChoiceLatency:1] <= add_valid[ChoiceLatency-1:0];
    end
  end

  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_to_plane (
    .clk_i,
    .rst_ni,
    .valid_i(add_valid[ChoiceLatency]),
    .a_i(operands.split),
    .b_i(operands.least),
    .negate_b_i(1'b1),
    .valid_o(to_plane_valid),
    .result_o(to_plane)
  );
  ti_delay #(
    .payload_t(ti_pkg::fp_t),
    .Cycles   (ti_fp_pkg::AddLatency)
  ) u_inv (
    .clk_i,
    .rst_ni,
    .data_i(operands.inv),
    .data_o(inv_mul)
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_t (
    .clk_i,
    .rst_ni,
    .valid_i(to_plane_valid),
    .a_i(to_plane),
    .b_i(inv_mul),
    .valid_o(),
    .result_o(t_o)
  );

  if (Padded) begin : gen_most
    logic far_valid;
    ti_pkg::fp_t far_to_plane;
    ti_fp_add #(
      .ExpBits (E),
      .FracBits(M)
    ) u_far_to_plane (
      .clk_i,
      .rst_ni,
      .valid_i(add_valid[ChoiceLatency]),
      .a_i(operands.split),
      .b_i(operands.most),
      .negate_b_i(1'b1),
      .valid_o(far_valid),
      .result_o(far_to_plane)
    );
    ti_fp_mul #(
      .ExpBits (E),
      .FracBits(M)
    ) u_t_most (
      .clk_i,
      .rst_ni,
      .valid_i(far_valid),
      .a_i(far_to_plane),
      .b_i(inv_mul),
      .valid_o(),
      .result_o(t_most_o)
    );
  end else begin : gen_one
    logic unused_far;
    assign unused_far = ^operands.most;
    assign t_most_o   = t_o;
  end

  logic [Latency-1:0] valid_q;
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) valid_q <= '0;
    else valid_q <= {valid_q[Latency-2:0], valid_i};
  end
  assign valid_o = valid_q[Latency-1];

  typedef struct packed {
    logic                negative;
    ti_kd_pkg::node_t    node;
    logic [TagWidth-1:0] tag;
  } along_t;
  along_t along;
  ti_delay #(
    .payload_t(along_t),
    .Cycles   (Latency)
  ) u_along (
    .clk_i,
    .rst_ni,
    .data_i('{negative: chosen.inv[ti_num_pkg::FpWidth-1], node: node_i, tag: tag_i}),
    .data_o(along)
  );
  assign negative_o = along.negative;
  assign node_o     = along.node;
  assign tag_o      = along.tag;

  `TI_ASSERT_KNOWN(ValidKnown, valid_o)

endmodule : ti_kd_step
