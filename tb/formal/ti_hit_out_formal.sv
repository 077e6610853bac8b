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

  localparam int unsigned CountWidth = 2;
  typedef struct packed {
    logic         last;
    ti_pkg::hit_t hit;
  } word_t;
  word_t pushed;
  logic push, pop;
  assign push   = hit_valid_i && hit_ready_o;
  assign pop    = m_axis_tvalid && m_axis_tready;
  assign pushed = '{last: last_i, hit: hit_data_i};
  `include "watched.svh"

  logic [7:0][31:0] words;
  ti_pkg::hit_t hit;
  assign words = m_axis_tdata;
  assign hit   = word_q.hit;
  `TI_ASSERT(TakesWhileThereIsRoom, hit_ready_o == (inside_q != 2'd2))
  `TI_ASSERT(GivesWhileOneIsInside, m_axis_tvalid == (inside_q != '0))
  `TI_ASSERT(NumberOfTheRay, its_turn -> words[0] == hit.ray_id)
  `TI_ASSERT(Primitive, its_turn -> words[1] == hit.prim)
  `TI_ASSERT(PlaceOfTheHit,
             its_turn -> words[2] == 32'(hit.t) && words[3] == 32'(hit.u) && words[4] == 32'(hit.v))
  `TI_ASSERT(HowItEnded, its_turn -> words[5] == 32'(hit.status))
  `TI_ASSERT(Steps, its_turn -> words[6] == 32'(hit.steps) && words[7] == '0)
  `TI_ASSERT(LastOfItsPacket, its_turn -> m_axis_tlast == word_q.last)
  `TI_COVER(WatchedLeavesAFullOne, its_turn && pop && inside_q == 2'd2 && word_q.last)
endmodule : ti_hit_out_formal

bind ti_hit_out ti_hit_out_formal u_formal (.*);
