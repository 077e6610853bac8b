// SPDX-License-Identifier: Apache-2.0

/// What a thick ray does after a node: `ti_kd_decide` for a padded traversal, with the same latency.
///
/// Inner node: near only when tmax <= t, else far only when t_most <= tmin, else both: near with tmax := min(tmax,
/// t_most), and far with tmin := max(tmin, t) pushed, or gone to at once where the trail says that near is done.  A t
/// that is NaN is neither.  What is pushed never begins after what is below it on the stack, so that the top's tmin,
/// or `dropped_from`, is the least t at which anything left may be hit.
/// Leaf: the ray ends when its best t is less than that, which an empty leaf compares here and a leaf with triangles
/// leaves to `ti_trv_return`, as the number below it (`bound_o`).  Otherwise it goes on at the deepest level of the
/// trail that is not done: to the top of the short stack, or, where that entry has been dropped, down from the root
/// once more with the same comparisons, and so on the same way.  As a number with the root as its highest digit the
/// trail grows with each leaf, so every walk ends.  6 CMP.  A leaf of more than 65,535 triangles and an inner node below
/// the last level of the trail, which no builder writes, are memory errors.
module ti_kd_decide_padded #(
  parameter int unsigned StackDepth = 4,
  parameter bit Restart = 1'b1,
  parameter int unsigned WatchdogSteps = 65535,
  parameter bit IntervalCull = 1'b1,
  parameter int unsigned Guard = 4,
  /// Register stages behind the comparisons.
  parameter int unsigned CmpStages = ti_fp_pkg::CmpLatency,
  localparam int unsigned LevelWidth = (StackDepth > 0) ? $clog2(StackDepth + 1) : 1
) (
  input logic clk_i,
  input logic rst_ni,

  input ti_pkg::node_index_t root_i,  // constant

  input ti_pkg::node_index_t index_i,  // of the node
  input ti_kd_pkg::node_t node_i,
  input logic error_i,  // memory gave no node
  input logic negative_i,
  input ti_pkg::fp_t t_i,  // the least
  input ti_pkg::fp_t t_most_i,
  input ti_pkg::fp_t tmin_i,
  input ti_pkg::fp_t tmax_i,
  input ti_pkg::fp_t ray_tmin_i,  // the ray's interval, for restarts
  input ti_pkg::fp_t ray_tmax_i,
  input ti_pkg::fp_t tbest_i,
  input ti_pkg::steps_t steps_i,  // nodes visited before this one
  input logic [LevelWidth-1:0] level_i,  // entries on the stack
  input ti_kd_pkg::trail_t trail_i,
  // Least t of the entries dropped since the last restart, infinite without.
  input ti_pkg::fp_t dropped_from_i,
  input ti_pkg::node_index_t top_node_i,
  input ti_pkg::fp_t top_tmin_i,
  input ti_pkg::fp_t top_tmax_i,
  input ti_pkg::fp_t oldest_tmin_i,  // of the entry that a push onto a full stack drops

  output ti_pkg::steps_t steps_o,  // this node included, unless the watchdog stops before it
  output logic both_o,  // both children lie on the way
  output logic go_o,  // visit `next_o`, at once or after the leaf's triangles
  output ti_pkg::node_index_t next_o,
  output logic leaf_o,  // test the triangles of this leaf
  output ti_pkg::fp_t tnear_o,  // of these tests
  output ti_pkg::fp_t tfar_o,
  output ti_pkg::fp_t bound_o,  // the ray ends after them with a best t up to this
  output logic done_o,  // the ray is done, with `status_o`
  output ti_pkg::status_e status_o,
  output ti_pkg::fp_t tmin_o,
  output ti_pkg::fp_t tmax_o,
  output logic [LevelWidth-1:0] level_o,
  output ti_kd_pkg::trail_t trail_o,
  output ti_pkg::fp_t dropped_from_o,
  output logic push_o,  // (far_o, far_tmin_o, tmax_i as it was) onto the stack
  output ti_pkg::node_index_t far_o,
  output ti_pkg::fp_t far_tmin_o,
  output logic pop_o,
  output logic restart_o
);

  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;
  localparam int unsigned W = ti_num_pkg::FpWidth;
  localparam int unsigned Levels = ti_kd_pkg::TrailLevels;
  typedef ti_pkg::fp_t fp_t;

  logic leaf_here, before_near, up_to_tmin, best_ends, raise, bounded, lower;
  fp_t left_from, raised, bound;
  assign leaf_here = node_i.axis == 2'd3;
  assign left_from = (level_i != '0) ? top_tmin_i : dropped_from_i;

  // Near only; a leaf compares nothing here.
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_near (
    .a_i(tmax_i),
    .b_i(t_i),
    .lt_o(),
    .eq_o(),
    .le_o(before_near),
    .unordered_o()
  );
  // Far only; a leaf compares the best t with its exit.
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_far (
    .a_i(leaf_here ? tbest_i : t_most_i),
    .b_i(leaf_here ? tmax_i : tmin_i),
    .lt_o(),
    .eq_o(),
    .le_o(up_to_tmin),
    .unordered_o()
  );
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_raise (
    .a_i(tmin_i),
    .b_i(t_i),
    .lt_o(raise),
    .eq_o(),
    .le_o(),
    .unordered_o()
  );
  assign raised = raise ? t_i : tmin_i;
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_bounded (
    .a_i(left_from),
    .b_i(raised),
    .lt_o(bounded),
    .eq_o(),
    .le_o(),
    .unordered_o()
  );
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_lower (
    .a_i(t_most_i),
    .b_i(tmax_i),
    .lt_o(lower),
    .eq_o(),
    .le_o(),
    .unordered_o()
  );

  // The number below what is left, which is 0 or more: a best t up to it is less.  Below 0 stands no best t.
  assign bound = (left_from[W-2:0] == '0) ? {1'b1, (W - 1)'(1)} : left_from - 1'b1;
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_best (
    .a_i(tbest_i),
    .b_i(bound),
    .lt_o(),
    .eq_o(),
    .le_o(best_ends),
    .unordered_o()
  );

  // What is decided by, with the outcomes of the comparisons.
  typedef struct packed {
    ti_pkg::node_index_t   index;
    ti_kd_pkg::node_t      node;
    logic                  error;
    logic                  negative;
    fp_t                   t_most;
    fp_t                   tmin;
    fp_t                   tmax;
    fp_t                   ray_tmin;
    fp_t                   ray_tmax;
    fp_t                   tbest;
    ti_pkg::steps_t        steps;
    logic [LevelWidth-1:0] level;
    ti_kd_pkg::trail_t     trail;
    fp_t                   dropped_from;
    ti_pkg::node_index_t   top_node;
    fp_t                   top_tmin;
    fp_t                   top_tmax;
    fp_t                   oldest_tmin;
    fp_t                   raised;        // max(tmin, t)
    fp_t                   left_from;     // the least t of what is left
    fp_t                   bound;
    logic                  before_near;
    logic                  up_to_tmin;    // of a leaf: the best t is up to its exit
    logic                  best_ends;
    logic                  bounded;       // what is left begins before `raised`
    logic                  lower;         // t_most < tmax
  } at_t;
  at_t now, at;
  always_comb begin
    now = '{
        index: index_i,
        node: node_i,
        error: error_i,
        negative: negative_i,
        t_most: t_most_i,
        tmin: tmin_i,
        tmax: tmax_i,
        ray_tmin: ray_tmin_i,
        ray_tmax: ray_tmax_i,
        tbest: tbest_i,
        steps: steps_i,
        level: level_i,
        trail: trail_i,
        dropped_from: dropped_from_i,
        top_node: top_node_i,
        top_tmin: top_tmin_i,
        top_tmax: top_tmax_i,
        oldest_tmin: oldest_tmin_i,
        raised: raised,
        left_from: left_from,
        bound: bound,
        before_near: before_near,
        up_to_tmin: up_to_tmin,
        best_ends: best_ends,
        bounded: bounded,
        lower: lower
    };
  end
  ti_delay #(
    .payload_t(at_t),
    .Cycles   (CmpStages)
  ) u_at (
    .clk_i,
    .rst_ni,
    .data_i(now),
    .data_o(at)
  );

  logic is_leaf, near_is_adjacent, out_of_steps;
  ti_pkg::node_index_t near_node, adjacent;

  assign is_leaf          = at.node.axis == 2'd3;
  assign adjacent         = at.index + 1'b1;
  assign near_is_adjacent = at.negative ~^ at.node.reorder;
  assign near_node        = near_is_adjacent ? adjacent : at.node.link;
  assign far_o            = near_is_adjacent ? at.node.link : adjacent;
  assign far_tmin_o       = at.bounded ? at.left_from : at.raised;
  assign bound_o          = at.bound;
  assign out_of_steps     = at.steps >= ti_pkg::steps_t'(WatchdogSteps);
  assign steps_o          = out_of_steps ? at.steps : at.steps + 1'b1;

  // Outward in the order of bit patterns, down to 0, up to infinity at most.
  localparam fp_t GuardUlps = fp_t'(Guard);
  if (IntervalCull) begin : gen_interval_cull
    assign tnear_o = (at.tmin > GuardUlps) ? at.tmin - GuardUlps : '0;
    always_comb begin
      tfar_o = at.tmax + GuardUlps;
      if (at.tmax >= ti_num_pkg::Inf - GuardUlps) tfar_o = ti_num_pkg::Inf;
      if (at.up_to_tmin) tfar_o = at.tbest;
    end
  end else begin : gen_no_interval_cull
    assign tnear_o = '0;
    assign tfar_o  = at.tbest;
  end

  // The deepest level above this one with something left to do.
  logic [Levels-1:0] above, left;
  logic [5:0] deepest;
  logic any_left;
  assign above    = ~({Levels{1'b1}} << at.trail.level);
  assign left     = ~at.trail.done & above;
  assign any_left = left != '0;
  always_comb begin
    deepest = '0;
    for (int unsigned i = 0; i < Levels; i++) if (left[i]) deepest = 6'(i);
  end

  // More triangles than a leaf has, or a child below the last level of the trail.
  logic damaged, done_here;
  assign damaged   = is_leaf ? at.node.link[28:16] != '0 : at.trail.level == 7'(Levels);
  assign done_here = at.trail.done[at.trail.level[5:0]];
  assign both_o    = !is_leaf && !at.before_near && !at.up_to_tmin;

  always_comb begin
    go_o           = 1'b0;
    next_o         = near_node;
    leaf_o         = 1'b0;
    done_o         = 1'b0;
    status_o       = ti_pkg::Ok;
    tmin_o         = at.tmin;
    tmax_o         = at.tmax;
    level_o        = at.level;
    trail_o        = at.trail;
    dropped_from_o = at.dropped_from;
    push_o         = 1'b0;
    pop_o          = 1'b0;
    restart_o      = 1'b0;

    if (out_of_steps) begin
      done_o   = 1'b1;
      status_o = ti_pkg::Watchdog;
    end else if (at.error || damaged) begin
      done_o   = 1'b1;
      status_o = ti_pkg::MemoryError;
    end else if (is_leaf) begin
      leaf_o       = at.node.link[15:0] != '0;
      trail_o.done = (at.trail.done & ~({Levels{1'b1}} << deepest)) | (Levels'(1) << deepest);
      if ((!leaf_o && at.best_ends) || !any_left) begin
        done_o = !leaf_o;
      end else if (at.level != '0) begin
        go_o          = 1'b1;
        pop_o         = 1'b1;
        next_o        = at.top_node;
        tmin_o        = at.top_tmin;
        tmax_o        = at.top_tmax;
        level_o       = at.level - 1'b1;
        trail_o.level = 7'(deepest) + 1'b1;
      end else begin
        go_o           = Restart;
        restart_o      = Restart;
        next_o         = root_i;
        tmin_o         = at.ray_tmin;
        tmax_o         = at.ray_tmax;
        trail_o.level  = '0;
        dropped_from_o = ti_num_pkg::Inf;
      end
    end else begin
      go_o          = 1'b1;
      trail_o.level = at.trail.level + 1'b1;
      if (both_o && !done_here) begin
        push_o = 1'b1;
        if (at.lower) tmax_o = at.t_most;
        if (Restart && at.level == LevelWidth'(StackDepth)) begin
          dropped_from_o = (StackDepth == 0) ? far_tmin_o : at.oldest_tmin;
        end else begin
          level_o = at.level + 1'b1;
        end
      end else begin
        if (both_o) tmin_o = far_tmin_o;
        if (!at.before_near) next_o = far_o;
        trail_o.done[at.trail.level[5:0]] = 1'b1;
      end
    end
  end

endmodule : ti_kd_decide_padded
