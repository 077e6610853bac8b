// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_hit_out` gives each hit on as one beat, in order, each of its values in its word and the rest 0, with the TLAST
/// that came with it; a beat stays until it is taken.
module ti_hit_out_formal (
  input logic                 clk_i,
  input logic                 rst_ni,
  input logic                 hit_valid_i,
  input logic                 hit_ready_o,
  input ti_pkg::hit_t         hit_data_i,
  input logic                 last_i,
  input logic                 m_axis_tvalid,
  input logic                 m_axis_tready,
  input logic         [255:0] m_axis_tdata,
  input logic                 m_axis_tlast
);
  `TI_STARTS_IN_RESET

  // Hits inside, and one of them that is watched.
  logic take, give, pick, watched_q, last_q;
  logic [1:0] inside_q, ahead_q;
  ti_pkg::hit_t hit_q;
  assign take = hit_valid_i && hit_ready_o;
  assign give = m_axis_tvalid && m_axis_tready;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      inside_q  <= '0;
      watched_q <= 1'b0;
    end else begin
      inside_q <= inside_q + 2'(take) - 2'(give);
      if (!watched_q) watched_q <= take && pick;
      else if (give && ahead_q == '0) watched_q <= 1'b0;
    end
  end
  always_ff @(posedge clk_i) begin
    if (!watched_q) begin
      ahead_q <= inside_q - 2'(give);
      hit_q   <= hit_data_i;
      last_q  <= last_i;
    end else if (give) begin
      ahead_q <= ahead_q - 1'b1;
    end
  end

  logic its_turn;
  logic [7:0][31:0] words;
  assign its_turn = watched_q && ahead_q == '0;
  assign words    = m_axis_tdata;
  `TI_ASSERT(TakesWhileThereIsRoom, hit_ready_o == (inside_q != 2'd2))
  `TI_ASSERT(GivesWhileOneIsInside, m_axis_tvalid == (inside_q != '0))
  `TI_ASSERT(WatchedIsInside, watched_q -> ahead_q < inside_q)
  `TI_ASSERT(NumberOfTheRay, its_turn -> words[0] == hit_q.ray_id)
  `TI_ASSERT(Primitive, its_turn -> words[1] == hit_q.prim)
  `TI_ASSERT(
      PlaceOfTheHit,
      its_turn -> words[2] == 32'(hit_q.t) && words[3] == 32'(hit_q.u) && words[4] == 32'(hit_q.v))
  `TI_ASSERT(HowItEnded, its_turn -> words[5] == 32'(hit_q.status))
  `TI_ASSERT(Steps, its_turn -> words[6] == 32'(hit_q.steps) && words[7] == '0)
  `TI_ASSERT(LastOfItsPacket, its_turn -> m_axis_tlast == last_q)
  `TI_COVER(WatchedLeavesAFullOne, its_turn && give && inside_q == 2'd2 && last_q)
endmodule : ti_hit_out_formal

bind ti_hit_out ti_hit_out_formal u_formal (.*);
