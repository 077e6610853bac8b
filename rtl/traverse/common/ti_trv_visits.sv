// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// Which slot visits its next node: an arbiter of rays that step, rays that go on after a leaf, and new rays.
///
/// Every request is taken, as a slot stands here at most once.  2 cycles from request to visit when nobody else
/// waits, one visit a cycle; round robin among the three kinds, first come first served within one.
module ti_trv_visits #(
  parameter int unsigned NumSlots = 8
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

  logic [2:0] valid, ready, lost;
  visit_t request[3];
  visit_t visit;
  ti_pkg::trv_slot_t start_slot;

  ti_queue #(
    .payload_t(visit_t),
    .Depth    (NumSlots)
  ) u_steps (
    .clk_i,
    .rst_ni,
    .push_i     (step_i),
    .push_data_i('{slot: step_slot_i, node: step_node_i}),
    .out_valid_o(valid[0]),
    .out_ready_i(ready[0]),
    .out_data_o (request[0])
  );

  ti_queue #(
    .payload_t(visit_t),
    .Depth    (NumSlots)
  ) u_resumes (
    .clk_i,
    .rst_ni,
    .push_i     (resume_i),
    .push_data_i('{slot: resume_slot_i, node: resume_node_i}),
    .out_valid_o(valid[1]),
    .out_ready_i(ready[1]),
    .out_data_o (request[1])
  );

  ti_queue #(
    .payload_t(ti_pkg::trv_slot_t),
    .Depth    (NumSlots)
  ) u_starts (
    .clk_i,
    .rst_ni,
    .push_i     (start_i),
    .push_data_i(start_slot_i),
    .out_valid_o(valid[2]),
    .out_ready_i(ready[2]),
    .out_data_o (start_slot)
  );
  assign request[2] = '{slot: start_slot, node: root_i};

  ti_arbiter #(
    .payload_t(visit_t),
    .NumIn    (3)
  ) u_arbiter (
    .clk_i,
    .rst_ni,
    .in_valid_i (valid),
    .in_ready_o (ready),
    .in_lost_o  (lost),
    .in_data_i  (request),
    .out_valid_o(visit_valid_o),
    .out_ready_i(visit_ready_i),
    .out_data_o (visit)
  );
  logic unused_lost;
  assign unused_lost  = |lost;
  assign visit_slot_o = visit.slot;
  assign visit_node_o = visit.node;

  `TI_ASSERT_KNOWN(VisitValidKnown, visit_valid_o)

endmodule : ti_trv_visits
