// SPDX-License-Identifier: Apache-2.0

`include "ti_reset.svh"

/// One axis of the set-up of a ray: the inverse direction and the way to the two planes of the scene box.
///
/// inv = 1/d, t = (plane - o) * inv for the near and the far plane (slabs, Kay and Kajiya 1986), each with its own
/// origin: near is lo, hi for a negative direction.  An axis whose inverse is infinite is parallel: its near and far
/// mean nothing, and o lies outside when lo - o > 0 or hi - o < 0.  All values are rounded after each operation.
/// `Latency` cycles, one axis a cycle, no stall.  1 RCP, 2 ADD, 2 MUL.
module ti_rd_axis #(
  localparam int unsigned RcpLatency = ti_fp_pkg::rcp_latency(ti_num_pkg::FracBits),
  localparam int unsigned Latency = ti_fp_pkg::ChoiceLatency + RcpLatency + ti_fp_pkg::MulLatency
) (
  input logic clk_i,
  input logic rst_ni,

  input logic            valid_i,
  input ti_num_pkg::fp_t lo_i,      // planes of the box
  input ti_num_pkg::fp_t hi_i,
  input ti_num_pkg::fp_t near_o_i,  // origins
  input ti_num_pkg::fp_t far_o_i,
  input ti_num_pkg::fp_t d_i,

  output logic            valid_o,
  output ti_num_pkg::fp_t inv_o,
  output ti_num_pkg::fp_t near_o,
  output ti_num_pkg::fp_t far_o,
  output logic            parallel_o,
  output logic            outside_o    // means something only of a parallel axis
);

  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;
  localparam int unsigned W = ti_num_pkg::FpWidth;
  typedef ti_num_pkg::fp_t fp_t;

  if (RcpLatency < ti_fp_pkg::AddLatency) begin : gen_check
    $error("ti_rd_axis: the reciprocal must not be faster than the adder");
  end

  // Inverse, and beside it the way to the two planes.
  logic valid, rcp_valid, negative;
  fp_t inv, to_near, to_far, to_near_mul, to_far_mul;
  fp_t d, near_plane, far_plane, near_from, far_from;
  assign negative = d_i[W-1];
  ti_delay #(
    .payload_t(logic [5*W-1:0]),
    .Cycles   (ti_fp_pkg::ChoiceLatency)
  ) u_operands (
    .clk_i,
    .rst_ni,
    .data_i({d_i, negative ? {hi_i, lo_i} : {lo_i, hi_i}, near_o_i, far_o_i}),
    .data_o({d, near_plane, far_plane, near_from, far_from})
  );
  if (ti_fp_pkg::ChoiceLatency == 0) begin : gen_at_once
    assign valid = valid_i;
  end else begin : gen_registered
    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) valid <= 1'b0;
      else valid <= valid_i;
    end
  end

  ti_fp_rcp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_rcp (
    .clk_i,
    .rst_ni,
    .valid_i(valid),
    .a_i(d),
    .valid_o(rcp_valid),
    .result_o(inv)
  );
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_to_near (
    .clk_i,
    .rst_ni,
    .valid_i(valid),
    .a_i(near_plane),
    .b_i(near_from),
    .negate_b_i(1'b1),
    .valid_o(),
    .result_o(to_near)
  );
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_to_far (
    .clk_i,
    .rst_ni,
    .valid_i(valid),
    .a_i(far_plane),
    .b_i(far_from),
    .negate_b_i(1'b1),
    .valid_o(),
    .result_o(to_far)
  );
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (RcpLatency - ti_fp_pkg::AddLatency)
  ) u_to_mul (
    .clk_i,
    .rst_ni,
    .data_i({to_near, to_far}),
    .data_o({to_near_mul, to_far_mul})
  );

  logic parallel, outside;
  assign parallel = inv[W-2:0] == ti_num_pkg::Inf[W-2:0];
  // The near plane lies ahead, or the far one behind, as the sign of the direction has it.
  assign outside = (to_near_mul[W-1] == inv[W-1] && to_near_mul[W-2:0] != '0) ||
      (to_far_mul[W-1] != inv[W-1] && to_far_mul[W-2:0] != '0);

  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_near (
    .clk_i,
    .rst_ni,
    .valid_i(rcp_valid),
    .a_i(to_near_mul),
    .b_i(inv),
    .valid_o(valid_o),
    .result_o(near_o)
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_far (
    .clk_i,
    .rst_ni,
    .valid_i(rcp_valid),
    .a_i(to_far_mul),
    .b_i(inv),
    .valid_o(),
    .result_o(far_o)
  );

  ti_delay #(
    .payload_t(logic [W+1:0]),
    .Cycles   (ti_fp_pkg::MulLatency)
  ) u_inv (
    .clk_i,
    .rst_ni,
    .data_i({inv, parallel, outside}),
    .data_o({inv_o, parallel_o, outside_o})
  );

endmodule : ti_rd_axis
