// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_trv_visits` makes of each request one visit, of its slot to its node, a new ray's to the root; a step or a
/// resume that finds nobody waiting visits in the next cycle, and a slot waits for fewer than 3 * `NumSlots` others.
module ti_trv_visits_formal #(
  parameter int unsigned NumSlots = 2
) (
  input logic                clk_i,
  input logic                rst_ni,
  input ti_pkg::node_index_t root_i,
  input logic                step_i,
  input ti_pkg::trv_slot_t   step_slot_i,
  input ti_pkg::node_index_t step_node_i,
  input logic                resume_i,
  input ti_pkg::trv_slot_t   resume_slot_i,
  input ti_pkg::node_index_t resume_node_i,
  input logic                start_i,
  input ti_pkg::trv_slot_t   start_slot_i,
  input logic                visit_valid_o,
  input logic                visit_ready_i,
  input ti_pkg::trv_slot_t   visit_slot_o,
  input ti_pkg::node_index_t visit_node_o
);
  `TI_STARTS_IN_RESET

  // Slots that wait here, and those that have done so for a cycle.
  logic visit;
  logic [NumSlots-1:0] steps, resumes, starts, asks, leaves, waits_q, waited_q;
  assign visit   = visit_valid_o && visit_ready_i;
  assign steps   = step_i ? NumSlots'(1) << step_slot_i : '0;
  assign resumes = resume_i ? NumSlots'(1) << resume_slot_i : '0;
  assign starts  = start_i ? NumSlots'(1) << start_slot_i : '0;
  assign asks    = steps | resumes | starts;
  assign leaves  = visit ? NumSlots'(1) << visit_slot_o : '0;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      waits_q  <= '0;
      waited_q <= '0;
    end else begin
      waits_q  <= (waits_q & ~leaves) | asks;
      waited_q <= waits_q & ~leaves;
    end
  end

  // One slot, whichever: the node that it asked for, and visits of others since.
  ti_pkg::trv_slot_t who;
  `TI_SYMBOL(who)
  ti_pkg::node_index_t node_q;
  logic [31:0] others_q;
  always_ff @(posedge clk_i) begin
    if (steps[who]) node_q <= step_node_i;
    if (resumes[who]) node_q <= resume_node_i;
    if (starts[who]) node_q <= root_i;
    if (!rst_ni || !waits_q[who]) others_q <= '0;
    else if (visit) others_q <= others_q + 1;
  end

  // A slot asks once and waits for its visit: it has one ray (`ti_slot_pool`), which begins, steps or goes on after a
  // leaf, and does so again only when it has been given its node.
  `TI_ASSUME(AsksWhenNotHere, (asks & waits_q) == '0)
  `TI_ASSUME(AsksForOneReason,
             (steps & resumes) == '0 && (steps & starts) == '0 && (resumes & starts) == '0)
  // `ti_engine` takes a scene over while no ray is inside.
  `TI_ASSUME(RootStays, $past(rst_ni) -> $stable(root_i))

  `TI_ASSERT(VisitsOnlyWhoAsked, visit_valid_o -> waits_q[visit_slot_o])
  `TI_ASSERT(VisitsItsNode, visit_valid_o && visit_slot_o == who -> visit_node_o == node_q)
  `TI_ASSERT(WorksWhileSomeoneWaits, waited_q != '0 -> visit_valid_o)
  `TI_ASSERT_NEXT(ResumeGoesPast, waits_q == '0 && resume_i, visit_valid_o && visit_slot_o == $past
                  (resume_slot_i))
  `TI_ASSERT_NEXT(StepGoesPast, waits_q == '0 && step_i && !resume_i,
                  visit_valid_o && visit_slot_o == $past(step_slot_i))
  `TI_ASSERT(WaitsItsTurn, others_q < 3 * NumSlots)
  `TI_ASSERT_NEXT(OutHeldUntilTaken, visit_valid_o && !visit_ready_i, visit_valid_o && $stable
                  ({visit_slot_o, visit_node_o}))
  `TI_COVER(AllWait, waits_q == '1 && visit && others_q != '0)
  `TI_COVER(StepBehindAResume, visit && visit_slot_o == who && $past(steps[who] && resume_i, 2))
endmodule : ti_trv_visits_formal

// Nodes are moved and not looked at: one bit, repeated, stands for all of theirs.
module ti_trv_visits_top #(
  parameter int unsigned NumSlots = 2 ** $bits(ti_pkg::trv_slot_t)
) (
  input  logic                clk_i,
  input  logic                rst_ni,
  input  logic                root_i,
  input  logic                step_i,
  input  ti_pkg::trv_slot_t   step_slot_i,
  input  logic                step_node_i,
  input  logic                resume_i,
  input  ti_pkg::trv_slot_t   resume_slot_i,
  input  logic                resume_node_i,
  input  logic                start_i,
  input  ti_pkg::trv_slot_t   start_slot_i,
  output logic                visit_valid_o,
  input  logic                visit_ready_i,
  output ti_pkg::trv_slot_t   visit_slot_o,
  output ti_pkg::node_index_t visit_node_o
);
  localparam int unsigned NodeBits = $bits(ti_pkg::node_index_t);
  ti_trv_visits #(
    .NumSlots(NumSlots)
  ) u_unit (
    .root_i       ({NodeBits{root_i}}),
    .step_node_i  ({NodeBits{step_node_i}}),
    .resume_node_i({NodeBits{resume_node_i}}),
    .*
  );
endmodule : ti_trv_visits_top

bind ti_trv_visits ti_trv_visits_formal #(.NumSlots(NumSlots)) u_formal (.*);
