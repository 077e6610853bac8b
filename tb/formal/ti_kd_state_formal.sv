// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_kd_state` with `ti_kd_decide`: every slot has the state of its own last step; a leaf goes on with the newest entry of
/// an unbounded stack cut to its newest `StackDepth`, and at the root exactly when none is left, one was cut off since the
/// last restart, and the ray does not end there.
module ti_kd_state_formal #(
  parameter int unsigned StackDepth = 2,
  parameter bit Restart = 1'b1,
  parameter int unsigned Lag = 0,
  localparam int unsigned LevelWidth = (StackDepth > 0) ? $clog2(StackDepth + 1) : 1
) (
  input logic                                 clk_i,
  input logic                                 rst_ni,
  input ti_pkg::node_index_t                  root_i,
  input logic                                 start_i,
  input ti_pkg::trv_slot_t                    start_slot_i,
  input ti_pkg::fp_t                          start_tmin_i,
  input ti_pkg::fp_t                          start_tmax_i,
  input logic                                 visit_i,
  input ti_pkg::trv_slot_t                    visit_slot_i,
  input ti_pkg::node_index_t                  visit_node_i,
  input logic                                 step_valid_i,
  input ti_pkg::trv_slot_t                    step_slot_i,
  // The state as the decision sees it, and what comes with it.
  input logic                                 shown,
  input ti_pkg::trv_slot_t                    shown_slot,
  input ti_pkg::node_index_t                  index,
  input ti_pkg::fp_t                          tmin,
  input ti_pkg::fp_t                          tmax,
  input ti_pkg::fp_t                          ray_tmin,
  input ti_pkg::fp_t                          ray_tmax,
  input ti_pkg::steps_t                       steps,
  input logic                [LevelWidth-1:0] level,
  input ti_pkg::node_index_t                  top_node,
  input ti_pkg::fp_t                          top_tmax,
  input ti_kd_pkg::node_t                     node_i,
  input ti_pkg::fp_t                          t_i,
  input ti_pkg::fp_t                          tbest_i,
  // The decision, `Lag` cycles later.
  input logic                                 ends,
  input ti_pkg::trv_slot_t                    end_slot,
  input logic                                 go,
  input ti_pkg::node_index_t                  next,
  input logic                                 leaf,
  input logic                                 done,
  input ti_pkg::status_e                      status,
  input ti_pkg::steps_t                       steps_next,
  input logic                                 push,
  input ti_pkg::node_index_t                  far,
  input logic                                 pop,
  input logic                                 restart
);
  `TI_STARTS_IN_RESET

  localparam int unsigned NumSlots = 2 ** $bits(ti_pkg::trv_slot_t);
  localparam int unsigned Places = (StackDepth > 0) ? StackDepth : 1;
  // Nodes are moved and not looked at: two bits of their index stand for all.
  typedef logic [1:0] low_t;
  localparam int unsigned M = ti_num_pkg::FracBits;
  localparam int unsigned W = ti_num_pkg::FpWidth;

  function automatic logic signed [W:0] value(ti_pkg::fp_t a);
    logic signed [W:0] size;
    size = (W + 1)'(a[W-2:0]);
    if (ti_fp_pkg::Flush && a[W-2:M] == '0) size = '0;
    return a[W-1] ? -size : size;
  endfunction
  function automatic logic at_most(ti_pkg::fp_t a, ti_pkg::fp_t b);
    if (a[W-2:0] > ti_num_pkg::Inf[W-2:0] || b[W-2:0] > ti_num_pkg::Inf[W-2:0]) return 1'b0;
    return value(a) <= value(b);
  endfunction

  // Where the ray of each slot is.
  typedef enum logic [2:0] {
    Free,      // none, or one that is done
    Asks,      // has no node to visit yet
    Visits,    // its node is on its way
    Steps,     // in the arithmetic
    LeavesOff  // at a leaf: goes on, or is done
  } where_e;
  for (genvar s = 0; s < NumSlots; s++) begin : gen_slot
    where_e where_q;
    logic starts, visits, steps_on;
    assign starts   = start_i && 32'(start_slot_i) == s;
    assign visits   = visit_i && 32'(visit_slot_i) == s;
    assign steps_on = step_valid_i && 32'(step_slot_i) == s;
    always_ff @(posedge clk_i) begin
      if (!rst_ni) where_q <= Free;
      else if (starts) where_q <= Asks;
      else if (visits) where_q <= Visits;
      else if (steps_on) where_q <= Steps;
      else if (ends && 32'(end_slot) == s) where_q <= done || !go ? Free : leaf ? LeavesOff : Asks;
    end

    // `ti_slot_pool` hands out no slot that is taken, and takes it back with the hit (proven there).
    `TI_ASSUME(StartsWhenFree, starts -> where_q == Free || where_q == LeavesOff)
    // `ti_trv_visits` sends a ray on when it has started, stepped or left a leaf, once.
    `TI_ASSUME(VisitsWhenItGoesOn, visits -> where_q == Asks || (where_q == LeavesOff && !starts))
    // `ti_ra` gives one node a visit.
    `TI_ASSUME(StepsWithItsNode, steps_on -> where_q == Visits)
  end

  // One of the slots, whichever.
  ti_pkg::trv_slot_t who;
  logic starts_who, visits_who, shows_who, ends_who;
  `TI_SYMBOL(who)
  assign starts_who = start_i && start_slot_i == who;
  assign visits_who = visit_i && visit_slot_i == who;
  assign shows_who  = shown && shown_slot == who;
  assign ends_who   = ends && end_slot == who;

  // What comes with the state, at the decision.
  logic is_leaf;
  ti_pkg::fp_t t, tbest;
  ti_delay #(
    .payload_t(logic [2*W:0]),
    .Cycles   (Lag)
  ) u_later (
    .clk_i,
    .rst_ni,
    .data_i({node_i.axis == 2'd3, t_i, tbest_i}),
    .data_o({is_leaf, t, tbest})
  );

  // The ray, and its stack, of which the newest entry comes first.
  low_t index_q;
  ti_pkg::fp_t tmin_q, tmax_q, ray_tmin_q, ray_tmax_q;
  ti_pkg::steps_t steps_q;
  low_t [Places-1:0] node_q;
  ti_pkg::fp_t [Places-1:0] end_q;
  logic [LevelWidth-1:0] count_q;
  logic cut_q;  // an entry, since the last restart
  always_ff @(posedge clk_i) begin
    if (starts_who) begin
      tmin_q     <= start_tmin_i;
      tmax_q     <= start_tmax_i;
      ray_tmin_q <= start_tmin_i;
      ray_tmax_q <= start_tmax_i;
      steps_q    <= '0;
      count_q    <= '0;
      cut_q      <= 1'b0;
    end
    if (visits_who) index_q <= low_t'(visit_node_i);
    if (ends_who) begin
      steps_q <= steps_next;
      if (push) begin
        tmax_q <= t;
        for (int unsigned i = 1; i < Places; i++) begin
          node_q[i] <= node_q[i-1];
          end_q[i]  <= end_q[i-1];
        end
        node_q[0] <= low_t'(far);
        end_q[0]  <= tmax_q;
        if (32'(count_q) == StackDepth) cut_q <= 1'b1;
        else count_q <= count_q + 1'b1;
      end else if (go && is_leaf) begin
        tmin_q <= tmax_q;
        if (count_q != '0) begin
          tmax_q <= end_q[0];
          for (int unsigned i = 1; i < Places; i++) begin
            node_q[i-1] <= node_q[i];
            end_q[i-1]  <= end_q[i];
          end
          count_q <= count_q - 1'b1;
        end else begin
          tmax_q <= ray_tmax_q;
          cut_q  <= 1'b0;
        end
      end
    end
  end

  // ---- The state is that of the ray.
  `TI_ASSERT(NodeIsTheOneVisited, shows_who -> low_t'(index) == index_q)
  `TI_ASSERT(IntervalIsThatOfTheRay, shows_who -> tmin == tmin_q && tmax == tmax_q)
  `TI_ASSERT(WholeIntervalIsKept, shows_who -> ray_tmin == ray_tmin_q && ray_tmax == ray_tmax_q)
  `TI_ASSERT(StepsAreKept, shows_who -> steps == steps_q)
  `TI_ASSERT(LevelIsThatOfTheStack, shows_who -> level == count_q)
  `TI_ASSERT(TopIsTheNewestEntry,
             shows_who && count_q != '0 -> low_t'(top_node) == node_q[0] && top_tmax == end_q[0])

  // ---- A leaf goes on where the stack says.
  logic leaves_off;  // a leaf, and memory gave it in time
  assign leaves_off = ends_who && is_leaf && status == ti_pkg::Ok;
  `TI_ASSERT(GoesOnWithTheNewestEntry,
             leaves_off && go && count_q != '0 -> pop && !restart && low_t'(next) == node_q[0])
  `TI_ASSERT(RestartsWhenOneWasCut, leaves_off && go && count_q == '0 -> restart && !pop && cut_q)
  `TI_ASSERT(RestartsAtTheRootAgain, ends_who && restart -> low_t'(next) == low_t'(root_i))
  `TI_ASSERT(
      EndsWhenNothingIsLeft,
      leaves_off && !go -> (count_q == '0 && (!cut_q || tmax_q == ray_tmax_q)) || (done && at_most(
      tbest, tmax_q)))
  `TI_ASSERT(RestartsOnlyAtLeaves, ends_who && (restart || pop) -> leaves_off && go && !push)

  if (Restart && StackDepth <= 1) begin : gen_restart
    `TI_COVER(RestartsAtTheRoot, ends_who && restart)
  end
  if (StackDepth > 0) begin : gen_stack
    `TI_COVER(PopsOfAFullStack, ends_who && pop && 32'(count_q) == StackDepth && cut_q == Restart)
  end
endmodule : ti_kd_state_formal

module ti_kd_state_top #(
  parameter int unsigned StackDepth = 2,
  parameter bit Restart = 1'b1,
  parameter int unsigned Lead = 3,
  parameter int unsigned Lag = 0,
  localparam int unsigned NumSlots = 2 ** $bits(ti_pkg::trv_slot_t),
  localparam int unsigned LevelWidth = (StackDepth > 0) ? $clog2(StackDepth + 1) : 1
) (
  input logic                clk_i,
  input logic                rst_ni,
  input ti_pkg::node_index_t root_i,
  input logic                start_i,
  input ti_pkg::trv_slot_t   start_slot_i,
  input ti_pkg::fp_t         start_tmin_i,
  input ti_pkg::fp_t         start_tmax_i,
  input logic                visit_i,
  input ti_pkg::trv_slot_t   visit_slot_i,
  input ti_pkg::node_index_t visit_node_i,
  input logic                step_valid_i,
  input ti_pkg::trv_slot_t   step_slot_i,
  input ti_kd_pkg::node_t    node_i,
  input logic                error_i,
  input logic                negative_i,
  input ti_pkg::fp_t         t_i,
  input ti_pkg::fp_t         tbest_i,
  // The count that the decision sees is free, so that the watchdog ends no ray before its time.
  input ti_pkg::steps_t      spent_i
);
  // As in `ti_kd_walk`: a step shows its state after `Lead` cycles and ends `Lag` later.
  logic [Lead+Lag-1:0] valid_q;
  ti_pkg::trv_slot_t [Lead+Lag-1:0] slot_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) valid_q <= '0;
    else valid_q <= (Lead + Lag)'({valid_q, step_valid_i});
  end
  always_ff @(posedge clk_i) begin
    slot_q[0] <= step_slot_i;
    for (int unsigned i = 1; i < Lead + Lag; i++) slot_q[i] <= slot_q[i-1];
  end

  logic shown, ends, go, leaf, done, push, pop, restart, dropped, dropped_next;
  ti_pkg::trv_slot_t shown_slot, end_slot;
  ti_pkg::node_index_t index, next, far, top_node;
  ti_pkg::fp_t tmin, tmax, ray_tmin, ray_tmax, top_tmax, tmin_next, tmax_next;
  ti_pkg::steps_t steps, steps_next;
  ti_pkg::status_e status;
  logic [LevelWidth-1:0] level, level_next;
  assign shown      = valid_q[Lead-1];
  assign shown_slot = slot_q[Lead-1];
  assign ends       = valid_q[Lead+Lag-1];
  assign end_slot   = slot_q[Lead+Lag-1];

  ti_kd_state #(
    .NumSlots  (NumSlots),
    .StackDepth(StackDepth),
    .Restart   (Restart),
    .Lead      (Lead),
    .Lag       (Lag)
  ) u_unit (
    .late_valid_o  (),
    .late_slot_o   (),
    .index_o       (index),
    .tmin_o        (tmin),
    .tmax_o        (tmax),
    .ray_tmin_o    (ray_tmin),
    .ray_tmax_o    (ray_tmax),
    .steps_o       (steps),
    .level_o       (level),
    .dropped_o     (dropped),
    .top_node_o    (top_node),
    .top_tmax_o    (top_tmax),
    .trail_o       (),
    .dropped_from_o(),
    .top_tmin_o    (),
    .oldest_tmin_o (),
    .end_valid_i   (ends),
    .end_slot_i    (end_slot),
    .tmin_i        (tmin_next),
    .tmax_i        (tmax_next),
    .steps_i       (steps_next),
    .level_i       (level_next),
    .dropped_i     (dropped_next),
    .trail_i       ('0),
    .dropped_from_i('0),
    .far_tmin_i    ('0),
    .push_i        (push),
    .far_i         (far),
    .pop_i         (pop),
    .*
  );
  ti_kd_decide #(
    .StackDepth(StackDepth),
    .Restart   (Restart),
    .CmpStages (Lag)
  ) u_decide (
    .index_i   (index),
    .tmin_i    (tmin),
    .tmax_i    (tmax),
    .ray_tmax_i(ray_tmax),
    .steps_i   (spent_i),
    .level_i   (level),
    .dropped_i (dropped),
    .top_node_i(top_node),
    .top_tmax_i(top_tmax),
    .steps_o   (steps_next),
    .go_o      (go),
    .next_o    (next),
    .leaf_o    (leaf),
    .tnear_o   (),
    .tfar_o    (),
    .bound_o   (),
    .done_o    (done),
    .status_o  (status),
    .tmin_o    (tmin_next),
    .tmax_o    (tmax_next),
    .level_o   (level_next),
    .dropped_o (dropped_next),
    .push_o    (push),
    .far_o     (far),
    .pop_o     (pop),
    .restart_o (restart),
    .*
  );
  ti_kd_state_formal #(
    .StackDepth(StackDepth),
    .Restart   (Restart),
    .Lag       (Lag)
  ) u_formal (
    .*
  );
endmodule : ti_kd_state_top
