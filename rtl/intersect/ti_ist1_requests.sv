// SPDX-License-Identifier: Apache-2.0

/// Requests of a `ti_ist1`: the plane part of a new test, the barycentric part of one that goes on, round robin.
///
/// From a test to its request 2 cycles, one a cycle; the queues have a place for each slot.  A record has 32 bytes of plane
/// part and 16 of barycentric part, two of which are one element of 32 bytes.
module ti_ist1_requests #(
  parameter  int unsigned NumSlots  = 8,
  localparam int unsigned SlotWidth = $clog2(NumSlots)
) (
  input logic              clk_i,
  input logic              rst_ni,
  input ti_mem_pkg::addr_t plane_base_i,
  input ti_mem_pkg::addr_t bary_base_i,

  // A new test.
  input logic                            take_i,
  input logic            [SlotWidth-1:0] take_slot_i,
  input ti_pkg::record_t                 record_i,

  // A test that has passed (a).
  input logic                 go_on_i,
  input logic [SlotWidth-1:0] go_on_slot_i,

  output logic                              req_valid_o,
  input  logic                              req_ready_i,
  output logic              [SlotWidth-1:0] req_slot_o,
  output ti_mem_pkg::addr_t                 req_addr_o,

  // What a slot has asked for.
  input  logic [SlotWidth-1:0] slot_i,
  output logic                 pass_b_o,
  output logic                 odd_o      // its barycentric part is the second of an element
);

  typedef logic [SlotWidth-1:0] slot_t;

  typedef struct packed {
    slot_t             slot;
    ti_mem_pkg::addr_t addr;
  } request_t;

  logic [1:0] valid, ready, lost;
  ti_pkg::record_t bary_record;
  request_t plane, bary;
  request_t requests[2];

  ti_regfile #(
    .Depth (NumSlots),
    .word_t(ti_pkg::record_t)
  ) u_records (
    .clk_i,
    .read_addr_i (go_on_slot_i),
    .read_data_o (bary_record),
    .write_en_i  (take_i),
    .write_addr_i(take_slot_i),
    .write_data_i(record_i)
  );

  assign plane = '{slot: take_slot_i, addr: plane_base_i + (ti_mem_pkg::addr_t'(record_i) << 5)};
  assign bary  = '{slot: go_on_slot_i, addr: bary_base_i + (ti_mem_pkg::addr_t'(bary_record) << 4)};

  ti_queue #(
    .payload_t(request_t),
    .Depth    (NumSlots)
  ) u_plane (
    .clk_i,
    .rst_ni,
    .push_i     (take_i),
    .push_data_i(plane),
    .out_valid_o(valid[0]),
    .out_ready_i(ready[0]),
    .out_data_o (requests[0])
  );

  ti_queue #(
    .payload_t(request_t),
    .Depth    (NumSlots)
  ) u_bary (
    .clk_i,
    .rst_ni,
    .push_i     (go_on_i),
    .push_data_i(bary),
    .out_valid_o(valid[1]),
    .out_ready_i(ready[1]),
    .out_data_o (requests[1])
  );

  ti_arbiter #(
    .payload_t(request_t),
    .NumIn    (2)
  ) u_arbiter (
    .clk_i,
    .rst_ni,
    .in_valid_i (valid),
    .in_ready_o (ready),
    .in_lost_o  (lost),
    .in_data_i  (requests),
    .out_valid_o(req_valid_o),
    .out_ready_i(req_ready_i),
    .out_data_o ({req_slot_o, req_addr_o})
  );

  logic [NumSlots-1:0] pass_b_q, odd_q;
  always_ff @(posedge clk_i) begin
    if (take_i) begin
      pass_b_q[take_slot_i] <= 1'b0;
      odd_q[take_slot_i]    <= record_i[0];
    end
    if (go_on_i) pass_b_q[go_on_slot_i] <= 1'b1;
  end
  assign pass_b_o = pass_b_q[slot_i];
  assign odd_o    = odd_q[slot_i];

  logic unused_lost;
  assign unused_lost = |lost;

  if (NumSlots < 2) begin : gen_check_num_slots
    $error("ti_ist1_requests: NumSlots must be 2 or more");
  end

endmodule : ti_ist1_requests
