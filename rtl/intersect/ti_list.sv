// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// LIST: reads the triangle numbers of a leaf and sends one test for each.
///
/// A leaf lives in a slot; the slots take turns, one list entry a cycle in all.  From a leaf taken to its
/// first test 4 cycles with the line in the L1.  All tests of a leaf go out as fast as they are
/// read; they need not wait for one another.  When memory answers with an error, one return token accounts
/// for all tests that the leaf still had to send.  The caller guarantees `leaf.count` >= 1.
module ti_list #(
  parameter int unsigned NumSlots = 4,
  parameter int unsigned Rows = 2,
  parameter int unsigned CacheBytes = 512,
  parameter int unsigned Ways = 2,
  localparam int unsigned RowWidth = (Rows > 1) ? $clog2(Rows) : 1
) (
  input logic clk_i,
  input logic rst_ni,
  input ti_pkg::addr_t list_base_i,

  input  logic          leaf_valid_i,
  output logic          leaf_ready_o,
  input  ti_pkg::leaf_t leaf_data_i,

  output logic          test_valid_o,
  input  logic          test_ready_i,
  output ti_pkg::test_t test_data_o,

  output logic            return_valid_o,
  input  logic            return_ready_i,
  output ti_pkg::return_t return_data_o,

  output logic                              line_req_valid_o,
  input  logic                              line_req_ready_i,
  output logic               [RowWidth-1:0] line_req_row_o,
  output ti_pkg::line_addr_t                line_req_line_o,

  input logic                         line_rsp_valid_i,
  input logic          [RowWidth-1:0] line_rsp_row_i,
  input ti_pkg::line_t                line_rsp_data_i,
  input logic                         line_rsp_error_i,

  output ti_pkg::list_counters_t counters_o
);

  localparam int unsigned SlotWidth = $clog2(NumSlots);
  typedef logic [SlotWidth-1:0] slot_t;

  // Slots: what the tests of the leaf share, and how far it has been read.
  typedef struct packed {
    ti_pkg::home_t home;
    ti_pkg::vec3_t o;
    ti_pkg::vec3_t d;
    ti_pkg::fp_t   tbest;
  } shared_t;

  logic slot_free, take, again, done, step;
  slot_t new_slot, rsp_slot, answer_slot_q;
  logic [31:0] position_q[NumSlots];
  ti_pkg::tri_count_t remaining_q[NumSlots];
  ti_pkg::tri_count_t remaining;

  assign leaf_ready_o = slot_free && !again;
  assign take         = leaf_valid_i && leaf_ready_o;

  ti_slot_pool #(
    .NumSlots(NumSlots)
  ) u_pool (
    .clk_i,
    .rst_ni,
    .free_valid_o(slot_free),
    .free_slot_o (new_slot),
    .take_i      (take),
    .give_i      (done),
    .give_slot_i (answer_slot_q)
  );

  // Whoever has ids left stands in this queue once; a leaf that goes on comes before a new one.
  logic want_valid, want_ready;
  slot_t want_slot;

  ti_queue #(
    .payload_t(slot_t),
    .Depth    (NumSlots)
  ) u_want (
    .clk_i,
    .rst_ni,
    .push_i     (take || again),
    .push_data_i(again ? answer_slot_q : new_slot),
    .out_valid_o(want_valid),
    .out_ready_i(want_ready),
    .out_data_o (want_slot)
  );

  logic rsp_valid, rsp_ready, rsp_error;
  logic [31:0] rsp_id;
  logic event_access, event_hit, event_merged, event_miss;

  ti_ra #(
    .NumSlots  (NumSlots),
    .Rows      (Rows),
    .AddrWidth (ti_pkg::AddrWidth),
    .LineBytes (ti_pkg::LineBytes),
    .ElemBytes (4),
    .CacheBytes(CacheBytes),
    .Ways      (Ways)
  ) u_ra (
    .clk_i,
    .rst_ni,
    .req_valid_i   (want_valid),
    .req_ready_o   (want_ready),
    .req_slot_i    (want_slot),
    .req_addr_i    (list_base_i + (ti_pkg::addr_t'(position_q[want_slot]) << 2)),
    .rsp_valid_o   (rsp_valid),
    .rsp_ready_i   (rsp_ready),
    .rsp_slot_o    (rsp_slot),
    .rsp_elem_o    (rsp_id),
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

  // The answer beside the slot's shared operands.
  logic answer_valid_q, answer_error_q, answer_taken;
  logic [31:0] answer_id_q;
  shared_t shared;

  assign rsp_ready = !answer_valid_q || answer_taken;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) answer_valid_q <= 1'b0;
    else if (rsp_ready) answer_valid_q <= rsp_valid;
  end

  always_ff @(posedge clk_i) begin
    if (rsp_valid && rsp_ready) begin
      answer_slot_q  <= rsp_slot;
      answer_id_q    <= rsp_id;
      answer_error_q <= rsp_error;
    end
  end

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(shared_t)
  ) u_shared (
    .clk_i,
    .read_en_i(rsp_valid && rsp_ready),
    .read_addr_i(rsp_slot),
    .read_data_o(shared),
    .write_en_i(take),
    .write_addr_i(new_slot),
    .write_data_i(
    '{home: leaf_data_i.home, o: leaf_data_i.o, d: leaf_data_i.d, tbest: leaf_data_i.tbest}
    )
  );

  assign remaining = remaining_q[answer_slot_q];

  assign test_valid_o = answer_valid_q && !answer_error_q;
  assign test_data_o = '{
          home: shared.home,
          record: answer_id_q[28:0],
          o: shared.o,
          d: shared.d,
          tbest: shared.tbest
      };

  assign return_valid_o = answer_valid_q && answer_error_q;
  always_comb begin
    return_data_o       = '0;
    return_data_o.home  = shared.home;
    return_data_o.count = remaining;
    return_data_o.error = 1'b1;
  end

  assign step         = test_valid_o && test_ready_i;
  assign answer_taken = step || (return_valid_o && return_ready_i);
  assign again        = step && remaining != 16'd1;
  assign done         = answer_taken && !again;

  always_ff @(posedge clk_i) begin
    if (take) begin
      position_q[new_slot]  <= leaf_data_i.first;
      remaining_q[new_slot] <= leaf_data_i.count;
    end
    if (again) begin
      position_q[answer_slot_q]  <= position_q[answer_slot_q] + 1'b1;
      remaining_q[answer_slot_q] <= remaining - 1'b1;
    end
  end

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
    if (!rst_ni) counters_o.ids <= '0;
    else if (step) counters_o.ids <= counters_o.ids + 1'b1;
  end

  `TI_ASSERT(LeafHasTriangles, leaf_valid_i |-> leaf_data_i.count != '0)
  `TI_ASSERT(TestHeldUntilTaken, test_valid_o && !test_ready_i |=> test_valid_o && $stable
                                 (test_data_o))
  `TI_ASSERT(ReturnHeldUntilTaken, return_valid_o && !return_ready_i |=> return_valid_o && $stable
                                   (return_data_o))

endmodule : ti_list
