// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// What a TRV remembers of each slot between steps: interval, step count, node, and the short stack.
///
/// Read just in time for the decision: a slot that enters the arithmetic with `step_valid_i` has its state at
/// the outputs `Lead` cycles later, in the cycle in which `end_valid_i` writes the next state.
/// The stack of a slot is a ring of `StackDepth` entries in one memory of all slots; pushing onto a full ring
/// overwrites the oldest, and with a `StackDepth` of 0 there is none.  A slot that has just been taken reads as a
/// fresh ray, so a start writes the interval alone.
module ti_kd_state #(
  parameter int unsigned NumSlots = 8,
  parameter int unsigned StackDepth = 4,
  /// Cycles from step to end, 3 or more.
  parameter int unsigned Lead = 7,
  localparam int unsigned LevelWidth = (StackDepth > 0) ? $clog2(StackDepth + 1) : 1
) (
  input logic clk_i,
  input logic rst_ni,

  // A ray takes a slot.
  input logic              start_i,
  input ti_pkg::trv_slot_t start_slot_i,
  input ti_pkg::fp_t       start_tmin_i,
  input ti_pkg::fp_t       start_tmax_i,

  // A slot asks for a node.
  input logic                visit_i,
  input ti_pkg::trv_slot_t   visit_slot_i,
  input ti_pkg::node_index_t visit_node_i,

  // A slot enters the arithmetic.
  input logic              step_valid_i,
  input ti_pkg::trv_slot_t step_slot_i,

  // One cycle before its end, for memories elsewhere that are read with it.
  output logic              late_valid_o,
  output ti_pkg::trv_slot_t late_slot_o,

  // Its end: the state as it was, and what to write.
  input  logic                                 end_valid_i,
  input  ti_pkg::trv_slot_t                    end_slot_i,
  output ti_pkg::node_index_t                  index_o,
  output ti_pkg::fp_t                          tmin_o,
  output ti_pkg::fp_t                          tmax_o,
  output ti_pkg::fp_t                          ray_tmax_o,
  output ti_pkg::steps_t                       steps_o,
  output logic                [LevelWidth-1:0] level_o,
  output logic                                 dropped_o,
  output ti_pkg::node_index_t                  top_node_o,
  output ti_pkg::fp_t                          top_tmax_o,
  input  ti_pkg::fp_t                          tmin_i,
  input  ti_pkg::fp_t                          tmax_i,
  input  ti_pkg::steps_t                       steps_i,
  input  logic                [LevelWidth-1:0] level_i,
  input  logic                                 dropped_i,
  input  logic                                 push_i,       // (far_i, tmax_o) onto the stack
  input  ti_pkg::node_index_t                  far_i,
  input  logic                                 pop_i
);

  localparam int unsigned PointerWidth = (StackDepth > 1) ? $clog2(StackDepth) : 1;

  typedef ti_pkg::trv_slot_t slot_t;
  typedef logic [PointerWidth-1:0] pointer_t;

  typedef struct packed {
    ti_pkg::fp_t tmin;
    ti_pkg::fp_t tmax;
  } interval_t;

  typedef struct packed {
    interval_t             interval;
    ti_pkg::steps_t        steps;
    logic [LevelWidth-1:0] level;
    pointer_t              pointer;   // where the next entry goes
    logic                  dropped;
  } state_t;

  typedef struct packed {
    ti_pkg::node_index_t node;
    ti_pkg::fp_t         tmax;
  } entry_t;

  // Two cycles before the end the state is read, one before it what the state points to.
  localparam int unsigned EarlyLatency = Lead - 2;
  logic [EarlyLatency:0] valid_q;
  logic early_valid;
  slot_t early_slot;
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) valid_q <= '0;
    else valid_q <= {valid_q[EarlyLatency-1:0], step_valid_i};
  end
  assign early_valid  = valid_q[EarlyLatency-1];
  assign late_valid_o = valid_q[EarlyLatency];

  ti_delay #(
    .payload_t(slot_t),
    .Cycles   (EarlyLatency)
  ) u_early (
    .clk_i,
    .rst_ni,
    .data_i(step_slot_i),
    .data_o(early_slot)
  );
  always_ff @(posedge clk_i) late_slot_o <= early_slot;

  state_t state_ram, state_q, state, state_next;
  interval_t interval;
  entry_t top;
  pointer_t late_top, pointer_below, pointer_above;
  logic [NumSlots-1:0] fresh_q;  // has not taken a step yet

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(state_t)
  ) u_state (
    .clk_i,
    .read_en_i   (early_valid),
    .read_addr_i (early_slot),
    .read_data_o (state_ram),
    .write_en_i  (end_valid_i),
    .write_addr_i(end_slot_i),
    .write_data_i(state_next)
  );

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(interval_t)
  ) u_interval (
    .clk_i,
    .read_en_i   (late_valid_o),
    .read_addr_i (late_slot_o),
    .read_data_o (interval),
    .write_en_i  (start_i),
    .write_addr_i(start_slot_i),
    .write_data_i('{tmin: start_tmin_i, tmax: start_tmax_i})
  );

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(ti_pkg::node_index_t)
  ) u_index (
    .clk_i,
    .read_en_i   (late_valid_o),
    .read_addr_i (late_slot_o),
    .read_data_o (index_o),
    .write_en_i  (visit_i),
    .write_addr_i(visit_slot_i),
    .write_data_i(visit_node_i)
  );

  // The memory of all slots' rings, and where entries of a ring stand in it.
  if (StackDepth > 0) begin : gen_stack
    localparam int unsigned StackWords = NumSlots * StackDepth;
    localparam int unsigned StackAddrWidth = $clog2(StackWords);
    logic [StackAddrWidth-1:0] top_place, push_place;
    assign top_place = StackAddrWidth'(late_slot_o) * StackAddrWidth'(StackDepth) +
      StackAddrWidth'(late_top);
    assign push_place = StackAddrWidth'(end_slot_i) * StackAddrWidth'(StackDepth) +
      StackAddrWidth'(state.pointer);

    ti_ram_1r1w #(
      .Depth (StackWords),
      .word_t(entry_t)
    ) u_stack (
      .clk_i,
      .read_en_i(late_valid_o),
      .read_addr_i(top_place),
      .read_data_o(top),
      .write_en_i(end_valid_i && push_i),
      .write_addr_i(push_place),
      .write_data_i('{node: far_i, tmax: state.interval.tmax})
    );
  end else begin : gen_no_stack
    logic unused;
    assign unused = ^{far_i, late_top};
    assign top = '0;
  end

  always_ff @(posedge clk_i) begin
    if (late_valid_o) state_q <= state_ram;
    if (end_valid_i) fresh_q[end_slot_i] <= 1'b0;
    if (start_i) fresh_q[start_slot_i] <= 1'b1;
  end

  always_comb begin
    state = state_q;
    if (fresh_q[end_slot_i]) begin
      state          = '0;
      state.interval = interval;
    end
  end

  assign late_top = (state_ram.pointer == '0) ? pointer_t'(StackDepth - 1) :
      state_ram.pointer - 1'b1;
  assign pointer_below = (state.pointer == '0) ? pointer_t'(StackDepth - 1) : state.pointer - 1'b1;
  assign pointer_above = (state.pointer == pointer_t'(StackDepth - 1)) ? '0 : state.pointer + 1'b1;

  assign state_next = '{
          interval: '{tmin: tmin_i, tmax: tmax_i},
          steps: steps_i,
          level: level_i,
          pointer: push_i ? pointer_above : pop_i ? pointer_below : state.pointer,
          dropped: dropped_i
      };

  assign tmin_o = state.interval.tmin;
  assign tmax_o = state.interval.tmax;
  assign ray_tmax_o = interval.tmax;
  assign steps_o = state.steps;
  assign level_o = state.level;
  assign dropped_o = state.dropped;
  assign top_node_o = top.node;
  assign top_tmax_o = top.tmax;

  if (Lead < 3) begin : gen_check_lead
    $error("ti_kd_state: Lead must be 3 or more");
  end

  `TI_ASSERT_KNOWN(LateValidKnown, late_valid_o)

endmodule : ti_kd_state
