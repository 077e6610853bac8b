// SPDX-License-Identifier: Apache-2.0

/// All operators of one format side by side on the same operands, for the C++ test bench.
///
/// The comparator's outputs belong to the operands of the same cycle; the others have the latencies
/// that the constant outputs state.
module ti_fp_top #(
  parameter int unsigned ExpBits = 8,
  parameter int unsigned FracBits = 23,
  localparam int unsigned Width = 1 + ExpBits + FracBits
) (
  input logic clk_i,
  input logic rst_ni,

  input logic             valid_i,
  input logic [Width-1:0] a_i,
  input logic [Width-1:0] b_i,

  output logic             add_valid_o,
  output logic [Width-1:0] add_result_o,
  output logic             sub_valid_o,
  output logic [Width-1:0] sub_result_o,
  output logic             mul_valid_o,
  output logic [Width-1:0] mul_result_o,
  output logic             rcp_valid_o,
  output logic [Width-1:0] rcp_result_o,

  output logic lt_o,
  output logic le_o,
  output logic eq_o,
  output logic unordered_o,

  output logic [7:0] add_latency_o,
  output logic [7:0] mul_latency_o,
  output logic [7:0] rcp_latency_o
);

  assign add_latency_o = 8'(ti_fp_pkg::AddLatency);
  assign mul_latency_o = 8'(ti_fp_pkg::MulLatency);
  assign rcp_latency_o = 8'(ti_fp_pkg::rcp_latency(FracBits));

  ti_fp_add #(
    .ExpBits (ExpBits),
    .FracBits(FracBits)
  ) u_add (
    .clk_i,
    .rst_ni,
    .valid_i,
    .a_i,
    .b_i,
    .negate_b_i(1'b0),
    .valid_o(add_valid_o),
    .result_o(add_result_o)
  );

  ti_fp_add #(
    .ExpBits (ExpBits),
    .FracBits(FracBits)
  ) u_sub (
    .clk_i,
    .rst_ni,
    .valid_i,
    .a_i,
    .b_i,
    .negate_b_i(1'b1),
    .valid_o(sub_valid_o),
    .result_o(sub_result_o)
  );

  ti_fp_mul #(
    .ExpBits (ExpBits),
    .FracBits(FracBits)
  ) u_mul (
    .clk_i,
    .rst_ni,
    .valid_i,
    .a_i,
    .b_i,
    .valid_o (mul_valid_o),
    .result_o(mul_result_o)
  );

  ti_fp_rcp #(
    .ExpBits (ExpBits),
    .FracBits(FracBits)
  ) u_rcp (
    .clk_i,
    .rst_ni,
    .valid_i,
    .a_i,
    .valid_o (rcp_valid_o),
    .result_o(rcp_result_o)
  );

  ti_fp_cmp #(
    .ExpBits (ExpBits),
    .FracBits(FracBits)
  ) u_cmp (
    .a_i,
    .b_i,
    .lt_o,
    .eq_o,
    .le_o,
    .unordered_o
  );

endmodule : ti_fp_top
