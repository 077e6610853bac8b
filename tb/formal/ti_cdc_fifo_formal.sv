// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// Beats leave `ti_cdc_fifo` in the order in which they came, each once and unchanged, and none is written over.  With
/// one clock on both sides a beat with none in front of it is at the output `SyncStages` + 2 cycles after it came, and
/// there is room as many cycles after an entry has become free.
module ti_cdc_fifo_formal #(
  parameter int unsigned Width = 1,
  parameter int unsigned Depth = 2,
  parameter int unsigned SyncStages = 2
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

  // Entries and the register at the output.
  localparam int unsigned Room = Depth + 1;
  localparam int unsigned CountWidth = $clog2(Room + 1);
  localparam int unsigned Latency = SyncStages + 2;

  typedef logic [Width-1:0] word_t;
  word_t pushed;
  logic push, pop;
  assign push   = in_valid_i && in_ready_o;
  assign pop    = out_valid_o && out_ready_i;
  assign pushed = in_data_i;
  `include "watched.svh"

  // Cycles for which beats have been inside and none at the output, and for which there has been no room although an
  // entry behind the output has been free.
  logic [31:0] behind;
  assign behind = 32'(inside_q) - 32'(out_valid_o);
  localparam int unsigned WaitWidth = $clog2(Latency + 1);
  logic [WaitWidth-1:0] hidden_q, closed_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni || out_valid_o || inside_q == '0) hidden_q <= '0;
    else if (32'(hidden_q) != Latency) hidden_q <= hidden_q + 1'b1;
    if (!rst_ni || in_ready_o || behind == Depth) closed_q <= '0;
    else if (32'(closed_q) != Latency) closed_q <= closed_q + 1'b1;
  end

  `TI_ASSERT(NeverMoreThanItHolds, 32'(inside_q) <= Room)
  `TI_ASSERT(OutOnlyWhatIsInside, out_valid_o -> inside_q != '0)
  `TI_ASSERT(TakesNoneWhenFull, 32'(inside_q) == Room -> !in_ready_o)
  `TI_ASSERT(WatchedComesUnchanged, its_turn && out_valid_o -> out_data_o == word_q)
  `TI_ASSERT_NEXT(OutHeldUntilTaken, out_valid_o && !out_ready_i, out_valid_o && $stable(out_data_o
                                                                                            ))
  `TI_ASSERT(ComesWhenItsTimeIsUp, 32'(hidden_q) == Latency - 1 -> out_valid_o)
  `TI_ASSERT(RoomWhenItsTimeIsUp, 32'(closed_q) == Latency - 1 -> in_ready_o)
  `TI_COVER(WatchedLeavesAFullOne, its_turn && pop && 32'(inside_q) == Room)
  `TI_COVER(WaitsForThePointer, 32'(hidden_q) == Latency - 1)
endmodule : ti_cdc_fifo_formal

module ti_cdc_fifo_top #(
  parameter int unsigned Depth = 2,
  parameter int unsigned SyncStages = 2
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
  ti_cdc_fifo #(
    .payload_t (logic [1:0]),
    .Depth     (Depth),
    .SyncStages(SyncStages)
  ) u_unit (
    .in_clk_i  (clk_i),
    .in_rst_ni (rst_ni),
    .out_clk_i (clk_i),
    .out_rst_ni(rst_ni),
    .*
  );
  ti_cdc_fifo_formal #(
    .Width     (2),
    .Depth     (Depth),
    .SyncStages(SyncStages)
  ) u_formal (
    .*
  );
endmodule : ti_cdc_fifo_top
