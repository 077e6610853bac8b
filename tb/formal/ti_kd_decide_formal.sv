// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_kd_decide` goes to the child that the ray enters first, or to the far one alone where the plane is not behind tmin;
/// it pushes what comes after, and drops nothing unnoted.  A restart begins where the leaf that is left ends, after where it
/// began.  The node after `WatchdogSteps` others ends the ray, and no earlier one does so.
module ti_kd_decide_formal #(
  parameter int unsigned StackDepth = 4,
  parameter bit Restart = 1'b1,
  parameter int unsigned WatchdogSteps = 65535,
  parameter int unsigned CmpStages = 0,
  localparam int unsigned LevelWidth = (StackDepth > 0) ? $clog2(StackDepth + 1) : 1
) (
  input logic                                 clk_i,
  input logic                                 rst_ni,
  input ti_pkg::node_index_t                  root_i,
  input ti_pkg::node_index_t                  index_i,
  input ti_kd_pkg::node_t                     node_i,
  input logic                                 error_i,
  input logic                                 negative_i,
  input ti_pkg::fp_t                          t_i,
  input ti_pkg::fp_t                          tmin_i,
  input ti_pkg::fp_t                          tmax_i,
  input ti_pkg::fp_t                          ray_tmax_i,
  input ti_pkg::fp_t                          tbest_i,
  input ti_pkg::steps_t                       steps_i,
  input logic                [LevelWidth-1:0] level_i,
  input logic                                 dropped_i,
  input ti_pkg::node_index_t                  top_node_i,
  input ti_pkg::fp_t                          top_tmax_i,
  input ti_pkg::steps_t                       steps_o,
  input logic                                 go_o,
  input ti_pkg::node_index_t                  next_o,
  input logic                                 leaf_o,
  input logic                                 done_o,
  input ti_pkg::status_e                      status_o,
  input ti_pkg::fp_t                          tmin_o,
  input ti_pkg::fp_t                          tmax_o,
  input logic                [LevelWidth-1:0] level_o,
  input logic                                 dropped_o,
  input logic                                 push_o,
  input ti_pkg::node_index_t                  far_o,
  input logic                                 pop_o,
  input logic                                 restart_o
);
  `TI_STARTS_IN_RESET

  localparam int unsigned M = ti_num_pkg::FracBits;
  localparam int unsigned W = ti_num_pkg::FpWidth;

  // Numbers as signed integers of the same order; a comparison with NaN is false.
  function automatic logic signed [W:0] value(ti_pkg::fp_t a);
    logic signed [W:0] size;
    size = (W + 1)'(a[W-2:0]);
    if (ti_fp_pkg::Flush && a[W-2:M] == '0) size = '0;
    return a[W-1] ? -size : size;
  endfunction
  function automatic logic ordered(ti_pkg::fp_t a, ti_pkg::fp_t b);
    return a[W-2:0] <= ti_num_pkg::Inf[W-2:0] && b[W-2:0] <= ti_num_pkg::Inf[W-2:0];
  endfunction
  function automatic logic below(ti_pkg::fp_t a, ti_pkg::fp_t b);
    return ordered(a, b) && value(a) < value(b);
  endfunction
  function automatic logic at_most(ti_pkg::fp_t a, ti_pkg::fp_t b);
    return ordered(a, b) && value(a) <= value(b);
  endfunction
  // Of bit patterns of numbers from 0 up: those that steps leave differ also where subnormals count as zeros.
  function automatic logic later(ti_pkg::fp_t a, ti_pkg::fp_t b);
    return !a[W-1] && !b[W-1] && ordered(a, b) && a > b;
  endfunction
  function automatic logic is_interval(ti_pkg::fp_t a, ti_pkg::fp_t b);
    return !a[W-1] && !b[W-1] && at_most(a, b);
  endfunction

  // What the decision is about: the inputs `CmpStages` cycles before.
  typedef struct packed {
    ti_pkg::node_index_t   index;
    ti_kd_pkg::node_t      node;
    logic                  error;
    logic                  negative;
    ti_pkg::fp_t           t;
    ti_pkg::fp_t           tmin;
    ti_pkg::fp_t           tmax;
    ti_pkg::fp_t           ray_tmax;
    ti_pkg::fp_t           tbest;
    ti_pkg::steps_t        steps;
    logic [LevelWidth-1:0] level;
    logic                  dropped;
    ti_pkg::node_index_t   top_node;
    ti_pkg::fp_t           top_tmax;
  } at_t;
  at_t [CmpStages:0] at_q;
  logic [CmpStages:0] known_q;  // out of reset ever since
  at_t at;
  logic known;
  assign at_q[0] = '{
          index: index_i,
          node: node_i,
          error: error_i,
          negative: negative_i,
          t: t_i,
          tmin: tmin_i,
          tmax: tmax_i,
          ray_tmax: ray_tmax_i,
          tbest: tbest_i,
          steps: steps_i,
          level: level_i,
          dropped: dropped_i,
          top_node: top_node_i,
          top_tmax: top_tmax_i
      };
  assign known_q[0] = rst_ni;
  for (genvar i = 1; i <= CmpStages; i++) begin : gen_later
    always_ff @(posedge clk_i) begin
      at_q[i]    <= at_q[i-1];
      known_q[i] <= rst_ni && known_q[i-1];
    end
  end
  assign at    = at_q[CmpStages];
  assign known = known_q[CmpStages];

  // ---- What the caller gives.
  // An interval: `ti_rd_clip` lets a ray in with 0 <= tmin <= tmax, and what a step leaves of it is one too
  // (StaysAnInterval below).
  `TI_ASSUME(IntervalGiven, known -> is_interval(at.tmin, at.tmax) && is_interval(at.tmax,
                                                                                  at.ray_tmax))
  // An entry ends behind the interval: it was pushed with the end of a longer one (PushesALaterEnd).
  `TI_ASSUME(TopEndsLater, known && at.level != '0 -> later(at.top_tmax, at.tmax) && is_interval(
             at.top_tmax, at.ray_tmax))
  // With nothing split off a ray has its whole interval; else the interval is not empty (same two).
  `TI_ASSUME(OnlyAWholeOneMayBeEmpty, known && !later(at.tmax, at.tmin
             ) -> at.tmax == at.ray_tmax && at.level == '0)
  // `ti_kd_state` gives back what it was given (proven there), which is so here (LevelStays).
  `TI_ASSUME(LevelGiven, known -> 32'(at.level) <= StackDepth && (Restart || !at.dropped))
  // Without `Restart` whoever built the tree made it fit the stack; `ti_kd_state` watches.
  `TI_ASSUME(FitsTheStack, known && !Restart && push_o -> 32'(at.level) < StackDepth)

  // ---- The rules, each in a line.
  logic is_leaf, damaged, out_of_steps, steps_on, far_alone, near_alone, empty, best_ends, left;
  ti_pkg::node_index_t adjacent, lower, upper, nearest, furthest;
  assign is_leaf      = at.node.axis == 2'd3;
  assign out_of_steps = 32'(at.steps) >= WatchdogSteps;
  assign damaged      = at.error || (is_leaf && 32'(at.node.link) > 65535);
  assign steps_on     = !out_of_steps && !damaged;

  // The adjacent child is the upper one where the node is reordered; the lower one is entered first unless the
  // direction is negative.
  assign adjacent     = at.index + 1'b1;
  assign lower        = at.node.reorder ? at.node.link : adjacent;
  assign upper        = at.node.reorder ? adjacent : at.node.link;
  assign nearest      = at.negative ? upper : lower;
  assign furthest     = at.negative ? lower : upper;

  assign near_alone   = !below(at.t, at.tmax);
  assign far_alone    = !near_alone && at_most(at.t, at.tmin);
  assign empty        = at.node.link[15:0] == '0;
  assign best_ends    = at_most(at.tbest, at.tmax);
  assign left         = at.level != '0 || (at.dropped && at.tmax != at.ray_tmax);

  logic inner, leaf, same_stack, keeps, full, pops, restarts;
  assign inner = known && steps_on && !is_leaf;
  assign leaf = known && steps_on && is_leaf;
  assign same_stack = level_o == at.level && dropped_o == at.dropped;
  assign keeps = tmin_o == at.tmin && tmax_o == at.tmax && same_stack;
  assign full = 32'(at.level) == StackDepth;
  assign pops = leaf && go_o && at.level != '0;
  assign restarts = leaf && go_o && at.level == '0;

  `TI_ASSERT(WatchdogAtItsCount, known -> (done_o && status_o == ti_pkg::Watchdog) == out_of_steps)
  `TI_ASSERT(EachNodeIsCounted, known -> 32'(steps_o) == 32'(at.steps) + 32'(!out_of_steps))
  `TI_ASSERT(MemoryErrorEnds,
             known && !out_of_steps -> (done_o && status_o == ti_pkg::MemoryError) == damaged)
  `TI_ASSERT(EndsAtOnce,
             known && !steps_on -> done_o && !go_o && !leaf_o && !push_o && !pop_o && !restart_o)

  `TI_ASSERT(InnerNodeGoesOn, inner -> go_o && !leaf_o && !done_o && !pop_o && !restart_o)
  `TI_ASSERT(NearAlone, inner && near_alone -> !push_o && next_o == nearest && keeps)
  `TI_ASSERT(FarAloneAlsoAtTmin, inner && far_alone -> !push_o && next_o == furthest && keeps)
  `TI_ASSERT(NearThenFar,
             inner && !near_alone && !far_alone -> push_o && next_o == nearest && far_o == furthest)
  `TI_ASSERT(NearEndsAtThePlane, inner && push_o -> tmin_o == at.tmin && tmax_o == at.t)
  `TI_ASSERT(PushIsCounted, inner && push_o -> 32'(level_o) == 32'(at.level) + 32'(!full))
  `TI_ASSERT(FullStackDropsOne, inner && push_o -> dropped_o == (at.dropped || full))

  `TI_ASSERT(LeafIsTested, leaf -> leaf_o == !empty && !push_o)
  `TI_ASSERT(EmptyLeafEndsWithTheBest,
             leaf && empty -> done_o == (best_ends || !left) && status_o == ti_pkg::Ok)
  `TI_ASSERT(LeafWithTrianglesIsNotTheEnd, leaf && !empty -> !done_o)
  `TI_ASSERT(LeafGoesOnWhileSomethingIsLeft, leaf -> go_o == (left && !(empty && best_ends)))
  `TI_ASSERT(TakesTheTop, pops -> pop_o && !restart_o && next_o == at.top_node)
  `TI_ASSERT(GoesOnUpToItsEnd, pops -> tmin_o == at.tmax && tmax_o == at.top_tmax)
  `TI_ASSERT(PopIsCounted, pops -> 32'(level_o) + 1 == 32'(at.level) && dropped_o == at.dropped)
  `TI_ASSERT(RestartsAtTheRoot, restarts -> restart_o && !pop_o && next_o == root_i)
  `TI_ASSERT(RestartsWhereTheLeafEnds, restarts -> tmin_o == at.tmax && tmax_o == at.ray_tmax)
  `TI_ASSERT(RestartsWithAnEmptyStack, restarts -> level_o == '0 && !dropped_o)

  // ---- A ray comes to its end.
  `TI_ASSERT(LeavesLater, known && (pop_o || restart_o) -> later(tmin_o, at.tmin) && later(tmax_o,
                                                                                           tmin_o))
  `TI_ASSERT(StaysAnInterval, known && go_o -> is_interval(tmin_o, tmax_o) && is_interval(
             tmax_o, at.ray_tmax))
  `TI_ASSERT(OneThatIsSplitIsNotEmpty, known && go_o && !later(tmax_o, tmin_o
             ) -> keeps && tmax_o == at.ray_tmax && !push_o)
  `TI_ASSERT(PushesALaterEnd, known && push_o -> later(at.tmax, tmax_o))
  `TI_ASSERT(LevelStays, known && go_o -> 32'(level_o) <= StackDepth && (Restart || !dropped_o))

  `TI_COVER(PlaneAtTmin, inner && far_alone && at.t == at.tmin)
  `TI_COVER(LastNodeBeforeTheWatchdog, inner && 32'(at.steps) == WatchdogSteps - 1)
  if (Restart) begin : gen_restart
    `TI_COVER(Restarts, leaf && restart_o)
  end
endmodule : ti_kd_decide_formal

bind ti_kd_decide ti_kd_decide_formal #(
  .StackDepth   (StackDepth),
  .Restart      (Restart),
  .WatchdogSteps(WatchdogSteps),
  .CmpStages    (CmpStages)
) u_formal (.*);
