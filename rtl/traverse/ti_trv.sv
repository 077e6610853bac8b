// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// TRV: traversal of the kd-tree for the rays that are at home here (Nah et al. 2011, section 4).
///
/// A ray takes a slot, and its nodes pass `ti_ra` (2 cycles on a hit), `ti_trv_step` and `ti_trv_decide` until it
/// reaches a leaf with triangles, which goes out to LIST, or its end.  From node to next request
/// `StepLatency` cycles; one step a cycle when enough rays are at home.  The pipeline never stalls: every queue
/// has a place for each slot.  Short stack: the newest `StackDepth` entries of each slot in one memory.
module ti_trv #(
  parameter int unsigned NumSlots = 8,
  parameter int unsigned StackDepth = 4,
  parameter int unsigned WatchdogSteps = 65535,
  parameter int unsigned Rows = 2,
  parameter int unsigned CacheBytes = 1024,
  parameter int unsigned Ways = 2,
  localparam int unsigned RowWidth = (Rows > 1) ? $clog2(Rows) : 1,
  localparam int unsigned GeometryLatency = 1,  // slot memory
  localparam int unsigned ArithmeticLatency = ti_fp_pkg::AddLatency + ti_fp_pkg::MulLatency,
  localparam int unsigned QueueLatency = 1,
  localparam int unsigned StepLatency = GeometryLatency + ArithmeticLatency + QueueLatency
) (
  input logic                clk_i,
  input logic                rst_ni,
  // Constants.  The number is a port and not a parameter so that all units are one module.
  input ti_pkg::trv_index_t  index_i,
  input ti_pkg::addr_t       node_base_i,
  input ti_pkg::node_index_t root_i,

  input  logic              dispatch_valid_i,
  output logic              dispatch_ready_o,
  input  ti_pkg::dispatch_t dispatch_data_i,

  output logic          leaf_valid_o,
  input  logic          leaf_ready_i,
  output ti_pkg::leaf_t leaf_data_o,

  input  logic            return_valid_i,
  output logic            return_ready_o,
  input  ti_pkg::return_t return_data_i,

  output logic         hit_valid_o,
  input  logic         hit_ready_i,
  output ti_pkg::hit_t hit_data_o,

  output logic                              line_req_valid_o,
  input  logic                              line_req_ready_i,
  output logic               [RowWidth-1:0] line_req_row_o,
  output ti_pkg::line_addr_t                line_req_line_o,

  input logic                         line_rsp_valid_i,
  input logic          [RowWidth-1:0] line_rsp_row_i,
  input ti_pkg::line_t                line_rsp_data_i,
  input logic                         line_rsp_error_i,

  output ti_pkg::trv_counters_t counters_o
);

  localparam int unsigned LevelWidth = $clog2(StackDepth + 1);
  localparam int unsigned PointerWidth = (StackDepth > 1) ? $clog2(StackDepth) : 1;
  localparam int unsigned StackWords = NumSlots * StackDepth;
  localparam int unsigned StackAddrWidth = $clog2(StackWords);

  typedef ti_pkg::trv_slot_t slot_t;
  typedef ti_pkg::fp_t fp_t;
  typedef ti_pkg::node_index_t node_index_t;

  typedef struct packed {
    slot_t       slot;
    node_index_t node;
  } want_t;

  typedef struct packed {
    ti_pkg::vec3_t o;
    ti_pkg::vec3_t inv;
  } geometry_t;

  typedef struct packed {
    ti_pkg::vec3_t o;
    ti_pkg::vec3_t d;
  } operands_t;

  typedef struct packed {
    fp_t tmin;
    fp_t tmax;
  } interval_t;

  typedef struct packed {
    interval_t               interval;
    ti_pkg::steps_t          steps;
    logic [LevelWidth-1:0]   level;
    logic [PointerWidth-1:0] pointer;   // where the next entry goes
    logic                    dropped;
  } state_t;

  typedef struct packed {
    node_index_t node;
    fp_t         tmax;
  } entry_t;

  typedef struct packed {
    slot_t              slot;
    logic [31:0]        first;
    ti_pkg::tri_count_t count;
    fp_t                tbest;
  } leaf_wait_t;

  typedef struct packed {
    slot_t           slot;
    ti_pkg::status_e status;
    ti_pkg::steps_t  steps;
  } over_t;

  // ---- Slots: a ray comes in.
  logic slot_free, start_ready, start, free;
  slot_t new_slot, freed_slot;
  logic [NumSlots-1:0] fresh_q;  // has not taken a step yet

  assign dispatch_ready_o = slot_free && start_ready;
  assign start            = dispatch_valid_i && dispatch_ready_o;

  ti_slot_pool #(
    .NumSlots(NumSlots)
  ) u_pool (
    .clk_i,
    .rst_ni,
    .free_valid_o(slot_free),
    .free_slot_o (new_slot),
    .take_i      (start),
    .give_i      (free),
    .give_slot_i (freed_slot)
  );

  // ---- Requests: steps, rays that go on after a leaf, and new rays take turns.
  logic step_push, resume, resume_restart, req_ready, rsp_valid, rsp_error;
  logic [2:0] want_valid, want_take;
  want_t [2:0] want;
  want_t step_want, resume_want;
  logic [1:0] want_index, want_from_q;
  logic want_any;
  slot_t rsp_slot;
  ti_pkg::node_t rsp_node;
  logic event_access, event_hit, event_merged, event_miss;

  ti_queue #(
    .payload_t(want_t),
    .Depth    (NumSlots)
  ) u_want_step (
    .clk_i,
    .rst_ni,
    .push_i     (step_push),
    .push_data_i(step_want),
    .out_valid_o(want_valid[0]),
    .out_ready_i(want_take[0]),
    .out_data_o (want[0])
  );

  ti_queue #(
    .payload_t(want_t),
    .Depth    (NumSlots)
  ) u_want_resume (
    .clk_i,
    .rst_ni,
    .push_i     (resume),
    .push_data_i(resume_want),
    .out_valid_o(want_valid[1]),
    .out_ready_i(want_take[1]),
    .out_data_o (want[1])
  );

  ti_queue #(
    .payload_t(slot_t),
    .Depth    (NumSlots)
  ) u_want_start (
    .clk_i,
    .rst_ni,
    .push_i     (start),
    .push_data_i(new_slot),
    .out_valid_o(want_valid[2]),
    .out_ready_i(want_take[2]),
    .out_data_o (want[2].slot)
  );
  assign want[2].node = root_i;

  ti_round_robin #(
    .Num(3)
  ) u_turn (
    .request_i(want_valid),
    .from_i   (want_from_q),
    .any_o    (want_any),
    .index_o  (want_index)
  );

  assign want_take = (want_any && req_ready) ? 3'b001 << want_index : '0;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) want_from_q <= '0;
    else if (want_any && req_ready) want_from_q <= (want_index == 2'd2) ? '0 : want_index + 1'b1;
  end

  ti_ra #(
    .NumSlots  (NumSlots),
    .Rows      (Rows),
    .AddrWidth (ti_pkg::AddrWidth),
    .LineBytes (ti_pkg::LineBytes),
    .ElemBytes (8),
    .CacheBytes(CacheBytes),
    .Ways      (Ways)
  ) u_ra (
    .clk_i,
    .rst_ni,
    .req_valid_i   (want_any),
    .req_ready_o   (req_ready),
    .req_slot_i    (want[want_index].slot),
    .req_addr_i    (node_base_i + (ti_pkg::addr_t'(want[want_index].node) << 3)),
    .rsp_valid_o   (rsp_valid),
    .rsp_ready_i   (1'b1),
    .rsp_slot_o    (rsp_slot),
    .rsp_elem_o    (rsp_node),
    .rsp_error_o   (rsp_error),
    .line_req_valid_o,
    .line_req_ready_i,
    .line_req_row_o,
    .line_req_line_o,
    .line_rsp_valid_i,
    .line_rsp_row_i,
    .line_rsp_data_i,
    .line_rsp_error_i,
    .event_access_o(event_access),
    .event_hit_o   (event_hit),
    .event_merged_o(event_merged),
    .event_miss_o  (event_miss)
  );

  // ---- The step.
  logic step_q, step_error_q, early_valid, late_valid_q, end_valid, end_error, end_negative;
  slot_t step_slot_q, early_slot, late_slot_q, end_slot;
  ti_pkg::node_t step_node_q, end_node;
  geometry_t geometry;
  fp_t end_t;

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(geometry_t)
  ) u_geometry (
    .clk_i,
    .read_en_i   (rsp_valid),
    .read_addr_i (rsp_slot),
    .read_data_o (geometry),
    .write_en_i  (start),
    .write_addr_i(new_slot),
    .write_data_i('{o: dispatch_data_i.ray.o, inv: dispatch_data_i.inv})
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) step_q <= 1'b0;
    else step_q <= rsp_valid;
  end
  always_ff @(posedge clk_i) begin
    if (rsp_valid) begin
      step_slot_q  <= rsp_slot;
      step_node_q  <= rsp_node;
      step_error_q <= rsp_error;
    end
  end

  ti_trv_step #(
    .TagWidth($bits(slot_t) + 1)
  ) u_step (
    .clk_i,
    .rst_ni,
    .valid_i   (step_q),
    .tag_i     ({step_slot_q, step_error_q}),
    .node_i    (step_node_q),
    .o_i       (geometry.o),
    .inv_i     (geometry.inv),
    .valid_o   (end_valid),
    .tag_o     ({end_slot, end_error}),
    .node_o    (end_node),
    .negative_o(end_negative),
    .t_o       (end_t)
  );

  // ---- The slot's state is read just in time: state, then what it points to, then the decision.
  logic go, leaf, over, push, pop, restart;
  node_index_t next_node, far;
  ti_pkg::status_e status;
  state_t state_ram, state, state_next;
  interval_t interval;
  entry_t top;
  node_index_t end_index;
  fp_t tbest;

  ti_delay #(
    .payload_t(logic [$bits(slot_t):0]),
    .Cycles   (ArithmeticLatency - 2)
  ) u_early (
    .clk_i,
    .rst_ni,
    .data_i({step_q, step_slot_q}),
    .data_o({early_valid, early_slot})
  );
  always_ff @(posedge clk_i) begin
    late_valid_q <= early_valid;
    late_slot_q  <= early_slot;
  end

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(state_t)
  ) u_state (
    .clk_i,
    .read_en_i   (early_valid),
    .read_addr_i (early_slot),
    .read_data_o (state_ram),
    .write_en_i  (end_valid),
    .write_addr_i(end_slot),
    .write_data_i(state_next)
  );

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(interval_t)
  ) u_interval (
    .clk_i,
    .read_en_i   (late_valid_q),
    .read_addr_i (late_slot_q),
    .read_data_o (interval),
    .write_en_i  (start),
    .write_addr_i(new_slot),
    .write_data_i('{tmin: dispatch_data_i.tmin, tmax: dispatch_data_i.tmax})
  );

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(node_index_t)
  ) u_index (
    .clk_i,
    .read_en_i   (late_valid_q),
    .read_addr_i (late_slot_q),
    .read_data_o (end_index),
    .write_en_i  (want_any && req_ready),
    .write_addr_i(want[want_index].slot),
    .write_data_i(want[want_index].node)
  );

  function automatic logic [StackAddrWidth-1:0] stack_addr(input slot_t slot,
                                                           input logic [PointerWidth-1:0] pointer);
    return StackAddrWidth'(slot) * StackAddrWidth'(StackDepth) + StackAddrWidth'(pointer);
  endfunction
  function automatic logic [PointerWidth-1:0] below(input logic [PointerWidth-1:0] pointer);
    return (pointer == '0) ? PointerWidth'(StackDepth - 1) : pointer - 1'b1;
  endfunction
  function automatic logic [PointerWidth-1:0] above(input logic [PointerWidth-1:0] pointer);
    return (pointer == PointerWidth'(StackDepth - 1)) ? '0 : pointer + 1'b1;
  endfunction

  state_t state_late_q;
  always_ff @(posedge clk_i) if (late_valid_q) state_late_q <= state_ram;

  ti_ram_1r1w #(
    .Depth (StackWords),
    .word_t(entry_t)
  ) u_stack (
    .clk_i,
    .read_en_i   (late_valid_q),
    .read_addr_i (stack_addr(late_slot_q, below(state_ram.pointer))),
    .read_data_o (top),
    .write_en_i  (end_valid && push),
    .write_addr_i(stack_addr(end_slot, state.pointer)),
    .write_data_i('{node: far, tmax: state.interval.tmax})
  );

  always_comb begin
    state = state_late_q;
    if (fresh_q[end_slot]) begin
      state          = '0;
      state.interval = interval;
    end
  end

  // ---- The decision.
  ti_trv_decide #(
    .StackDepth   (StackDepth),
    .WatchdogSteps(WatchdogSteps)
  ) u_decide (
    .root_i,
    .index_i   (end_index),
    .node_i    (end_node),
    .error_i   (end_error),
    .negative_i(end_negative),
    .t_i       (end_t),
    .tmin_i    (state.interval.tmin),
    .tmax_i    (state.interval.tmax),
    .ray_tmax_i(interval.tmax),
    .tbest_i   (tbest),
    .steps_i   (state.steps),
    .level_i   (state.level),
    .dropped_i (state.dropped),
    .top_node_i(top.node),
    .top_tmax_i(top.tmax),
    .steps_o   (state_next.steps),
    .go_o      (go),
    .next_o    (next_node),
    .leaf_o    (leaf),
    .over_o    (over),
    .status_o  (status),
    .tmin_o    (state_next.interval.tmin),
    .tmax_o    (state_next.interval.tmax),
    .level_o   (state_next.level),
    .dropped_o (state_next.dropped),
    .push_o    (push),
    .far_o     (far),
    .pop_o     (pop),
    .restart_o (restart)
  );

  assign state_next.pointer = push ? above(
      state.pointer
  ) : pop ? below(
      state.pointer
  ) : state.pointer;
  assign step_push = end_valid && go && !leaf;
  assign step_want = '{slot: end_slot, node: next_node};

  always_ff @(posedge clk_i) begin
    if (end_valid) fresh_q[end_slot] <= 1'b0;
    if (start) fresh_q[new_slot] <= 1'b1;
  end

  // ---- Leaves go out with the operands of their tests.
  logic leaf_wait_valid, leaf_wait_take, leaf_valid_q;
  leaf_wait_t leaf_wait, leaf_q;
  operands_t operands;

  ti_queue #(
    .payload_t(leaf_wait_t),
    .Depth    (NumSlots)
  ) u_leaves (
    .clk_i,
    .rst_ni,
    .push_i(end_valid && leaf),
    .push_data_i(
    '{slot: end_slot, first: end_node.value, count: end_node.link[15:0], tbest: tbest}
    ),
    .out_valid_o(leaf_wait_valid),
    .out_ready_i(leaf_wait_take),
    .out_data_o(leaf_wait)
  );

  assign leaf_wait_take = !leaf_valid_q || leaf_ready_i;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) leaf_valid_q <= 1'b0;
    else if (leaf_wait_take) leaf_valid_q <= leaf_wait_valid;
  end
  always_ff @(posedge clk_i) if (leaf_wait_take) leaf_q <= leaf_wait;

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(operands_t)
  ) u_operands (
    .clk_i,
    .read_en_i   (leaf_wait_valid && leaf_wait_take),
    .read_addr_i (leaf_wait.slot),
    .read_data_o (operands),
    .write_en_i  (start),
    .write_addr_i(new_slot),
    .write_data_i('{o: dispatch_data_i.ray.o, d: dispatch_data_i.ray.d})
  );

  assign leaf_valid_o = leaf_valid_q;
  assign leaf_data_o = '{
          home: '{trv: index_i, slot: leaf_q.slot},
          first: leaf_q.first,
          count: leaf_q.count,
          o: operands.o,
          d: operands.d,
          tbest: leaf_q.tbest
      };

  // ---- The way home.
  logic over_valid, over_ready;
  over_t over_slot;

  ti_queue #(
    .payload_t(over_t),
    .Depth    (NumSlots)
  ) u_over (
    .clk_i,
    .rst_ni,
    .push_i     (end_valid && over),
    .push_data_i('{slot: end_slot, status: status, steps: state_next.steps}),
    .out_valid_o(over_valid),
    .out_ready_i(over_ready),
    .out_data_o (over_slot)
  );

  ti_trv_return #(
    .NumSlots(NumSlots)
  ) u_return (
    .clk_i,
    .rst_ni,
    .start_i         (start),
    .start_ready_o   (start_ready),
    .start_slot_i    (new_slot),
    .start_ray_i     (dispatch_data_i.ray),
    .park_i          (end_valid && leaf),
    .park_slot_i     (end_slot),
    .park_count_i    (end_node.link[15:0]),
    .park_go_i       (go),
    .park_restart_i  (restart),
    .park_next_i     (next_node),
    .park_exit_i     (state.interval.tmax),
    .park_steps_i    (state_next.steps),
    .over_valid_i    (over_valid),
    .over_ready_o    (over_ready),
    .over_slot_i     (over_slot.slot),
    .over_status_i   (over_slot.status),
    .over_steps_i    (over_slot.steps),
    .return_valid_i,
    .return_ready_o,
    .return_data_i,
    .resume_o        (resume),
    .resume_slot_o   (resume_want.slot),
    .resume_node_o   (resume_want.node),
    .resume_restart_o(resume_restart),
    .tbest_read_i    (late_valid_q),
    .tbest_slot_i    (late_slot_q),
    .tbest_o         (tbest),
    .hit_valid_o,
    .hit_ready_i,
    .hit_data_o,
    .free_o          (free),
    .free_slot_o     (freed_slot)
  );

  // ---- Counters.
  ti_cache_counters u_cache_counters (
    .clk_i,
    .rst_ni,
    .event_access_i(event_access),
    .event_hit_i   (event_hit),
    .event_merged_i(event_merged),
    .event_miss_i  (event_miss),
    .counters_o    (counters_o.cache)
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      counters_o.steps       <= '0;
      counters_o.leaves      <= '0;
      counters_o.full_leaves <= '0;
      counters_o.restarts    <= '0;
      counters_o.rays        <= '0;
    end else begin
      if (end_valid) begin
        counters_o.steps <= counters_o.steps + 1'b1;
        if (end_node.axis == 2'd3) counters_o.leaves <= counters_o.leaves + 1'b1;
        if (leaf) counters_o.full_leaves <= counters_o.full_leaves + 1'b1;
      end
      // Counted when the ray goes, which a hit in the leaf may keep it from.
      counters_o.restarts <= counters_o.restarts + ti_pkg::counter_t'(step_push && restart) +
                             ti_pkg::counter_t'(resume && resume_restart);
      if (free) counters_o.rays <= counters_o.rays + 1'b1;
    end
  end

  if (NumSlots != 2 ** $bits(slot_t)) begin : gen_check_num_slots
    $error("ti_trv: NumSlots must be the configuration's power of two");
  end
  if (StackDepth < 1) begin : gen_check_stack_depth
    $error("ti_trv: StackDepth must be 1 or more");
  end
  if (WatchdogSteps < 1 || WatchdogSteps > 65535) begin : gen_check_watchdog_steps
    $error("ti_trv: WatchdogSteps must be 1 to 65535");
  end

  `TI_ASSERT(LeafHeldUntilTaken, leaf_valid_o && !leaf_ready_i |=> leaf_valid_o && $stable
                                 (leaf_data_o))
  `TI_ASSERT(
      IntervalNotEmpty,
      end_valid && !end_error |-> state.interval.tmin[ti_pkg::FpWidth-2:0] < state.interval.tmax[ti_pkg::FpWidth-2:0])

endmodule : ti_trv
