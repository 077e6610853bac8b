// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// What a TRV does in each cycle, for counting: one activity, and events.
///
/// The activity is the first that holds of the table in `docs/units/ti_trv.md`.
module ti_trv_account #(
  parameter int unsigned NumSlots = 8
) (
  input logic clk_i,
  input logic rst_ni,

  input logic start_i,  // a ray takes a slot
  input logic free_i,   // a slot's ray has retired

  input logic works_i,   // a node enters the arithmetic
  input logic memory_i,  // a line is on its way
  input logic blocked_i, // an output is not taken

  input logic end_i,       // a step ends
  input logic again_i,     // and the ray visits a node next
  input logic restart_i,   // which is the root again
  input logic leaf_i,      // at a leaf
  input logic full_leaf_i, // at a leaf with triangles

  input logic resume_i,         // a ray goes on after a leaf with triangles
  input logic resume_restart_i, // from the root again

  input ti_count_pkg::cache_events_t cache_i,

  output logic                      at_home_o,  // a ray is here
  output ti_count_pkg::trv_events_t events_o
);

  localparam int unsigned CountWidth = $clog2(NumSlots + 1);
  typedef logic [CountWidth-1:0] count_t;

  logic moving;
  count_t inside_q, moving_q;  // rays at home; of these, on their way to a decision

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      inside_q <= '0;
      moving_q <= '0;
    end else begin
      inside_q <= inside_q + count_t'(start_i) - count_t'(free_i);
      moving_q <= moving_q + count_t'(start_i) + count_t'(resume_i) - count_t'(end_i && !again_i);
    end
  end
  assign at_home_o = inside_q != '0;
  assign moving    = moving_q != '0;

  always_comb begin
    events_o.activity = '0;
    if (works_i) events_o.activity.works = 1'b1;
    else if (memory_i) events_o.activity.memory = 1'b1;
    else if (blocked_i) events_o.activity.room = 1'b1;
    else if (moving) events_o.activity.latency = 1'b1;
    else if (at_home_o) events_o.activity.results = 1'b1;
    else events_o.activity.empty = 1'b1;

    events_o.steps                = end_i;
    events_o.leaves               = end_i && leaf_i;
    events_o.full_leaves          = end_i && full_leaf_i;
    events_o.restarts             = end_i && again_i && restart_i;
    // Counted when the ray goes, which a hit in the leaf may keep it from.
    events_o.restarts_after_tests = resume_i && resume_restart_i;
    events_o.rays                 = free_i;
    events_o.cache                = cache_i;
  end

  `TI_ASSERT(NoMoreThanSlots, inside_q <= count_t'(NumSlots) && moving_q <= inside_q)

endmodule : ti_trv_account
