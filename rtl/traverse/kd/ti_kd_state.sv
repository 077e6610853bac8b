// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// What a TRV remembers of each slot between steps: interval, step count, node, and the short stack.
///
/// Read just in time for the decision: a slot that enters the arithmetic with `step_valid_i` has its state at the
/// outputs `Lead` cycles later; `end_valid_i` writes the next state `Lag` cycles after that. The stack of a slot is a
/// ring of `StackDepth` entries in one memory of all slots; pushing onto a full ring overwrites the oldest, and with a
/// `StackDepth` of 0 there is none.  Without `Restart` nothing is pushed onto a full stack, so that an entry's place is
/// its level, and the ring's pointer and the flag of a dropped entry are not there.  A slot that has just been taken
/// reads as a fresh ray, so a start writes the interval alone.
module ti_kd_state #(
  parameter int unsigned NumSlots = 8,
  parameter int unsigned StackDepth = 4,
  /// Whether a stack may overflow.
  parameter bit Restart = 1'b1,
  /// Whether rays are thick: entries with a tmin of their own, the restart trail, the t of what was dropped.
  parameter bit Padded = 1'b0,
  /// Cycles from step to end, 3 or more.
  parameter int unsigned Lead = 7,
  /// Cycles from the state at the outputs to the end.
  parameter int unsigned Lag = 0,
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

  // The state as it was.
  output ti_pkg::node_index_t                  index_o,
  output ti_pkg::fp_t                          tmin_o,
  output ti_pkg::fp_t                          tmax_o,
  output ti_pkg::fp_t                          ray_tmin_o,
  output ti_pkg::fp_t                          ray_tmax_o,
  output ti_pkg::steps_t                       steps_o,
  output logic                [LevelWidth-1:0] level_o,
  output logic                                 dropped_o,
  output ti_pkg::node_index_t                  top_node_o,
  output ti_pkg::fp_t                          top_tmax_o,
  output ti_kd_pkg::trail_t                    trail_o,         // of thick rays, as the next four
  output ti_pkg::fp_t                          dropped_from_o,
  output ti_pkg::fp_t                          top_tmin_o,
  // Of the entry that a push onto a full ring drops.
  output ti_pkg::fp_t                          oldest_tmin_o,
  // Its end, and what to write.
  input  logic                                 end_valid_i,
  input  ti_pkg::trv_slot_t                    end_slot_i,
  input  ti_pkg::fp_t                          tmin_i,
  input  ti_pkg::fp_t                          tmax_i,
  input  ti_pkg::steps_t                       steps_i,
  input  logic                [LevelWidth-1:0] level_i,
  input  logic                                 dropped_i,
  input  ti_kd_pkg::trail_t                    trail_i,         // of thick rays, as the next two
  input  ti_pkg::fp_t                          dropped_from_i,
  input  ti_pkg::fp_t                          far_tmin_i,
  // (far_i, far_tmin_i, tmax_o as it was) onto the stack.
  input  logic                                 push_i,
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

  // Of a stack that may overflow.
  typedef struct packed {
    pointer_t pointer;  // where the next entry goes
    logic     dropped;
  } ring_t;

  typedef struct packed {
    ring_t                 ring;
    interval_t             interval;
    ti_pkg::steps_t        steps;
    logic [LevelWidth-1:0] level;
  } state_t;

  localparam int unsigned StateWidth = $bits(state_t) - (Restart ? 0 : $bits(ring_t));
  typedef logic [StateWidth-1:0] word_t;

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

  word_t word;
  state_t late, state_q;
  interval_t interval, interval_q;
  ti_pkg::fp_t end_tmax;
  logic late_fresh_q;  // read with the state
  logic [LevelWidth-1:0] end_level;
  entry_t top;
  pointer_t
      late_pointer, late_top, now_pointer, pointer, pointer_below, pointer_above, pointer_next;
  logic [NumSlots-1:0] fresh_q;  // has not taken a step yet

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(word_t)
  ) u_state (
    .clk_i,
    .read_en_i   (early_valid),
    .read_addr_i (early_slot),
    .read_data_o (word),
    .write_en_i  (end_valid_i),
    .write_addr_i(end_slot_i),
    .write_data_i(word_t'({pointer_next, dropped_i, tmin_i, tmax_i, steps_i, level_i}))
  );

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(interval_t)
  ) u_interval (
    .clk_i,
    .read_en_i   (early_valid),
    .read_addr_i (early_slot),
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
      StackAddrWidth'(pointer);

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
      .write_data_i('{node: far_i, tmax: end_tmax})
    );
  end else begin : gen_no_stack
    logic unused;
    assign unused = ^{far_i, late_top, end_tmax};
    assign top = '0;
  end

  always_comb begin
    late = $bits(state_t)'(word);
    if (late_fresh_q) begin
      late          = '0;
      late.interval = interval;
    end
  end
  always_ff @(posedge clk_i) begin
    if (early_valid) late_fresh_q <= fresh_q[early_slot];
    if (late_valid_o) begin
      state_q    <= late;
      interval_q <= interval;
    end
    if (end_valid_i) fresh_q[end_slot_i] <= 1'b0;
    if (start_i) fresh_q[start_slot_i] <= 1'b1;
  end

  // What the walk of a thick ray has beside that.
  if (Padded) begin : gen_padded
    typedef struct packed {
      ti_kd_pkg::trail_t trail;
      ti_pkg::fp_t       dropped_from;
    } walk_t;
    walk_t walk, walk_q;

    ti_ram_1r1w #(
      .Depth (NumSlots),
      .word_t(walk_t)
    ) u_walk (
      .clk_i,
      .read_en_i   (early_valid),
      .read_addr_i (early_slot),
      .read_data_o (walk),
      .write_en_i  (end_valid_i),
      .write_addr_i(end_slot_i),
      .write_data_i('{trail: trail_i, dropped_from: dropped_from_i})
    );
    always_ff @(posedge clk_i) begin
      if (late_valid_o) begin
        walk_q <= walk;
        if (late_fresh_q) walk_q <= '{trail: '0, dropped_from: ti_num_pkg::Inf};
      end
    end
    assign trail_o        = walk_q.trail;
    assign dropped_from_o = walk_q.dropped_from;

    if (StackDepth > 0) begin : gen_tmin
      localparam int unsigned StackWords = NumSlots * StackDepth;
      localparam int unsigned StackAddrWidth = $clog2(StackWords);
      logic [StackAddrWidth-1:0] first, push_first;
      assign first      = StackAddrWidth'(late_slot_o) * StackAddrWidth'(StackDepth);
      assign push_first = StackAddrWidth'(end_slot_i) * StackAddrWidth'(StackDepth);

      ti_ram_1r1w #(
        .Depth (StackWords),
        .word_t(ti_pkg::fp_t)
      ) u_top_tmin (
        .clk_i,
        .read_en_i   (late_valid_o),
        .read_addr_i (first + StackAddrWidth'(late_top)),
        .read_data_o (top_tmin_o),
        .write_en_i  (end_valid_i && push_i),
        .write_addr_i(push_first + StackAddrWidth'(pointer)),
        .write_data_i(far_tmin_i)
      );
      if (Restart) begin : gen_oldest
        ti_ram_1r1w #(
          .Depth (StackWords),
          .word_t(ti_pkg::fp_t)
        ) u_oldest_tmin (
          .clk_i,
          .read_en_i   (late_valid_o),
          .read_addr_i (first + StackAddrWidth'(late_pointer)),
          .read_data_o (oldest_tmin_o),
          .write_en_i  (end_valid_i && push_i),
          .write_addr_i(push_first + StackAddrWidth'(pointer)),
          .write_data_i(far_tmin_i)
        );
      end else begin : gen_no_oldest
        assign oldest_tmin_o = '0;
      end
    end else begin : gen_no_tmin
      logic unused_tmin;
      assign unused_tmin   = ^far_tmin_i;
      assign top_tmin_o    = '0;
      assign oldest_tmin_o = '0;
    end
  end else begin : gen_plain
    logic unused_walk;
    assign unused_walk    = ^{trail_i, dropped_from_i, far_tmin_i};
    assign trail_o        = '0;
    assign dropped_from_o = '0;
    assign top_tmin_o     = '0;
    assign oldest_tmin_o  = '0;
  end

  // Where the next entry goes: one cycle before the state is at the outputs, and at the end.
  if (Restart) begin : gen_ring
    assign late_pointer = word[StateWidth-1-:PointerWidth];
    assign now_pointer  = state_q.ring.pointer;
  end else begin : gen_no_ring
    assign late_pointer = pointer_t'(word[LevelWidth-1:0]);
    assign now_pointer  = pointer_t'(state_q.level);
  end
  ti_delay #(
    .payload_t(logic [PointerWidth+LevelWidth+$bits(ti_pkg::fp_t)-1:0]),
    .Cycles   (Lag)
  ) u_end (
    .clk_i,
    .rst_ni,
    .data_i({now_pointer, state_q.level, state_q.interval.tmax}),
    .data_o({pointer, end_level, end_tmax})
  );
  assign late_top = (late_pointer == '0) ? pointer_t'(StackDepth - 1) : late_pointer - 1'b1;
  assign pointer_below = (pointer == '0) ? pointer_t'(StackDepth - 1) : pointer - 1'b1;
  assign pointer_above = (pointer == pointer_t'(StackDepth - 1)) ? '0 : pointer + 1'b1;

  assign pointer_next = push_i ? pointer_above : pop_i ? pointer_below : pointer;

  assign tmin_o = state_q.interval.tmin;
  assign tmax_o = state_q.interval.tmax;
  assign ray_tmin_o = interval_q.tmin;
  assign ray_tmax_o = interval_q.tmax;
  assign steps_o = state_q.steps;
  assign level_o = state_q.level;
  assign dropped_o = state_q.ring.dropped;
  assign top_node_o = top.node;
  assign top_tmax_o = top.tmax;

  if (Lead < 3) begin : gen_check_lead
    $error("ti_kd_state: Lead must be 3 or more");
  end

  `TI_ASSERT(StackOverflowsOnlyWithRestarts,
             end_valid_i && push_i -> Restart || 32'(end_level) < StackDepth)
  `TI_ASSERT(NoPopOfNothing, end_valid_i && pop_i -> end_level != '0)
  `TI_ASSERT_KNOWN(LateValidKnown, late_valid_o)

endmodule : ti_kd_state
