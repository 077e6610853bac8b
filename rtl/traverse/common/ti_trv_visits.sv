// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Which slot visits its next node: an arbiter of rays that step, rays that go on after a leaf, and new rays.
///
/// Every request is taken, as a slot stands here at most once.  From request to visit 1 cycle for a step or a
/// resume when nobody waits, as they go past the empty queues; 2 for a new ray.  One visit a cycle; round robin among
/// the three queues, first come first served within one.
module ti_trv_visits #(
  parameter int unsigned NumSlots = 8,
  localparam int unsigned VisitLatency = 1  // the output; a new ray comes out of its queue first
) (
  input logic clk_i,
  input logic rst_ni,
  input ti_pkg::node_index_t root_i,

  input logic                step_i,
  input ti_pkg::trv_slot_t   step_slot_i,
  input ti_pkg::node_index_t step_node_i,

  input logic                resume_i,
  input ti_pkg::trv_slot_t   resume_slot_i,
  input ti_pkg::node_index_t resume_node_i,

  input logic              start_i,
  input ti_pkg::trv_slot_t start_slot_i,

  output logic                visit_valid_o,
  input  logic                visit_ready_i,
  output ti_pkg::trv_slot_t   visit_slot_o,
  output ti_pkg::node_index_t visit_node_o
);

  typedef struct packed {
    ti_pkg::trv_slot_t   slot;
    ti_pkg::node_index_t node;
  } visit_t;

  // Steps, resumes, starts.
  visit_t first[3];
  visit_t in, visit;
  ti_pkg::trv_slot_t start_slot;
  logic [2:0] waits, take;
  logic any, room, resume_past, step_past;
  logic [1:0] index, from_q;

  // Past the queues while nobody stands in one.  Whether a step comes is known late in its cycle: no choice between
  // queues looks at it.
  assign resume_past = !any && room && resume_i;
  assign step_past   = !any && room && step_i && !resume_i;

  ti_queue #(
    .payload_t(visit_t),
    .Depth    (NumSlots)
  ) u_steps (
    .clk_i,
    .rst_ni,
    .push_i     (step_i && !step_past),
    .push_data_i('{slot: step_slot_i, node: step_node_i}),
    .out_valid_o(waits[0]),
    .out_ready_i(take[0]),
    .out_data_o (first[0])
  );

  ti_queue #(
    .payload_t(visit_t),
    .Depth    (NumSlots)
  ) u_resumes (
    .clk_i,
    .rst_ni,
    .push_i     (resume_i && !resume_past),
    .push_data_i('{slot: resume_slot_i, node: resume_node_i}),
    .out_valid_o(waits[1]),
    .out_ready_i(take[1]),
    .out_data_o (first[1])
  );

  ti_queue #(
    .payload_t(ti_pkg::trv_slot_t),
    .Depth    (NumSlots)
  ) u_starts (
    .clk_i,
    .rst_ni,
    .push_i     (start_i),
    .push_data_i(start_slot_i),
    .out_valid_o(waits[2]),
    .out_ready_i(take[2]),
    .out_data_o (start_slot)
  );
  assign first[2] = '{slot: start_slot, node: root_i};

  ti_round_robin #(
    .Num(3)
  ) u_choice (
    .request_i(waits),
    .from_i   (from_q),
    .any_o    (any),
    .index_o  (index)
  );
  assign take = (any && room) ? 3'd1 << index : '0;
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) from_q <= '0;
    else if (any && room) from_q <= (index == 2'd2) ? '0 : index + 1'b1;
  end

  always_comb begin
    in = first[index];
    if (!any) begin
      if (resume_i) in = '{slot: resume_slot_i, node: resume_node_i};
      else in = '{slot: step_slot_i, node: step_node_i};
    end
  end
  ti_fifo #(
    .payload_t(visit_t),
    .Depth    (2)
  ) u_out (
    .clk_i,
    .rst_ni,
    .in_valid_i (any || resume_i || step_i),
    .in_ready_o (room),
    .in_data_i  (in),
    .out_valid_o(visit_valid_o),
    .out_ready_i(visit_ready_i),
    .out_data_o (visit)
  );
  assign visit_slot_o = visit.slot;
  assign visit_node_o = visit.node;

  `TI_ASSERT_KNOWN(VisitValidKnown, visit_valid_o)

endmodule : ti_trv_visits
