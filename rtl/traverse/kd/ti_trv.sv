// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// TRV: traversal of the kd-tree for the rays that are at home here (Nah et al. 2011, section 4).
///
/// A ray takes a slot, and its nodes pass `ti_ra` (2 cycles on a hit) and `ti_kd_walk` until it reaches a leaf with
/// triangles, which goes out to LIST, or its end.  From node to next request `StepLatency` cycles; one step a cycle
/// when enough rays are at home.  The pipeline never stalls: every queue has a place for each slot.  Short stack: the
/// newest `StackDepth` entries of each slot in one memory.
/// `dispatch_ready_o` says that a slot is free, and stays until it is taken.
module ti_trv #(
  parameter int unsigned NumSlots = 8,
  parameter int unsigned StackDepth = 4,
  parameter int unsigned WatchdogSteps = 65535,
  parameter bit AnyHit = 1'b1,
  parameter bit Restart = 1'b1,
  parameter bit Padded = 1'b0,
  parameter int unsigned Rows = 2,
  parameter int unsigned CacheBytes = 1024,
  parameter int unsigned Ways = 2,
  localparam int unsigned GeometryLatency = 1,  // slot memory
  localparam int unsigned ArithmeticLatency = ti_fp_pkg::ChoiceLatency +
      ti_fp_pkg::AddLatency + ti_fp_pkg::MulLatency,
  localparam int unsigned ArbiterLatency = 1,
  localparam int unsigned StepLatency = GeometryLatency + ArithmeticLatency +
      ti_fp_pkg::CmpLatency + ArbiterLatency
) (
  input  logic                clk_i,
  input  logic                rst_ni,
  input  logic                flush_i,      // forget all lines; only while idle
  output logic                idle_o,       // no ray, nothing on its way
  // Constants.  The number is a port and not a parameter so that all units are one module.
  input  ti_pkg::trv_index_t  index_i,
  input  ti_mem_pkg::addr_t   node_base_i,
  input  ti_pkg::node_index_t root_i,

  input  logic                       dispatch_valid_i,
  output logic                       dispatch_ready_o,
  input  ti_traverse_pkg::dispatch_t dispatch_data_i,

  output logic          leaf_valid_o,
  input  logic          leaf_ready_i,
  output ti_pkg::leaf_t leaf_data_o,

  input  logic            return_valid_i,
  output logic            return_ready_o,
  input  ti_pkg::return_t return_data_i,

  output logic         hit_valid_o,
  input  logic         hit_ready_i,
  output ti_pkg::hit_t hit_data_o,

  output logic                  line_req_valid_o,
  input  logic                  line_req_ready_i,
  output ti_mem_pkg::line_req_t line_req_data_o,

  input  logic                  line_rsp_valid_i,
  output logic                  line_rsp_ready_o,
  input  ti_mem_pkg::line_rsp_t line_rsp_data_i,

  output ti_count_pkg::trv_events_t events_o  // `room` where an output waits
);

  typedef ti_pkg::trv_slot_t slot_t;
  typedef ti_pkg::fp_t fp_t;
  typedef ti_pkg::node_index_t node_index_t;

  // ---- Slots: a ray comes in.
  logic start, free;
  slot_t new_slot, freed_slot;

  assign start = dispatch_valid_i && dispatch_ready_o;

  ti_slot_pool #(
    .NumSlots(NumSlots)
  ) u_pool (
    .clk_i,
    .rst_ni,
    .free_valid_o(dispatch_ready_o),
    .free_slot_o (new_slot),
    .take_i      (start),
    .give_i      (free),
    .give_slot_i (freed_slot)
  );

  // ---- Requests: steps, rays that go on after a leaf, and new rays.
  logic step_push, resume, resume_restart, req_ready, rsp_valid, rsp_error;
  logic visit_valid;
  slot_t resume_slot, visit_slot, end_slot;
  node_index_t resume_node, visit_node, next_node;
  slot_t rsp_slot;
  ti_kd_pkg::node_t rsp_node;
  logic ra_idle, ra_waits;
  ti_count_pkg::cache_events_t cache_events;

  ti_trv_visits #(
    .NumSlots(NumSlots)
  ) u_visits (
    .clk_i,
    .rst_ni,
    .root_i,
    .step_i       (step_push),
    .step_slot_i  (end_slot),
    .step_node_i  (next_node),
    .resume_i     (resume),
    .resume_slot_i(resume_slot),
    .resume_node_i(resume_node),
    .start_i      (start),
    .start_slot_i (new_slot),
    .visit_valid_o(visit_valid),
    .visit_ready_i(req_ready),
    .visit_slot_o (visit_slot),
    .visit_node_o (visit_node)
  );

  ti_ra #(
    .NumSlots  (NumSlots),
    .Rows      (Rows),
    .ElemBytes (8),
    .CacheBytes(CacheBytes),
    .Ways      (Ways),
    .Mode      (ti_config_pkg::RayAccumulation)
  ) u_ra (
    .clk_i,
    .rst_ni,
    .flush_i,
    .idle_o     (ra_idle),
    .waits_o    (ra_waits),
    .req_valid_i(visit_valid),
    .req_ready_o(req_ready),
    .req_slot_i (visit_slot),
    .req_addr_i (node_base_i + (ti_mem_pkg::addr_t'(visit_node) << 3)),
    .rsp_valid_o(rsp_valid),
    .rsp_ready_i(1'b1),
    .rsp_slot_o (rsp_slot),
    .rsp_elem_o (rsp_node),
    .rsp_error_o(rsp_error),
    .line_req_valid_o,
    .line_req_ready_i,
    .line_req_data_o,
    .line_rsp_valid_i,
    .line_rsp_ready_o,
    .line_rsp_data_i,
    .events_o   (cache_events)
  );

  // ---- A step.
  logic step, late_valid, end_valid, go, leaf, done, restart;
  slot_t late_slot;
  logic at_leaf;
  ti_pkg::list_index_t leaf_first;
  ti_pkg::tri_count_t leaf_count;
  fp_t tbest, tnear, tfar, bound;
  ti_pkg::steps_t  steps;
  ti_pkg::status_e status;

  ti_kd_walk #(
    .NumSlots     (NumSlots),
    .StackDepth   (StackDepth),
    .WatchdogSteps(WatchdogSteps),
    .Restart      (Restart),
    .Padded       (Padded)
  ) u_walk (
    .clk_i,
    .rst_ni,
    .root_i,
    .start_i        (start),
    .start_slot_i   (new_slot),
    .start_origins_i(dispatch_data_i.origins),
    .start_inv_i    (dispatch_data_i.inv),
    .start_tmin_i   (dispatch_data_i.tmin),
    .start_tmax_i   (dispatch_data_i.tmax),
    .visit_i        (visit_valid && req_ready),
    .visit_slot_i   (visit_slot),
    .visit_node_i   (visit_node),
    .node_valid_i   (rsp_valid),
    .node_slot_i    (rsp_slot),
    .node_i         (rsp_node),
    .node_error_i   (rsp_error),
    .tbest_read_o   (late_valid),
    .tbest_slot_o   (late_slot),
    .tbest_i        (tbest),
    .works_o        (step),
    .end_valid_o    (end_valid),
    .end_slot_o     (end_slot),
    .at_leaf_o      (at_leaf),
    .first_o        (leaf_first),
    .count_o        (leaf_count),
    .steps_o        (steps),
    .go_o           (go),
    .next_o         (next_node),
    .leaf_o         (leaf),
    .tnear_o        (tnear),
    .tfar_o         (tfar),
    .bound_o        (bound),
    .done_o         (done),
    .status_o       (status),
    .restart_o      (restart)
  );
  assign step_push = end_valid && go && !leaf;

  // ---- Leaves go out with the operands of their tests.
  ti_trv_leaves #(
    .NumSlots(NumSlots)
  ) u_leaves (
    .clk_i,
    .rst_ni,
    .index_i,
    .start_i         (start),
    .start_slot_i    (new_slot),
    .start_operands_i(dispatch_data_i.operands),
    .push_i          (end_valid && leaf),
    .push_slot_i     (end_slot),
    .push_first_i    (leaf_first),
    .push_count_i    (leaf_count),
    .push_tnear_i    (tnear),
    .push_tfar_i     (tfar),
    .leaf_valid_o,
    .leaf_ready_i,
    .leaf_data_o
  );

  // ---- The way home.
  ti_trv_return #(
    .NumSlots(NumSlots),
    .AnyHit  (AnyHit),
    .Restart (Restart)
  ) u_return (
    .clk_i,
    .rst_ni,
    .start_i         (start),
    .start_slot_i    (new_slot),
    .start_ray_id_i  (dispatch_data_i.ray_id),
    .start_any_hit_i (dispatch_data_i.any_hit),
    .start_tmin_i    (dispatch_data_i.ray_tmin),
    .start_tmax_i    (dispatch_data_i.ray_tmax),
    .park_i          (end_valid && leaf),
    .done_i          (end_valid && done),
    .stop_slot_i     (end_slot),
    .stop_steps_i    (steps),
    .done_status_i   (status),
    .park_count_i    (leaf_count),
    .park_go_i       (go),
    .park_restart_i  (restart),
    .park_next_i     (next_node),
    .park_bound_i    (bound),
    .return_valid_i,
    .return_ready_o,
    .return_data_i,
    .resume_o        (resume),
    .resume_slot_o   (resume_slot),
    .resume_node_o   (resume_node),
    .resume_restart_o(resume_restart),
    .tbest_read_i    (late_valid),
    .tbest_slot_i    (late_slot),
    .tbest_o         (tbest),
    .hit_valid_o,
    .hit_ready_i,
    .hit_data_o,
    .free_o          (free),
    .free_slot_o     (freed_slot)
  );

  // ---- What happens, for counting.
  logic at_home;

  ti_trv_account #(
    .NumSlots(NumSlots)
  ) u_account (
    .clk_i,
    .rst_ni,
    .start_i         (start),
    .free_i          (free),
    .works_i         (step),
    .memory_i        (ra_waits),
    .blocked_i       ((leaf_valid_o && !leaf_ready_i) || (hit_valid_o && !hit_ready_i)),
    .end_i           (end_valid),
    .again_i         (step_push),
    .restart_i       (restart),
    .leaf_i          (at_leaf && status == ti_pkg::Ok),
    .full_leaf_i     (leaf),
    .resume_i        (resume),
    .resume_restart_i(resume_restart),
    .cache_i         (cache_events),
    .at_home_o       (at_home),
    .events_o
  );
  assign idle_o = !at_home && ra_idle;

  if (NumSlots != 2 ** $bits(slot_t)) begin : gen_check_num_slots
    $error("ti_trv: NumSlots must be the configuration's power of two");
  end
  if (WatchdogSteps < 1 || WatchdogSteps > ti_config_pkg::WatchdogSteps)
  begin : gen_check_watchdog_steps
    $error("ti_trv: WatchdogSteps must be 1 to the configuration's");
  end

  `TI_ASSERT_KNOWN(DispatchReadyKnown, dispatch_ready_o)
  `TI_ASSERT_KNOWN(LeafValidKnown, leaf_valid_o)
  `TI_ASSERT_KNOWN(ReturnReadyKnown, return_ready_o)
  `TI_ASSERT_KNOWN(HitValidKnown, hit_valid_o)
  `TI_ASSERT_KNOWN(LineReqValidKnown, line_req_valid_o)
  `TI_ASSERT_KNOWN(LineRspReadyKnown, line_rsp_ready_o)

endmodule : ti_trv
