// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// Beats leave `ti_stage` in the order in which they came, each once and unchanged, a cycle later; it takes one while it
/// is empty or its beat leaves.
module ti_stage_formal #(
  parameter int unsigned Width = 1
) (
  input logic             clk_i,
  input logic             rst_ni,
  input logic             in_valid_i,
  input logic             in_ready_o,
  input logic [Width-1:0] in_data_i,
  input logic             out_valid_o,
  input logic             out_ready_i,
  input logic [Width-1:0] out_data_o
);
  `TI_STARTS_IN_RESET

  logic inside_q;
  logic [Width-1:0] data_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) inside_q <= 1'b0;
    else inside_q <= (in_valid_i && in_ready_o) || (inside_q && !out_ready_i);
    if (in_valid_i && in_ready_o) data_q <= in_data_i;
  end

  `TI_ASSERT(OutWhileOneIsInside, out_valid_o == inside_q)
  `TI_ASSERT(InWhileThereIsRoom, in_ready_o == (!inside_q || out_ready_i))
  `TI_ASSERT(ComesUnchanged, inside_q -> out_data_o == data_q)
  `TI_COVER(OneLeavesAsAnotherComes, in_valid_i && in_ready_o && out_valid_o && out_ready_i)
endmodule : ti_stage_formal

module ti_stage_top (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       in_valid_i,
  output logic       in_ready_o,
  input  logic [1:0] in_data_i,
  output logic       out_valid_o,
  input  logic       out_ready_i,
  output logic [1:0] out_data_o
);
  ti_stage #(.payload_t(logic [1:0])) u_unit (.*);
endmodule : ti_stage_top

bind ti_stage ti_stage_formal #(.Width($bits(payload_t))) u_formal (.*);
