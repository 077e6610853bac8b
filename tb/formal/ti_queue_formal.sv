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

  // Beats inside, and one of them that is watched: how many leave before it.
  logic pop, pick, watched_q;
  logic [CountWidth-1:0] inside_q, ahead_q;
  logic [Width-1:0] data_q;

  assign pop = out_valid_o && out_ready_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      inside_q  <= '0;
      watched_q <= 1'b0;
    end else begin
      inside_q <= inside_q + CountWidth'(push_i) - CountWidth'(pop);
      if (!watched_q) watched_q <= push_i && pick;
      else if (pop && ahead_q == '0) watched_q <= 1'b0;
    end
  end
  always_ff @(posedge clk_i) begin
    if (!watched_q) begin
      ahead_q <= inside_q - CountWidth'(pop);
      data_q  <= push_data_i;
    end else if (pop) begin
      ahead_q <= ahead_q - 1'b1;
    end
  end

  // Writers push slots, of which there are `Depth`, and none that stands here already.
  `TI_ASSUME(WriterCounts, push_i -> inside_q != CountWidth'(Depth))

  `TI_ASSERT(OutWhileOneIsInside, out_valid_o == (inside_q != '0))
  `TI_ASSERT(WatchedIsInside, watched_q -> ahead_q < inside_q)
  `TI_ASSERT(WatchedComesUnchanged,
             watched_q && ahead_q == '0 -> out_valid_o && out_data_o == data_q)
  `TI_COVER(WatchedLeavesAFullOne,
            watched_q && pop && ahead_q == '0 && inside_q == CountWidth'(Depth))
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
