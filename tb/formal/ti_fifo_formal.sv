// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// Beats leave `ti_fifo` in the order in which they came, each once and unchanged; it takes `Depth` of them, and the one
/// in front is at the output from the cycle after it came.
module ti_fifo_formal #(
  parameter int unsigned Width = 1,
  parameter int unsigned Depth = 2
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

  localparam int unsigned CountWidth = $clog2(Depth + 1);

  typedef logic [Width-1:0] word_t;
  word_t pushed;
  logic push, pop;
  assign push   = in_valid_i && in_ready_o;
  assign pop    = out_valid_o && out_ready_i;
  assign pushed = in_data_i;
  `include "watched.svh"

  `TI_ASSERT(OutWhileOneIsInside, out_valid_o == (inside_q != '0))
  `TI_ASSERT(InWhileThereIsRoom, in_ready_o == (inside_q != CountWidth'(Depth)))
  `TI_ASSERT(WatchedComesUnchanged, its_turn -> out_valid_o && out_data_o == word_q)
  `TI_COVER(WatchedLeavesAFullOne, its_turn && pop && inside_q == CountWidth'(Depth))
endmodule : ti_fifo_formal

module ti_fifo_top #(
  parameter int unsigned Depth = 2
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       in_valid_i,
  output logic       in_ready_o,
  input  logic [1:0] in_data_i,
  output logic       out_valid_o,
  input  logic       out_ready_i,
  output logic [1:0] out_data_o
);
  ti_fifo #(
    .payload_t(logic [1:0]),
    .Depth    (Depth)
  ) u_unit (
    .*
  );
endmodule : ti_fifo_top

bind ti_fifo ti_fifo_formal #(
  .Width($bits(payload_t)),
  .Depth(Depth)
) u_formal (.*);
