// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// IST1: passes (a) and (b) of the ray-triangle test, each behind its own fetch.
///
/// A test lives in a slot.  It asks for the triangle's plane part, takes pass (a), and if it is kept asks
/// for the barycentric part and takes pass (b).  A miss after (a) fetches nothing more.  One pass a
/// cycle when fed; a pass takes `PassLatency` cycles from the RA's answer.  Nothing inside ever stalls: each
/// queue has a place for every slot, and a slot is given back only when its result has left.
module ti_ist1 #(
  parameter int unsigned NumSlots = 8,
  parameter int unsigned Rows = 2,
  parameter int unsigned CacheBytes = 1024,
  parameter int unsigned Ways = 2,
  localparam int unsigned RowWidth = (Rows > 1) ? $clog2(Rows) : 1,
  localparam int unsigned OperandLatency = 1,  // slot memories
  localparam int unsigned PipeLatency = 4 * ti_fp_pkg::AddLatency + 3 * ti_fp_pkg::MulLatency + 1,
  localparam int unsigned PassLatency = OperandLatency + PipeLatency
) (
  input logic clk_i,
  input logic rst_ni,
  input ti_pkg::addr_t plane_base_i,
  input ti_pkg::addr_t bary_base_i,

  input  logic          test_valid_i,
  output logic          test_ready_o,
  input  ti_pkg::test_t test_data_i,

  output logic               candidate_valid_o,
  input  logic               candidate_ready_i,
  output ti_pkg::candidate_t candidate_data_o,

  output logic            return_valid_o,  // misses and errors
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

  output ti_pkg::ist1_counters_t counters_o
);

  localparam int unsigned SlotWidth = $clog2(NumSlots);
  localparam int unsigned ElemBytes = 32;
  typedef logic [SlotWidth-1:0] slot_t;

  typedef struct packed {
    ti_pkg::vec3_t o;
    ti_pkg::vec3_t d;
    ti_pkg::fp_t   tbest;
  } operands_t;

  /// What pass (a) leaves for pass (b).
  typedef struct packed {
    ti_pkg::prim_t prim;
    logic [1:0]    axis;
    ti_pkg::fp_t   det;
    ti_pkg::fp_t   dett;
    ti_pkg::fp_t   audet;
    ti_pkg::fp_t   av;
  } between_t;

  typedef struct packed {
    slot_t         slot;
    logic [1:0]    axis;
    ti_pkg::prim_t prim;
  } tag_t;

  typedef struct packed {
    slot_t         slot;
    ti_pkg::addr_t addr;
  } want_t;

  // Slots.
  logic slot_free, take, give;
  slot_t new_slot, give_slot;
  ti_pkg::record_t record_q[NumSlots];

  assign test_ready_o = slot_free;
  assign take         = test_valid_i && test_ready_o;

  always_ff @(posedge clk_i) begin
    if (take) begin
      record_q[new_slot] <= test_data_i.record;
    end
  end

  ti_slot_pool #(
    .NumSlots(NumSlots)
  ) u_pool (
    .clk_i,
    .rst_ni,
    .free_valid_o(slot_free),
    .free_slot_o (new_slot),
    .take_i      (take),
    .give_i      (give),
    .give_slot_i (give_slot)
  );

  // What comes out of the pipeline of the two passes.
  logic result_valid, result_b, result_keep;
  tag_t result_tag;
  ti_pkg::fp_t result_det, result_dett, result_x, result_y;

  // Requests: new tests and tests that have passed (a) take turns.
  logic req_valid, req_ready, go_on;
  logic [1:0] want_valid, want_ready;
  slot_t want_a_slot, want_b_slot;
  want_t [1:0] want;
  want_t req;

  ti_queue #(
    .payload_t(slot_t),
    .Depth    (NumSlots)
  ) u_want_a (
    .clk_i,
    .rst_ni,
    .push_i     (take),
    .push_data_i(new_slot),
    .out_valid_o(want_valid[0]),
    .out_ready_i(want_ready[0]),
    .out_data_o (want_a_slot)
  );

  ti_queue #(
    .payload_t(slot_t),
    .Depth    (NumSlots)
  ) u_want_b (
    .clk_i,
    .rst_ni,
    .push_i     (go_on),
    .push_data_i(result_tag.slot),
    .out_valid_o(want_valid[1]),
    .out_ready_i(want_ready[1]),
    .out_data_o (want_b_slot)
  );

  assign want[0] = '{
          slot: want_a_slot,
          addr: plane_base_i + (ti_pkg::addr_t'(record_q[want_a_slot]) << 5)
      };
  assign want[1] = '{
          slot: want_b_slot,
          addr: bary_base_i + (ti_pkg::addr_t'(record_q[want_b_slot]) << 4)
      };

  ti_arbiter #(
    .payload_t(want_t),
    .NumIn    (2)
  ) u_turn (
    .clk_i,
    .rst_ni,
    .in_valid_i (want_valid),
    .in_ready_o (want_ready),
    .in_data_i  (want),
    .out_valid_o(req_valid),
    .out_ready_i(req_ready),
    .out_data_o (req)
  );

  logic [NumSlots-1:0] pass_b_q;  // which part the slot has asked for
  always_ff @(posedge clk_i) begin
    if (take) pass_b_q[new_slot] <= 1'b0;
    if (go_on) pass_b_q[result_tag.slot] <= 1'b1;
  end

  logic rsp_valid, rsp_error, event_access, event_hit, event_merged, event_miss;
  slot_t rsp_slot;
  logic [8*ElemBytes-1:0] rsp_elem;

  ti_ra #(
    .NumSlots  (NumSlots),
    .Rows      (Rows),
    .AddrWidth (ti_pkg::AddrWidth),
    .LineBytes (ti_pkg::LineBytes),
    .ElemBytes (ElemBytes),
    .CacheBytes(CacheBytes),
    .Ways      (Ways)
  ) u_ra (
    .clk_i,
    .rst_ni,
    .req_valid_i   (req_valid),
    .req_ready_o   (req_ready),
    .req_slot_i    (req.slot),
    .req_addr_i    (req.addr),
    .rsp_valid_o   (rsp_valid),
    .rsp_ready_i   (1'b1),
    .rsp_slot_o    (rsp_slot),
    .rsp_elem_o    (rsp_elem),
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

  // Operands.
  logic issue_q, issue_error_q, issue_b;
  slot_t issue_slot_q;
  logic [8*ElemBytes-1:0] issue_elem_q;
  operands_t operands;
  between_t between, between_new;
  ti_pkg::plane_t plane;
  ti_pkg::bary_t  bary;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      issue_q       <= 1'b0;
      issue_error_q <= 1'b0;
    end else begin
      issue_q       <= rsp_valid && !rsp_error;
      issue_error_q <= rsp_valid && rsp_error;
    end
  end
  always_ff @(posedge clk_i) begin
    if (rsp_valid) begin
      issue_slot_q <= rsp_slot;
      issue_elem_q <= rsp_elem;
    end
  end

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(operands_t)
  ) u_operands (
    .clk_i,
    .read_en_i   (rsp_valid),
    .read_addr_i (rsp_slot),
    .read_data_o (operands),
    .write_en_i  (take),
    .write_addr_i(new_slot),
    .write_data_i('{o: test_data_i.o, d: test_data_i.d, tbest: test_data_i.tbest})
  );

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(between_t)
  ) u_between (
    .clk_i,
    .read_en_i   (rsp_valid),
    .read_addr_i (rsp_slot),
    .read_data_o (between),
    .write_en_i  (go_on),
    .write_addr_i(result_tag.slot),
    .write_data_i(between_new)
  );

  assign issue_b = pass_b_q[issue_slot_q];
  assign plane   = issue_elem_q;
  assign bary    = record_q[issue_slot_q][0] ? issue_elem_q[255:128] : issue_elem_q[127:0];

  // The two passes.
  tag_t issue_tag;

  assign issue_tag = '{
          slot: issue_slot_q,
          axis: issue_b ? between.axis : plane.axis[1:0],
          prim: issue_b ? between.prim : plane.prim
      };

  ti_ist1_pipe #(
    .TagWidth($bits(tag_t))
  ) u_pipe (
    .clk_i,
    .rst_ni,
    .valid_i (issue_q),
    .pass_b_i(issue_b),
    .tag_i   (issue_tag),
    .axis_i  (issue_tag.axis),
    .o_i     (operands.o),
    .d_i     (operands.d),
    .tbest_i (operands.tbest),
    .plane_i (plane),
    .bary_i  (bary),
    .det_i   (between.det),
    .dett_i  (between.dett),
    .audet_i (between.audet),
    .av_i    (between.av),
    .valid_o (result_valid),
    .pass_b_o(result_b),
    .keep_o  (result_keep),
    .tag_o   (result_tag),
    .det_o   (result_det),
    .dett_o  (result_dett),
    .x_o     (result_x),
    .y_o     (result_y)
  );

  assign go_on = result_valid && result_keep && !result_b;
  assign between_new = '{
          prim: result_tag.prim,
          axis: result_tag.axis,
          det: result_det,
          dett: result_dett,
          audet: result_x,
          av: result_y
      };

  // What leaves: tests inside the triangle to IST2, misses and errors home.
  ti_ist1_leave #(
    .NumSlots(NumSlots)
  ) u_leave (
    .clk_i,
    .rst_ni,
    .take_i       (take),
    .take_slot_i  (new_slot),
    .take_home_i  (test_data_i.home),
    .inside_i     (result_valid && result_keep && result_b),
    .miss_i       (result_valid && !result_keep),
    .result_slot_i(result_tag.slot),
    .prim_i       (result_tag.prim),
    .det_i        (result_det),
    .dett_i       (result_dett),
    .detu_i       (result_x),
    .detv_i       (result_y),
    .failed_i     (issue_error_q),
    .failed_slot_i(issue_slot_q),
    .candidate_valid_o,
    .candidate_ready_i,
    .candidate_data_o,
    .return_valid_o,
    .return_ready_i,
    .return_data_o,
    .give_o       (give),
    .give_slot_o  (give_slot)
  );

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
      counters_o.a_passes <= '0;
      counters_o.b_passes <= '0;
    end else if (issue_q) begin
      if (issue_b) counters_o.b_passes <= counters_o.b_passes + 1'b1;
      else counters_o.a_passes <= counters_o.a_passes + 1'b1;
    end
  end

  if (ti_pkg::LineBytes < ElemBytes) begin : gen_check_line_bytes
    $error("ti_ist1: LineBytes must hold a plane part, 32 bytes");
  end

endmodule : ti_ist1
