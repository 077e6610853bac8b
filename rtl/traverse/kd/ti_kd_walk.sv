// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// A step of the walk through the kd-tree: from a node that memory has given to what its ray does next.
///
/// The slot's origin and inverse (`GeometryLatency`), t of the split plane (`ti_kd_step`), and the decision with the
/// slot's state (`ti_kd_state`, `ti_kd_decide`), `CmpStages` cycles later.  One node a cycle, `Latency` cycles, no
/// stall.  `end_valid_o` says that a decision stands at the outputs.
module ti_kd_walk #(
  parameter int unsigned NumSlots = 8,
  parameter int unsigned StackDepth = 4,
  parameter int unsigned WatchdogSteps = 65535,
  parameter bit Restart = 1'b1,
  parameter bit Padded = 1'b0,
  localparam int unsigned GeometryLatency = 1,  // slot memory
  localparam int unsigned ArithmeticLatency = ti_fp_pkg::ChoiceLatency +
      ti_fp_pkg::AddLatency + ti_fp_pkg::MulLatency,
  localparam int unsigned CmpStages = ti_fp_pkg::CmpLatency,
  localparam int unsigned Latency = GeometryLatency + ArithmeticLatency + CmpStages
) (
  input logic                clk_i,
  input logic                rst_ni,
  input ti_pkg::node_index_t root_i,

  // A ray takes a slot.
  input logic                      start_i,
  input ti_pkg::trv_slot_t         start_slot_i,
  input ti_traverse_pkg::origins_t start_origins_i,
  input ti_pkg::vec3_t             start_inv_i,
  input ti_pkg::fp_t               start_tmin_i,
  input ti_pkg::fp_t               start_tmax_i,

  // A slot asks for a node.
  input logic                visit_i,
  input ti_pkg::trv_slot_t   visit_slot_i,
  input ti_pkg::node_index_t visit_node_i,

  // A node has come.
  input logic              node_valid_i,
  input ti_pkg::trv_slot_t node_slot_i,
  input ti_kd_pkg::node_t  node_i,
  input logic              node_error_i,  // or not, and memory has failed

  // The best t of a slot, asked for one cycle ahead.
  output logic              tbest_read_o,
  output ti_pkg::trv_slot_t tbest_slot_o,
  input  ti_pkg::fp_t       tbest_i,

  output logic                works_o,      // a node enters the arithmetic
  output logic                end_valid_o,
  output ti_pkg::trv_slot_t   end_slot_o,
  output logic                at_leaf_o,    // the node is a leaf
  output ti_pkg::list_index_t first_o,      // its list of triangles
  output ti_pkg::tri_count_t  count_o,
  output ti_pkg::steps_t      steps_o,      // from here on as of `ti_kd_decide`
  output logic                go_o,
  output ti_pkg::node_index_t next_o,
  output logic                leaf_o,
  output ti_pkg::fp_t         tnear_o,
  output ti_pkg::fp_t         tfar_o,
  output ti_pkg::fp_t         bound_o,
  output logic                done_o,
  output ti_pkg::status_e     status_o,
  output logic                restart_o
);

  localparam int unsigned LevelWidth = (StackDepth > 0) ? $clog2(StackDepth + 1) : 1;

  typedef ti_pkg::trv_slot_t slot_t;
  typedef ti_pkg::fp_t fp_t;
  typedef ti_pkg::node_index_t node_index_t;

  // Of a ray: the near origin, the inverse, and where it is thick the far origin above them.
  localparam int unsigned GeometryWidth = (Padded ? 3 : 2) * $bits(ti_pkg::vec3_t);
  typedef logic [GeometryWidth-1:0] geometry_t;

  // ---- The step.
  logic step_q, step_error_q, end_valid, end_error, end_negative;
  slot_t step_slot_q, end_slot;
  ti_kd_pkg::node_t step_node_q, end_node;
  geometry_t geometry;
  ti_traverse_pkg::origins_t origins;
  ti_pkg::vec3_t inv;
  fp_t end_t, end_t_most;

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(geometry_t)
  ) u_geometry (
    .clk_i,
    .read_en_i(node_valid_i),
    .read_addr_i(node_slot_i),
    .read_data_o(geometry),
    .write_en_i(start_i),
    .write_addr_i(start_slot_i),
    .write_data_i(geometry_t'({start_origins_i.most, start_origins_i.least, start_inv_i}))
  );
  assign inv           = geometry[$bits(inv)-1:0];
  assign origins.least = geometry[$bits(inv)+:$bits(inv)];
  assign origins.most  = geometry[GeometryWidth-1-:$bits(inv)];

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) step_q <= 1'b0;
    else step_q <= node_valid_i;
  end
  always_ff @(posedge clk_i) begin
    if (node_valid_i) begin
      step_slot_q  <= node_slot_i;
      step_node_q  <= node_i;
      step_error_q <= node_error_i;
    end
  end
  assign works_o = step_q;

  ti_kd_step #(
    .TagWidth($bits(slot_t) + 1),
    .Padded  (Padded)
  ) u_step (
    .clk_i,
    .rst_ni,
    .valid_i   (step_q),
    .tag_i     ({step_slot_q, step_error_q}),
    .node_i    (step_node_q),
    .origins_i (origins),
    .inv_i     (inv),
    .valid_o   (end_valid),
    .tag_o     ({end_slot, end_error}),
    .node_o    (end_node),
    .negative_o(end_negative),
    .t_o       (end_t),
    .t_most_o  (end_t_most)
  );

  // ---- The decision, with the slot's state.
  if (CmpStages == 0) begin : gen_at_once
    assign end_valid_o = end_valid;
  end else begin : gen_later
    logic [CmpStages:0] valid_q;
    assign valid_q[0]  = end_valid;
    assign end_valid_o = valid_q[CmpStages];
    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) valid_q[CmpStages:1] <= '0;
      else valid_q[CmpStages:1] <= valid_q[CmpStages-1:0];
    end
  end
  typedef struct packed {
    slot_t               slot;
    logic                at_leaf;
    ti_pkg::list_index_t first;
    ti_pkg::tri_count_t  count;
  } ended_t;
  ended_t now, at_end;
  always_comb begin
    now = '{
        slot: end_slot,
        at_leaf: end_node.axis == 2'd3,
        first: end_node.value,
        count: end_node.link[15:0]
    };
  end
  ti_delay #(
    .payload_t(ended_t),
    .Cycles   (CmpStages)
  ) u_end (
    .clk_i,
    .rst_ni,
    .data_i(now),
    .data_o(at_end)
  );
  assign end_slot_o = at_end.slot;
  assign at_leaf_o  = at_end.at_leaf;
  assign first_o    = at_end.first;
  assign count_o    = at_end.count;

  logic both, push, pop, dropped, dropped_next;
  node_index_t end_index, far_node, top_node;
  fp_t tmin, tmax, tmin_next, tmax_next, ray_tmin, ray_tmax, top_tmax;
  fp_t dropped_from, dropped_from_next, far_tmin, top_tmin, oldest_tmin;
  ti_kd_pkg::trail_t trail, trail_next;
  ti_pkg::steps_t steps;
  logic [LevelWidth-1:0] level, level_next;

  ti_kd_state #(
    .NumSlots  (NumSlots),
    .StackDepth(StackDepth),
    .Restart   (Restart),
    .Padded    (Padded),
    .Lead      (ArithmeticLatency),
    .Lag       (CmpStages)
  ) u_state (
    .clk_i,
    .rst_ni,
    .start_i,
    .start_slot_i,
    .start_tmin_i,
    .start_tmax_i,
    .visit_i,
    .visit_slot_i,
    .visit_node_i,
    .step_valid_i  (step_q),
    .step_slot_i   (step_slot_q),
    .late_valid_o  (tbest_read_o),
    .late_slot_o   (tbest_slot_o),
    .index_o       (end_index),
    .tmin_o        (tmin),
    .tmax_o        (tmax),
    .ray_tmin_o    (ray_tmin),
    .ray_tmax_o    (ray_tmax),
    .steps_o       (steps),
    .level_o       (level),
    .dropped_o     (dropped),
    .top_node_o    (top_node),
    .top_tmax_o    (top_tmax),
    .trail_o       (trail),
    .dropped_from_o(dropped_from),
    .top_tmin_o    (top_tmin),
    .oldest_tmin_o (oldest_tmin),
    .end_valid_i   (end_valid_o),
    .end_slot_i    (end_slot_o),
    .tmin_i        (tmin_next),
    .tmax_i        (tmax_next),
    .steps_i       (steps_o),
    .level_i       (level_next),
    .dropped_i     (dropped_next),
    .trail_i       (trail_next),
    .dropped_from_i(dropped_from_next),
    .far_tmin_i    (far_tmin),
    .push_i        (push),
    .far_i         (far_node),
    .pop_i         (pop)
  );

  if (Padded) begin : gen_padded
    ti_kd_decide_padded #(
      .StackDepth   (StackDepth),
      .Restart      (Restart),
      .WatchdogSteps(WatchdogSteps),
      .IntervalCull (ti_config_pkg::IntervalCull),
      .Guard        (ti_config_pkg::IntervalGuard)
    ) u_decide (
      .clk_i,
      .rst_ni,
      .root_i,
      .index_i       (end_index),
      .node_i        (end_node),
      .error_i       (end_error),
      .negative_i    (end_negative),
      .t_i           (end_t),
      .t_most_i      (end_t_most),
      .tmin_i        (tmin),
      .tmax_i        (tmax),
      .ray_tmin_i    (ray_tmin),
      .ray_tmax_i    (ray_tmax),
      .tbest_i,
      .steps_i       (steps),
      .level_i       (level),
      .trail_i       (trail),
      .dropped_from_i(dropped_from),
      .top_node_i    (top_node),
      .top_tmin_i    (top_tmin),
      .top_tmax_i    (top_tmax),
      .oldest_tmin_i (oldest_tmin),
      .steps_o,
      .both_o        (both),
      .go_o,
      .next_o,
      .leaf_o,
      .tnear_o,
      .tfar_o,
      .bound_o,
      .done_o,
      .status_o,
      .tmin_o        (tmin_next),
      .tmax_o        (tmax_next),
      .level_o       (level_next),
      .trail_o       (trail_next),
      .dropped_from_o(dropped_from_next),
      .push_o        (push),
      .far_o         (far_node),
      .far_tmin_o    (far_tmin),
      .pop_o         (pop),
      .restart_o
    );
    assign dropped_next = 1'b0;
    logic unused_dropped;
    assign unused_dropped = dropped;
  end else begin : gen_plain
    ti_kd_decide #(
      .StackDepth   (StackDepth),
      .Restart      (Restart),
      .WatchdogSteps(WatchdogSteps),
      .IntervalCull (ti_config_pkg::IntervalCull),
      .Guard        (ti_config_pkg::IntervalGuard)
    ) u_decide (
      .clk_i,
      .rst_ni,
      .root_i,
      .index_i   (end_index),
      .node_i    (end_node),
      .error_i   (end_error),
      .negative_i(end_negative),
      .t_i       (end_t),
      .tmin_i    (tmin),
      .tmax_i    (tmax),
      .ray_tmax_i(ray_tmax),
      .tbest_i,
      .steps_i   (steps),
      .level_i   (level),
      .dropped_i (dropped),
      .top_node_i(top_node),
      .top_tmax_i(top_tmax),
      .steps_o,
      .go_o,
      .next_o,
      .leaf_o,
      .tnear_o,
      .tfar_o,
      .bound_o,
      .done_o,
      .status_o,
      .tmin_o    (tmin_next),
      .tmax_o    (tmax_next),
      .level_o   (level_next),
      .dropped_o (dropped_next),
      .push_o    (push),
      .far_o     (far_node),
      .pop_o     (pop),
      .restart_o
    );
    assign both              = push;
    assign trail_next        = trail;
    assign dropped_from_next = dropped_from;
    assign far_tmin          = tmin;
    logic unused_padded;
    assign unused_padded = ^{end_t_most, ray_tmin, top_tmin, oldest_tmin};
  end

  `TI_ASSERT(
      IntervalNotEmpty,
      end_valid && !end_error -> tmin[ti_num_pkg::FpWidth-2:0] < tmax[ti_num_pkg::FpWidth-2:0])
  `TI_ASSERT(PushOnlyWhereBothChildrenLieOnTheWay, end_valid_o && push -> both)
  `TI_ASSERT_KNOWN(EndValidKnown, end_valid_o)

endmodule : ti_kd_walk
