// SPDX-License-Identifier: Apache-2.0

/// What a ray does after a node: the traversal rules of `docs/architecture.md`.
///
/// Latency `CmpStages` cycles, all of them between the comparisons and the rest; combinational where that is 0.
/// Inner node: near only when not t < tmax (also when t is NaN), else far only when t <= tmin, else near with tmax := t
/// and the far child pushed.  The near child is the adjacent one exactly when the sign of the direction XNOR the node's
/// reorder flag (ODFL, Nah et al. 2011).  `<=` makes restarts end. Leaf: on to the top of the short stack; else, if an
/// entry was dropped, restart from the root at the leaf's exit; else the end.  A `StackDepth` of 0 drops every entry.
/// Without `Restart` the stack holds every entry that a tree can ask of it (`ti_kd_state` watches), none is dropped,
/// and no ray restarts.  An empty leaf also ends a ray whose best t does not exceed the exit; a leaf with triangles
/// leaves that to `ti_trv_return`.  2 CMP; with `CmpStages` 3, none behind a choice. The tests of a leaf count between `tnear_o` and `tfar_o`: in the leaf's
/// interval, moved outward by `Guard` ulp, and not beyond the best t; without `IntervalCull` from 0 to the best t.
/// A leaf of more than 65,535 triangles, which no builder writes, is a memory error.
module ti_kd_decide #(
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
  input ti_pkg::fp_t t_i,
  input ti_pkg::fp_t tmin_i,
  input ti_pkg::fp_t tmax_i,
  input ti_pkg::fp_t ray_tmax_i,  // end of the ray's interval, for restarts
  input ti_pkg::fp_t tbest_i,
  input ti_pkg::steps_t steps_i,  // nodes visited before this one
  input logic [LevelWidth-1:0] level_i,  // entries on the stack
  input logic dropped_i,  // an entry has been dropped since the last restart
  input ti_pkg::node_index_t top_node_i,
  input ti_pkg::fp_t top_tmax_i,

  output ti_pkg::steps_t steps_o,  // this node included, unless the watchdog stops before it
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
  output logic dropped_o,
  output logic push_o,  // (far_o, tmax_i as it was) onto the stack
  output ti_pkg::node_index_t far_o,
  output logic pop_o,
  output logic restart_o
);

  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;

  logic is_leaf, below_tmax, up_to_tmin, best_up_to_exit;
  assign is_leaf = node_i.axis == 2'd3;

  // An inner node compares t with both ends; a leaf compares the best t with its exit.
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_tmax (
    .a_i(t_i),
    .b_i(tmax_i),
    .lt_o(below_tmax),
    .eq_o(),
    .le_o(),
    .unordered_o()
  );
  if (CmpStages == 0) begin : gen_shared
    ti_fp_cmp #(
      .ExpBits (E),
      .FracBits(M)
    ) u_tmin (
      .a_i(is_leaf ? tbest_i : t_i),
      .b_i(is_leaf ? tmax_i : tmin_i),
      .lt_o(),
      .eq_o(),
      .le_o(up_to_tmin),
      .unordered_o()
    );
    assign best_up_to_exit = up_to_tmin;
  end else begin : gen_side_by_side
    ti_fp_cmp #(
      .ExpBits (E),
      .FracBits(M)
    ) u_tmin (
      .a_i(t_i),
      .b_i(tmin_i),
      .lt_o(),
      .eq_o(),
      .le_o(up_to_tmin),
      .unordered_o()
    );
    ti_fp_cmp #(
      .ExpBits (E),
      .FracBits(M)
    ) u_exit (
      .a_i(tbest_i),
      .b_i(tmax_i),
      .lt_o(),
      .eq_o(),
      .le_o(best_up_to_exit),
      .unordered_o()
    );
  end

  // Outward in the order of bit patterns, down to 0, up to infinity at most.
  localparam ti_pkg::fp_t GuardUlps = ti_pkg::fp_t'(Guard);
  ti_pkg::fp_t entry, leaf_exit;  // of the leaf, moved outward
  assign entry = (tmin_i > GuardUlps) ? tmin_i - GuardUlps : '0;
  assign leaf_exit = (tmax_i >= ti_num_pkg::Inf - GuardUlps) ? ti_num_pkg::Inf : tmax_i + GuardUlps;

  // What is decided by, with the outcomes of the comparisons.
  typedef struct packed {
    ti_pkg::node_index_t   index;
    ti_pkg::node_index_t   link;
    logic                  near_is_adjacent;
    logic                  error;
    ti_pkg::fp_t           t;
    ti_pkg::fp_t           tmin;
    ti_pkg::fp_t           tmax;
    ti_pkg::fp_t           ray_tmax;
    ti_pkg::fp_t           tbest;
    ti_pkg::fp_t           entry;
    ti_pkg::fp_t           leaf_exit;
    ti_pkg::steps_t        steps;
    logic [LevelWidth-1:0] level;
    logic                  dropped;
    ti_pkg::node_index_t   top_node;
    ti_pkg::fp_t           top_tmax;
    logic                  is_leaf;
    logic                  out_of_steps;
    logic                  has_triangles;
    logic                  stacked;           // entries are on the stack
    logic                  goes_beyond;       // the ray's interval does not end with the leaf's
    logic                  below_tmax;
    logic                  up_to_tmin;
    logic                  best_up_to_exit;   // of a leaf
  } at_t;
  at_t now, at;
  always_comb begin
    now = '{
        index: index_i,
        link: node_i.link,
        near_is_adjacent: negative_i ~^ node_i.reorder,
        error: error_i || (is_leaf && node_i.link[28:16] != '0),
        t: t_i,
        tmin: tmin_i,
        tmax: tmax_i,
        ray_tmax: ray_tmax_i,
        tbest: tbest_i,
        entry: entry,
        leaf_exit: leaf_exit,
        steps: steps_i,
        level: level_i,
        dropped: dropped_i,
        top_node: top_node_i,
        top_tmax: top_tmax_i,
        is_leaf: is_leaf,
        out_of_steps: steps_i >= ti_pkg::steps_t'(WatchdogSteps),
        has_triangles: node_i.link[15:0] != '0,
        stacked: level_i != '0,
        goes_beyond: tmax_i != ray_tmax_i,
        below_tmax: below_tmax,
        up_to_tmin: up_to_tmin,
        best_up_to_exit: best_up_to_exit
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

  logic best_ends;
  ti_pkg::node_index_t near_node, adjacent;

  assign best_ends = at.best_up_to_exit;
  assign adjacent  = at.index + 1'b1;
  assign near_node = at.near_is_adjacent ? adjacent : at.link;
  assign far_o     = at.near_is_adjacent ? at.link : adjacent;
  assign steps_o   = at.out_of_steps ? at.steps : at.steps + 1'b1;
  assign bound_o   = at.tmax;

  if (IntervalCull) begin : gen_interval_cull
    assign tnear_o = at.entry;
    assign tfar_o  = best_ends ? at.tbest : at.leaf_exit;
  end else begin : gen_no_interval_cull
    logic unused_interval;
    assign unused_interval = ^{at.entry, at.leaf_exit};
    assign tnear_o         = '0;
    assign tfar_o          = at.tbest;
  end

  // The next state, which means nothing for a ray that is done.
  always_comb begin
    next_o    = near_node;
    tmin_o    = at.tmin;
    tmax_o    = at.tmax;
    level_o   = at.level;
    dropped_o = at.dropped;
    if (at.is_leaf) begin
      tmin_o = at.tmax;
      if (at.stacked) begin
        next_o  = at.top_node;
        tmax_o  = at.top_tmax;
        level_o = at.level - 1'b1;
      end else begin
        next_o    = root_i;
        tmax_o    = at.ray_tmax;
        dropped_o = 1'b0;
      end
    end else if (at.below_tmax) begin
      if (at.up_to_tmin) begin
        next_o = far_o;
      end else begin
        tmax_o = at.t;
        if (Restart && at.level == LevelWidth'(StackDepth)) dropped_o = 1'b1;
        else level_o = at.level + 1'b1;
      end
    end
  end

  always_comb begin
    go_o      = 1'b0;
    leaf_o    = 1'b0;
    done_o    = 1'b0;
    status_o  = ti_pkg::Ok;
    push_o    = 1'b0;
    pop_o     = 1'b0;
    restart_o = 1'b0;
    if (at.out_of_steps) begin
      done_o   = 1'b1;
      status_o = ti_pkg::Watchdog;
    end else if (at.error) begin
      done_o   = 1'b1;
      status_o = ti_pkg::MemoryError;
    end else if (at.is_leaf) begin
      leaf_o = at.has_triangles;
      if (!at.has_triangles && best_ends) begin
        done_o = 1'b1;
      end else if (at.stacked) begin
        go_o  = 1'b1;
        pop_o = 1'b1;
      end else if (Restart && at.dropped && at.goes_beyond) begin
        go_o      = 1'b1;
        restart_o = 1'b1;
      end else begin
        done_o = !at.has_triangles;
      end
    end else begin
      go_o   = 1'b1;
      push_o = at.below_tmax && !at.up_to_tmin;
    end
  end

endmodule : ti_kd_decide
