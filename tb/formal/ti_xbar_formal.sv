// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// A beat that `ti_xbar` grants comes out of the output that it named, once, unchanged and in the order of that output's
/// grants, and nothing else does; a beat that waits is granted after at most `NumIn` - 1 others of its output.
module ti_xbar_formal #(
  parameter int unsigned Width = 1,
  parameter int unsigned NumIn = 2,
  parameter int unsigned NumOut = 2,
  localparam int unsigned InWidth = (NumIn > 1) ? $clog2(NumIn) : 1,
  localparam int unsigned DestWidth = (NumOut > 1) ? $clog2(NumOut) : 1
) (
  input logic                             clk_i,
  input logic                             rst_ni,
  input logic [ NumIn-1:0]                in_valid_i,
  input logic [ NumIn-1:0]                in_ready_o,
  input logic [ NumIn-1:0]                in_lost_o,
  input logic [ NumIn-1:0][    Width-1:0] data_i,
  input logic [ NumIn-1:0][DestWidth-1:0] in_dest_i,
  input logic [NumOut-1:0]                out_valid_o,
  input logic [NumOut-1:0]                out_ready_i,
  input logic [NumOut-1:0][    Width-1:0] out_data_o
);
  `TI_STARTS_IN_RESET

  // One input and one output, whichever, and the grants of that output.
  logic [  InWidth-1:0] who;
  logic [DestWidth-1:0] where;
  `TI_SYMBOL(who)
  `TI_SYMBOL(where)
  BothExist :
  assume property (@(posedge clk_i) (32'(who) < NumIn && 32'(where) < NumOut));
  logic [NumIn-1:0] asks, granted;
  for (genvar i = 0; i < NumIn; i++) begin : gen_in
    assign asks[i]    = in_valid_i[i] && in_dest_i[i] == where;
    assign granted[i] = in_ready_o[i] && asks[i];
  end

  // How many others were granted while `who` asked.
  logic [InWidth-1:0] others_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni || !asks[who] || granted[who]) others_q <= '0;
    else if (granted != '0) others_q <= others_q + 1'b1;
  end

  // Beats on their way to `where`, and one of them that is watched, which came from `who`.
  logic push, pop, pick, watched_q;
  logic [1:0] inside_q, ahead_q;
  logic [Width-1:0] data_q;
  assign push = granted != '0;
  assign pop  = out_valid_o[where] && out_ready_i[where];
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      inside_q  <= '0;
      watched_q <= 1'b0;
    end else begin
      inside_q <= inside_q + 2'(push) - 2'(pop);
      if (!watched_q) watched_q <= granted[who] && pick;
      else if (pop && ahead_q == '0) watched_q <= 1'b0;
    end
  end
  always_ff @(posedge clk_i) begin
    if (!watched_q) begin
      ahead_q <= inside_q - 2'(pop);
      data_q  <= data_i[who];
    end else if (pop) begin
      ahead_q <= ahead_q - 1'b1;
    end
  end

  `TI_ASSERT(GrantsOneOfAnOutput, $onehot0(granted))
  `TI_ASSERT(GrantsWhoAsks, (in_ready_o & ~in_valid_i) == '0)
  `TI_ASSERT(GrantsWhileThereIsRoom, push == (asks != '0 && inside_q != 2'd2))
  `TI_ASSERT(LostToAnother, asks[who] -> in_lost_o[who] == (push && !granted[who]))
  `TI_ASSERT(LostOnlyWhileItAsks, in_lost_o[who] -> in_valid_i[who])
  `TI_ASSERT(FairWithinItsPeers, 32'(others_q) < NumIn)
  `TI_ASSERT(ThenItsTurn, push && asks[who] && 32'(others_q) == NumIn - 1 -> granted[who])
  `TI_ASSERT(OutWhileOneIsInside, out_valid_o[where] == (inside_q != '0))
  `TI_ASSERT(WatchedIsInside, watched_q -> ahead_q < inside_q)
  `TI_ASSERT(WatchedComesUnchanged,
             watched_q && ahead_q == '0 -> out_valid_o[where] && out_data_o[where] == data_q)
  `TI_COVER(WaitsForAllOthers, granted[who] && 32'(others_q) == NumIn - 1)
  `TI_COVER(TwoOutputsAtOnce, NumIn == 1 || NumOut == 1 || (push && (in_ready_o & ~granted) != '0))
endmodule : ti_xbar_formal

module ti_xbar_top #(
  parameter int unsigned NumIn = 2,
  parameter int unsigned NumOut = 2,
  localparam int unsigned DestWidth = (NumOut > 1) ? $clog2(NumOut) : 1
) (
  input  logic                             clk_i,
  input  logic                             rst_ni,
  input  logic [ NumIn-1:0]                in_valid_i,
  output logic [ NumIn-1:0]                in_ready_o,
  output logic [ NumIn-1:0]                in_lost_o,
  input  logic [ NumIn-1:0][          1:0] data_i,
  input  logic [ NumIn-1:0][DestWidth-1:0] in_dest_i,
  output logic [NumOut-1:0]                out_valid_o,
  input  logic [NumOut-1:0]                out_ready_i,
  output logic [NumOut-1:0][          1:0] out_data_o
);
  logic [1:0] in_data[NumIn], out_data[NumOut];
  for (genvar i = 0; i < NumIn; i++) begin : gen_in
    assign in_data[i] = data_i[i];
  end
  for (genvar o = 0; o < NumOut; o++) begin : gen_out
    assign out_data_o[o] = out_data[o];
  end
  ti_xbar #(
    .payload_t(logic [1:0]),
    .NumIn    (NumIn),
    .NumOut   (NumOut)
  ) u_unit (
    .in_data_i (in_data),
    .out_data_o(out_data),
    .*
  );
  ti_xbar_formal #(
    .Width (2),
    .NumIn (NumIn),
    .NumOut(NumOut)
  ) u_formal (
    .*
  );
endmodule : ti_xbar_top
