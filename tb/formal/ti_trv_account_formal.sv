// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_trv_account` names one activity in each cycle, the first that holds in the order of its table, counts each event
/// when it happens, and says that a ray is at home from the cycle after it came to that of its hit.
module ti_trv_account_formal #(
  parameter int unsigned NumSlots = 2
) (
  input logic                      clk_i,
  input logic                      rst_ni,
  input logic                      start_i,
  input logic                      free_i,
  input logic                      works_i,
  input logic                      memory_i,
  input logic                      blocked_i,
  input logic                      end_i,
  input logic                      again_i,
  input logic                      restart_i,
  input logic                      leaf_i,
  input logic                      full_leaf_i,
  input logic                      resume_i,
  input logic                      resume_restart_i,
  input logic                      at_home_o,
  input ti_count_pkg::trv_events_t events_o
);
  `TI_STARTS_IN_RESET

  // Where the ray of each slot is; which one starts, stops, goes on or retires is free.
  typedef enum logic [1:0] {
    Free,
    Walks,  // between its request for a node and the decision
    Stands  // out with its tests or on its way home
  } where_e;
  where_e [NumSlots-1:0] where_q;
  logic [NumSlots-1:0] which_starts, which_stops, which_resumes, which_frees;
  logic [NumSlots-1:0] is_free, walks, stands;
  for (genvar s = 0; s < NumSlots; s++) begin : gen_slot
    assign is_free[s] = where_q[s] == Free;
    assign walks[s]   = where_q[s] == Walks;
    assign stands[s]  = where_q[s] == Stands;
    always_ff @(posedge clk_i) begin
      if (!rst_ni) where_q[s] <= Free;
      else if (which_starts[s] || which_resumes[s]) where_q[s] <= Walks;
      else if (which_stops[s]) where_q[s] <= Stands;
      else if (which_frees[s]) where_q[s] <= Free;
    end
  end

  // A ray takes a free slot (`ti_slot_pool`); one that walks ends its step, and does not visit again once it stands
  // (`ti_kd_walk`); one that stands goes on or retires (`ti_trv_return`).
  `TI_ASSUME(OneStarts, $onehot0(which_starts) && (which_starts & ~is_free) == '0)
  `TI_ASSUME(OneStops, $onehot0(which_stops) && (which_stops & ~walks) == '0)
  `TI_ASSUME(OneResumes, $onehot0(which_resumes) && (which_resumes & ~stands) == '0)
  `TI_ASSUME(OneIsFreed, $onehot0(which_frees) && (which_frees & ~stands) == '0)
  `TI_ASSUME(GoesOneWay, (which_resumes & which_frees) == '0)
  `TI_ASSUME(StartsSo, start_i == |which_starts)
  `TI_ASSUME(StopsSo, (end_i && !again_i) == |which_stops)
  `TI_ASSUME(ResumesSo, resume_i == |which_resumes)
  `TI_ASSUME(IsFreedSo, free_i == |which_frees)

  logic works, memory, room, latency, results, empty;
  assign works   = works_i;
  assign memory  = memory_i && !works;
  assign room    = blocked_i && !works && !memory_i;
  assign latency = walks != '0 && !works_i && !memory_i && !blocked_i;
  assign results = stands != '0 && walks == '0 && !works_i && !memory_i && !blocked_i;
  assign empty   = is_free == '1 && !works_i && !memory_i && !blocked_i;

  `TI_ASSERT(OneActivity, $onehot(events_o.activity))
  `TI_ASSERT(Works, events_o.activity.works == works)
  `TI_ASSERT(WaitsForMemory, events_o.activity.memory == memory)
  `TI_ASSERT(WaitsForRoom, events_o.activity.room == room)
  `TI_ASSERT(WaitsForItsSteps, events_o.activity.latency == latency)
  `TI_ASSERT(WaitsForResults, events_o.activity.results == results)
  `TI_ASSERT(IsEmpty, events_o.activity.empty == empty)
  `TI_ASSERT(AtHomeWhileARayIs, at_home_o == (is_free != '1))
  `TI_ASSERT(CountsSteps, events_o.steps == end_i)
  `TI_ASSERT(CountsLeaves,
             events_o.leaves == (end_i && leaf_i) && events_o.full_leaves == (end_i && full_leaf_i))
  `TI_ASSERT(CountsRestarts, events_o.restarts == (end_i && again_i && restart_i))
  `TI_ASSERT(CountsRestartsAfterTests,
             events_o.restarts_after_tests == (resume_i && resume_restart_i))
  `TI_ASSERT(CountsRays, events_o.rays == free_i)
  `TI_COVER(AllStand, stands == '1 && events_o.activity.results)
  `TI_COVER(OneStandsOneWalks, stands != '0 && events_o.activity.latency)
endmodule : ti_trv_account_formal

bind ti_trv_account ti_trv_account_formal #(.NumSlots(NumSlots)) u_formal (.*);
