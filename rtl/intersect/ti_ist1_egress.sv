// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// How tests leave an IST1: candidates to IST2, misses and errors home.
///
/// Every result is taken at once into a queue with a place for each slot; the slot is given back when its
/// result has left the queue.  One slot a cycle: candidates first, then misses, then errors.  2 cycles from
/// result to output.
module ti_ist1_egress #(
  parameter  int unsigned NumSlots  = 8,
  localparam int unsigned SlotWidth = $clog2(NumSlots)
) (
  input logic clk_i,
  input logic rst_ni,

  // A test takes a slot.
  input logic                          take_i,
  input logic          [SlotWidth-1:0] take_slot_i,
  input ti_pkg::home_t                 take_home_i,

  // A result of the pipeline.
  input logic                          inside_i,
  input logic                          miss_i,
  input logic          [SlotWidth-1:0] result_slot_i,
  input ti_pkg::prim_t                 prim_i,
  input ti_pkg::fp_t                   det_i,
  input ti_pkg::fp_t                   dett_i,
  input ti_pkg::fp_t                   detu_i,
  input ti_pkg::fp_t                   detv_i,

  // Memory failed a test.
  input logic                 failed_i,
  input logic [SlotWidth-1:0] failed_slot_i,

  output logic               candidate_valid_o,
  input  logic               candidate_ready_i,
  output ti_intersect_pkg::candidate_t candidate_data_o,

  output logic            return_valid_o,
  input  logic            return_ready_i,
  output ti_pkg::return_t return_data_o,

  output logic                 give_o,
  output logic [SlotWidth-1:0] give_slot_o
);

  typedef logic [SlotWidth-1:0] slot_t;

  typedef struct packed {
    slot_t         slot;
    ti_pkg::prim_t prim;
    ti_pkg::fp_t   det;
    ti_pkg::fp_t   dett;
    ti_pkg::fp_t   detu;
    ti_pkg::fp_t   detv;
  } inside_t;

  ti_pkg::home_t home_q[NumSlots];
  always_ff @(posedge clk_i) if (take_i) home_q[take_slot_i] <= take_home_i;

  logic
      kept_valid,
      kept_ready,
      kept_leaves,
      miss_valid,
      failed_valid,
      over_valid,
      over_ready,
      over_leaves;
  inside_t kept;
  slot_t miss_slot, failed_slot, over_slot;

  ti_queue #(
    .payload_t(inside_t),
    .Depth    (NumSlots)
  ) u_inside (
    .clk_i,
    .rst_ni,
    .push_i(inside_i),
    .push_data_i(
    '{slot: result_slot_i, prim: prim_i, det: det_i, dett: dett_i, detu: detu_i, detv: detv_i}
    ),
    .out_valid_o(kept_valid),
    .out_ready_i(kept_ready),
    .out_data_o(kept)
  );

  ti_queue #(
    .payload_t(slot_t),
    .Depth    (NumSlots)
  ) u_misses (
    .clk_i,
    .rst_ni,
    .push_i     (miss_i),
    .push_data_i(result_slot_i),
    .out_valid_o(miss_valid),
    .out_ready_i(over_leaves && miss_valid),
    .out_data_o (miss_slot)
  );

  ti_queue #(
    .payload_t(slot_t),
    .Depth    (NumSlots)
  ) u_failed (
    .clk_i,
    .rst_ni,
    .push_i     (failed_i),
    .push_data_i(failed_slot_i),
    .out_valid_o(failed_valid),
    .out_ready_i(over_leaves && !miss_valid),
    .out_data_o (failed_slot)
  );

  assign kept_leaves = kept_valid && kept_ready;
  assign over_valid  = (miss_valid || failed_valid) && !kept_leaves;
  assign over_leaves = over_valid && over_ready;
  assign over_slot   = miss_valid ? miss_slot : failed_slot;
  assign give_o      = kept_leaves || over_leaves;
  assign give_slot_o = kept_leaves ? kept.slot : over_slot;

  ti_intersect_pkg::candidate_t candidate;
  assign candidate = '{
          home: home_q[kept.slot],
          prim: kept.prim,
          det: kept.det,
          dett: kept.dett,
          detu: kept.detu,
          detv: kept.detv
      };

  ti_pkg::return_t over;
  always_comb begin
    over       = '0;
    over.home  = home_q[over_slot];
    over.count = 16'd1;
    over.error = !miss_valid;
  end

  ti_stage #(
    .payload_t(ti_intersect_pkg::candidate_t)
  ) u_candidate_stage (
    .clk_i,
    .rst_ni,
    .in_valid_i (kept_valid),
    .in_ready_o (kept_ready),
    .in_data_i  (candidate),
    .out_valid_o(candidate_valid_o),
    .out_ready_i(candidate_ready_i),
    .out_data_o (candidate_data_o)
  );

  ti_stage #(
    .payload_t(ti_pkg::return_t)
  ) u_return_stage (
    .clk_i,
    .rst_ni,
    .in_valid_i (over_valid),
    .in_ready_o (over_ready),
    .in_data_i  (over),
    .out_valid_o(return_valid_o),
    .out_ready_i(return_ready_i),
    .out_data_o (return_data_o)
  );

  `TI_ASSERT(OneResultAtATime, !(inside_i && miss_i))

endmodule : ti_ist1_egress
