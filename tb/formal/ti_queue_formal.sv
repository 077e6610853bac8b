// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// Beats leave `ti_queue` in the order in which they came, each once and unchanged; none is lost while its writer pushes
/// no more than `Depth` that have not left.
module ti_queue_formal #(
  parameter int unsigned Width = 1,
  parameter int unsigned Depth = 2
) (
  input logic             clk_i,
  input logic             rst_ni,
  input logic             push_i,
  input logic [Width-1:0] push_data_i,
  input logic             out_valid_o,
  input logic             out_ready_i,
  input logic [Width-1:0] out_data_o
);
  `TI_STARTS_IN_RESET

  localparam int unsigned CountWidth = $clog2(Depth + 1);

  typedef logic [Width-1:0] word_t;
  word_t pushed;
  logic push, pop;
  assign push   = push_i;
  assign pop    = out_valid_o && out_ready_i;
  assign pushed = push_data_i;
  `include "watched.svh"

  // Writers push slots, of which there are `Depth`, and none that stands here already.
  `TI_ASSUME(WriterCounts, push_i -> inside_q != CountWidth'(Depth))

  `TI_ASSERT(OutWhileOneIsInside, out_valid_o == (inside_q != '0))
  `TI_ASSERT(WatchedComesUnchanged, its_turn -> out_valid_o && out_data_o == word_q)
  `TI_COVER(WatchedLeavesAFullOne, its_turn && pop && inside_q == CountWidth'(Depth))
endmodule : ti_queue_formal

module ti_queue_top #(
  parameter int unsigned Depth = 2
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       push_i,
  input  logic [1:0] push_data_i,
  output logic       out_valid_o,
  input  logic       out_ready_i,
  output logic [1:0] out_data_o
);
  ti_queue #(
    .payload_t(logic [1:0]),
    .Depth    (Depth)
  ) u_unit (
    .*
  );
endmodule : ti_queue_top

bind ti_queue ti_queue_formal #(
  .Width($bits(payload_t)),
  .Depth(Depth)
) u_formal (.*);
