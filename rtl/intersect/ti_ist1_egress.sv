// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// How tests leave an IST1: candidates to IST2, misses and errors home.
///
/// Every result is taken at once into a queue with a place for each slot; the slot is given back when its
/// result has gone from there to the register of its output.  One slot a cycle, to outputs that have room: an
/// output goes before the one served last, and of misses and errors the kind that did not go last.  So a candidate
/// waits for at most one token, a token for at most three others.  2 cycles from result to output.  With `Queued` an
/// output is a queue of two, and no grant waits for its reader.
module ti_ist1_egress #(
  parameter int unsigned NumSlots = 8,
  /// Bits of what the test leaves for IST2.
  parameter int unsigned ValuesWidth = 4 * ti_num_pkg::FpWidth,
  parameter bit Queued = ti_config_pkg::LookupStages > 4,
  localparam int unsigned SlotWidth = $clog2(NumSlots),
  localparam int unsigned CandidateWidth = $bits(
      ti_pkg::home_t
  ) + 1 + $bits(
      ti_pkg::prim_t
  ) + ValuesWidth
) (
  input logic clk_i,
  input logic rst_ni,

  // A test takes a slot.
  input logic                          take_i,
  input logic          [SlotWidth-1:0] take_slot_i,
  input ti_pkg::home_t                 take_home_i,

  // A result of the pipeline: for IST2, where it may be a miss all the same; or a miss.
  input logic                            inside_i,
  input logic                            inside_miss_i,
  input logic                            miss_i,
  input logic          [  SlotWidth-1:0] result_slot_i,
  input ti_pkg::prim_t                   prim_i,
  input logic          [ValuesWidth-1:0] values_i,

  // Memory failed a test.
  input logic                 failed_i,
  input logic [SlotWidth-1:0] failed_slot_i,

  output logic                      candidate_valid_o,
  input  logic                      candidate_ready_i,
  output logic [CandidateWidth-1:0] candidate_data_o,   // home, miss, prim, values

  output logic            return_valid_o,
  input  logic            return_ready_i,
  output ti_pkg::return_t return_data_o,

  output logic                 give_o,
  output logic [SlotWidth-1:0] give_slot_o
);

  typedef logic [SlotWidth-1:0] slot_t;

  typedef struct packed {
    slot_t                  slot;
    logic                   miss;
    ti_pkg::prim_t          prim;
    logic [ValuesWidth-1:0] values;
  } inside_t;

  ti_pkg::home_t home_q[NumSlots];
  always_ff @(posedge clk_i) if (take_i) home_q[take_slot_i] <= take_home_i;

  // Waiting results, and which of them gives its slot back in this cycle.
  logic inside_waits, miss_waits, failed_waits, return_waits;
  logic candidate_room, return_room;
  logic inside_goes, miss_goes, failed_goes, return_goes;
  inside_t kept;
  slot_t miss_slot, failed_slot;

  ti_queue #(
    .payload_t(inside_t),
    .Depth    (NumSlots)
  ) u_inside (
    .clk_i,
    .rst_ni,
    .push_i(inside_i),
    .push_data_i('{slot: result_slot_i, miss: inside_miss_i, prim: prim_i, values: values_i}),
    .out_valid_o(inside_waits),
    .out_ready_i(inside_goes),
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
    .out_valid_o(miss_waits),
    .out_ready_i(miss_goes),
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
    .out_valid_o(failed_waits),
    .out_ready_i(failed_goes),
    .out_data_o (failed_slot)
  );

  // Fair between the outputs, and between the kinds that share one.
  logic prefer_return_q, prefer_failed_q;
  logic failed_first;

  assign failed_first = failed_waits && (prefer_failed_q || !miss_waits);
  assign return_waits = miss_waits || failed_waits;
  assign return_goes  = return_waits && return_room &&
      (prefer_return_q || !(inside_waits && candidate_room));
  assign failed_goes = return_goes && failed_first;
  assign miss_goes = return_goes && !failed_first;
  assign inside_goes = inside_waits && candidate_room && !return_goes;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      prefer_return_q <= 1'b0;
      prefer_failed_q <= 1'b0;
    end else begin
      if (give_o) prefer_return_q <= inside_goes;
      if (return_goes) prefer_failed_q <= miss_goes;
    end
  end

  slot_t result_slot;
  assign result_slot = failed_first ? failed_slot : miss_slot;
  assign give_o      = inside_goes || return_goes;
  assign give_slot_o = inside_goes ? kept.slot : result_slot;

  logic [CandidateWidth-1:0] candidate;
  assign candidate = {home_q[kept.slot], kept.miss, kept.prim, kept.values};

  ti_pkg::return_t result;
  always_comb begin
    result       = '0;
    result.home  = home_q[result_slot];
    result.count = 16'd1;
    result.error = failed_first;
  end

  // Filled only while they have room, so nothing waits at their inputs.
  if (Queued) begin : gen_queues
    ti_fifo #(
      .payload_t(logic [CandidateWidth-1:0])
    ) u_candidates (
      .clk_i,
      .rst_ni,
      .in_valid_i (inside_goes),
      .in_ready_o (candidate_room),
      .in_data_i  (candidate),
      .out_valid_o(candidate_valid_o),
      .out_ready_i(candidate_ready_i),
      .out_data_o (candidate_data_o)
    );

    ti_fifo #(
      .payload_t(ti_pkg::return_t)
    ) u_returns (
      .clk_i,
      .rst_ni,
      .in_valid_i (return_goes),
      .in_ready_o (return_room),
      .in_data_i  (result),
      .out_valid_o(return_valid_o),
      .out_ready_i(return_ready_i),
      .out_data_o (return_data_o)
    );
  end else begin : gen_stages
    ti_stage #(
      .payload_t(logic [CandidateWidth-1:0])
    ) u_candidate_stage (
      .clk_i,
      .rst_ni,
      .in_valid_i (inside_goes),
      .in_ready_o (candidate_room),
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
      .in_valid_i (return_goes),
      .in_ready_o (return_room),
      .in_data_i  (result),
      .out_valid_o(return_valid_o),
      .out_ready_i(return_ready_i),
      .out_data_o (return_data_o)
    );
  end

  `TI_ASSERT(OneResultAtATime, !(inside_i && miss_i))
  `TI_ASSERT(GrantOneHot, $onehot0({inside_goes, miss_goes, failed_goes}))
  `TI_ASSERT(CandidateGoesOnlyWhereRoom, inside_goes -> candidate_room)
  `TI_ASSERT(ReturnGoesOnlyWhereRoom, return_goes -> return_room)
  `TI_ASSERT_NEXT(CandidateHeldUntilTaken, candidate_valid_o && !candidate_ready_i,
                  candidate_valid_o && $stable(candidate_data_o))
  `TI_ASSERT_NEXT(ReturnHeldUntilTaken, return_valid_o && !return_ready_i,
                  return_valid_o && $stable(return_data_o))
  `TI_ASSERT_KNOWN(CandidateValidKnown, candidate_valid_o)
  `TI_ASSERT_KNOWN(ReturnValidKnown, return_valid_o)

endmodule : ti_ist1_egress
