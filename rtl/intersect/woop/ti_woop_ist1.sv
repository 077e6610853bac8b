// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// IST1 of Woop's triangle test, behind the ports of `ti_ist1`: one fetch, one pass.
///
/// A test lives in a slot.  It asks for the triangle's corners and takes `ti_woop_pipe`; one that is kept goes to IST2,
/// a miss home.  One test a cycle when fed; a pass takes `PassLatency` cycles from the RA's answer.  Nothing inside
/// ever stalls: each queue has a place for every slot, and a slot is given back only when its result has left. Without
/// `EarlyExit` each test goes on to IST2, as a miss when it has failed.
module ti_woop_ist1 #(
  parameter int unsigned NumSlots = 8,
  parameter int unsigned Rows = 2,
  parameter int unsigned CacheBytes = 1024,
  parameter int unsigned Ways = 2,
  /// Tests inside with which the unit is crowded; above NumSlots it never is.
  parameter int unsigned Spill = 8,
  /// A test ends with the pass that it fails.
  parameter bit EarlyExit = 1'b1,
  // Slot memories, registered once more where lines are.
  localparam int unsigned OperandLatency = (ti_config_pkg::LookupStages >= 4) ? 2 : 1,
  localparam int unsigned PipeLatency = 3 * ti_fp_pkg::AddLatency + 2 * ti_fp_pkg::MulLatency + 1,
  localparam int unsigned PassLatency = OperandLatency + PipeLatency
) (
  input  logic              clk_i,
  input  logic              rst_ni,
  input  logic              flush_i,       // forget all lines; only while idle
  output logic              idle_o,        // no test inside, nothing on its way
  input  ti_mem_pkg::addr_t corner_base_i, // a multiple of CornerBytes

  input  logic                    test_valid_i,
  output logic                    test_ready_o,
  output logic                    crowded_o,     // `Spill` tests or more inside
  input  ti_intersect_pkg::test_t test_data_i,

  output logic                              candidate_valid_o,
  input  logic                              candidate_ready_i,
  output ti_intersect_pkg::woop_candidate_t candidate_data_o,

  output logic            return_valid_o,  // misses and errors
  input  logic            return_ready_i,
  output ti_pkg::return_t return_data_o,

  output logic                  line_req_valid_o,
  input  logic                  line_req_ready_i,
  output ti_mem_pkg::line_req_t line_req_data_o,

  input  logic                  line_rsp_valid_i,
  output logic                  line_rsp_ready_o,
  input  ti_mem_pkg::line_rsp_t line_rsp_data_i,

  output ti_count_pkg::ist1_events_t events_o  // `room` where an output waits; each pass is an (a)
);

  localparam int unsigned SlotWidth = $clog2(NumSlots);
  localparam int unsigned ElemBytes = ti_intersect_pkg::CornerBytes;
  localparam int unsigned ElemShift = $clog2(ElemBytes);
  typedef logic [SlotWidth-1:0] slot_t;

  typedef struct packed {
    slot_t         slot;
    ti_pkg::prim_t prim;
  } tag_t;

  // Slots.
  logic slot_free, take, give;
  slot_t new_slot, give_slot;

  assign test_ready_o = slot_free;
  assign take         = test_valid_i && test_ready_o;

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

  // Requests.
  logic req_valid, req_ready;
  slot_t req_slot;
  ti_queue #(
    .payload_t(slot_t),
    .Depth    (NumSlots)
  ) u_req (
    .clk_i,
    .rst_ni,
    .push_i     (take),
    .push_data_i(new_slot),
    .out_valid_o(req_valid),
    .out_ready_i(req_ready),
    .out_data_o (req_slot)
  );

  ti_pkg::record_t req_record;
  ti_regfile #(
    .Depth (NumSlots),
    .word_t(ti_pkg::record_t)
  ) u_records (
    .clk_i,
    .read_addr_i (req_slot),
    .read_data_o (req_record),
    .write_en_i  (take),
    .write_addr_i(new_slot),
    .write_data_i(test_data_i.record)
  );

  logic rsp_valid, rsp_error, ra_idle, ra_waits;
  ti_count_pkg::cache_events_t cache_events;
  slot_t rsp_slot;
  logic [8*ElemBytes-1:0] rsp_elem;

  ti_ra #(
    .NumSlots  (NumSlots),
    .Rows      (Rows),
    .ElemBytes (ElemBytes),
    .CacheBytes(CacheBytes),
    .Ways      (Ways),
    .Mode      (ti_config_pkg::RayAccumulation)
  ) u_ra (
    .clk_i,
    .rst_ni,
    .flush_i,
    .idle_o     (ra_idle),
    .waits_o    (ra_waits),
    .req_valid_i(req_valid),
    .req_ready_o(req_ready),
    .req_slot_i (req_slot),
    .req_addr_i (corner_base_i + (ti_mem_pkg::addr_t'(req_record) << ElemShift)),
    .rsp_valid_o(rsp_valid),
    .rsp_ready_i(1'b1),
    .rsp_slot_o (rsp_slot),
    .rsp_elem_o (rsp_elem),
    .rsp_error_o(rsp_error),
    .line_req_valid_o,
    .line_req_ready_i,
    .line_req_data_o,
    .line_rsp_valid_i,
    .line_rsp_ready_o,
    .line_rsp_data_i,
    .events_o   (cache_events)
  );

  // Operands.
  logic [OperandLatency-1:0] good_q, bad_q;
  slot_t fetched_slot_q, issue_slot;
  ti_intersect_pkg::corners_t fetched_corners_q, issue_corners;
  ti_pkg::ray_operands_t operands_read, operands;
  logic issues, fails;
  assign issues = good_q[OperandLatency-1];
  assign fails  = bad_q[OperandLatency-1];

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      good_q <= '0;
      bad_q  <= '0;
    end else begin
      good_q <= OperandLatency'({good_q, rsp_valid && !rsp_error});
      bad_q  <= OperandLatency'({bad_q, rsp_valid && rsp_error});
    end
  end
  always_ff @(posedge clk_i) begin
    if (rsp_valid) begin
      fetched_slot_q    <= rsp_slot;
      fetched_corners_q <= rsp_elem[$bits(fetched_corners_q)-1:0];
    end
  end

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(ti_pkg::ray_operands_t)
  ) u_operands (
    .clk_i,
    .read_en_i   (rsp_valid),
    .read_addr_i (rsp_slot),
    .read_data_o (operands_read),
    .write_en_i  (take),
    .write_addr_i(new_slot),
    .write_data_i(test_data_i.operands)
  );

  ti_delay #(
    .payload_t(logic [$bits(slot_t)+$bits(issue_corners)+$bits(operands)-1:0]),
    .Cycles   (OperandLatency - 1)
  ) u_issue (
    .clk_i,
    .rst_ni,
    .data_i({fetched_slot_q, fetched_corners_q, operands_read}),
    .data_o({issue_slot, issue_corners, operands})
  );

  // The pass.
  logic result_valid, result_keep;
  tag_t result_tag;
  ti_intersect_pkg::edges_t result_edges;

  ti_woop_pipe #(
    .TagWidth($bits(tag_t))
  ) u_pipe (
    .clk_i,
    .rst_ni,
    .valid_i  (issues),
    .tag_i    ({issue_slot, issue_corners.prim}),
    .z_i      (ti_pkg::axis_of(operands.d)),
    .o_i      (operands.o),
    .shear_i  (ti_pkg::with_axis(operands.d, '0)),
    .corners_i(issue_corners.p),
    .valid_o  (result_valid),
    .keep_o   (result_keep),
    .tag_o    (result_tag),
    .edges_o  (result_edges)
  );

  // What leaves: tests that are kept to IST2, misses and errors home.
  ti_ist1_egress #(
    .NumSlots   (NumSlots),
    .ValuesWidth($bits(ti_intersect_pkg::edges_t))
  ) u_egress (
    .clk_i,
    .rst_ni,
    .take_i       (take),
    .take_slot_i  (new_slot),
    .take_home_i  (test_data_i.home),
    .inside_i     (result_valid && (result_keep || !EarlyExit)),
    .inside_miss_i(!result_keep),
    .miss_i       (result_valid && !result_keep && EarlyExit),
    .result_slot_i(result_tag.slot),
    .prim_i       (result_tag.prim),
    .values_i     (result_edges),
    .failed_i     (fails),
    .failed_slot_i(issue_slot),
    .candidate_valid_o,
    .candidate_ready_i,
    .candidate_data_o,
    .return_valid_o,
    .return_ready_i,
    .return_data_o,
    .give_o       (give),
    .give_slot_o  (give_slot)
  );

  // What happens, for counting.
  logic [SlotWidth:0] inside_q;  // tests
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) inside_q <= '0;
    else if (take != give) inside_q <= take ? inside_q + 1'b1 : inside_q - 1'b1;
  end
  assign crowded_o = 32'(inside_q) >= Spill;
  assign idle_o = inside_q == '0 && ra_idle && !candidate_valid_o && !return_valid_o;

  always_comb begin
    events_o.activity = '0;
    if (issues) events_o.activity.works = 1'b1;
    else if (ra_waits) events_o.activity.memory = 1'b1;
    else if ((candidate_valid_o && !candidate_ready_i) || (return_valid_o && !return_ready_i))
      events_o.activity.room = 1'b1;
    else if (!idle_o) events_o.activity.latency = 1'b1;
    else events_o.activity.empty = 1'b1;

    events_o.a_passes = issues;
    events_o.b_passes = 1'b0;
    events_o.cache    = cache_events;
  end

  logic unused;
  assign unused = ^{test_data_i.tnear, test_data_i.tfar, rsp_elem[8*ElemBytes-1:$bits(
      issue_corners
  )]};

  // Else a record would lie across the elements that are fetched.
  `TI_ASSERT(RecordsAreAligned, corner_base_i[ElemShift-1:0] == '0)

  if (ti_mem_pkg::LineBytes < ElemBytes) begin : gen_check_line_bytes
    $error("ti_woop_ist1: LineBytes must hold a record");
  end

  `TI_ASSERT_KNOWN(TestReadyKnown, test_ready_o)
  `TI_ASSERT_KNOWN(CandidateValidKnown, candidate_valid_o)
  `TI_ASSERT_KNOWN(ReturnValidKnown, return_valid_o)
  `TI_ASSERT_KNOWN(LineReqValidKnown, line_req_valid_o)
  `TI_ASSERT_KNOWN(LineRspReadyKnown, line_rsp_ready_o)

endmodule : ti_woop_ist1
