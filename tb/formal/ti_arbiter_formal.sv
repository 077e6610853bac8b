// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_arbiter` passes each beat that it grants on, once, unchanged and in the order of the grants; a request that stays is
/// granted after at most `NumIn` - 1 others.
module ti_arbiter_formal #(
  parameter int unsigned Width = 1,
  parameter int unsigned NumIn = 2,
  localparam int unsigned IndexWidth = (NumIn > 1) ? $clog2(NumIn) : 1
) (
  input logic                        clk_i,
  input logic                        rst_ni,
  input logic [NumIn-1:0]            in_valid_i,
  input logic [NumIn-1:0]            in_ready_o,
  input logic [NumIn-1:0][Width-1:0] data_i,
  input logic                        out_valid_o,
  input logic                        out_ready_i,
  input logic [Width-1:0]            out_data_o
);
  `TI_STARTS_IN_RESET

  // One requester, whichever: how many others were granted while it asked.
  logic [IndexWidth-1:0] who;
  logic [IndexWidth-1:0] others_q;
  `TI_SYMBOL(who)
  WhoExists :
  assume property (@(posedge clk_i) (32'(who) < NumIn));
  always_ff @(posedge clk_i) begin
    if (!rst_ni || !in_valid_i[who] || in_ready_o[who]) others_q <= '0;
    else if (|in_ready_o) others_q <= others_q + 1'b1;
  end

  // Beats inside, and one of them that is watched, which came from `who`.
  logic push, pop, pick, watched_q;
  logic [1:0] inside_q, ahead_q;
  logic [Width-1:0] data_q;
  assign push = |in_ready_o;
  assign pop  = out_valid_o && out_ready_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      inside_q  <= '0;
      watched_q <= 1'b0;
    end else begin
      inside_q <= inside_q + 2'(push) - 2'(pop);
      if (!watched_q) watched_q <= in_ready_o[who] && pick;
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

  `TI_ASSERT(GrantsOneOfThem, $onehot0(in_ready_o) && (in_ready_o & ~in_valid_i) == '0)
  `TI_ASSERT(GrantsWhileThereIsRoom, |in_ready_o == (|in_valid_i && inside_q != 2'd2))
  `TI_ASSERT(FairWithinItsPeers, 32'(others_q) < NumIn)
  `TI_ASSERT(ThenItsTurn,
             |in_ready_o && in_valid_i[who] && 32'(others_q) == NumIn - 1 -> in_ready_o[who])
  `TI_ASSERT(OutWhileOneIsInside, out_valid_o == (inside_q != '0))
  `TI_ASSERT(WatchedIsInside, watched_q -> ahead_q < inside_q)
  `TI_ASSERT(WatchedComesUnchanged,
             watched_q && ahead_q == '0 -> out_valid_o && out_data_o == data_q)
  `TI_COVER(WaitsForAllOthers, in_ready_o[who] && 32'(others_q) == NumIn - 1)
endmodule : ti_arbiter_formal

module ti_arbiter_top #(
  parameter int unsigned NumIn = 2
) (
  input  logic                  clk_i,
  input  logic                  rst_ni,
  input  logic [NumIn-1:0]      in_valid_i,
  output logic [NumIn-1:0]      in_ready_o,
  input  logic [NumIn-1:0][1:0] data_i,
  output logic                  out_valid_o,
  input  logic                  out_ready_i,
  output logic [      1:0]      out_data_o
);
  logic [1:0] in_data[NumIn];
  for (genvar i = 0; i < NumIn; i++) begin : gen_in
    assign in_data[i] = data_i[i];
  end
  ti_arbiter #(
    .payload_t(logic [1:0]),
    .NumIn    (NumIn)
  ) u_unit (
    .in_data_i(in_data),
    .in_lost_o(),
    .*
  );
  ti_arbiter_formal #(
    .Width(2),
    .NumIn(NumIn)
  ) u_formal (
    .*
  );
endmodule : ti_arbiter_top
