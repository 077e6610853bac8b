// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// IST1: passes (a) and (b) of the ray-triangle test, each behind its own fetch.
///
/// A test lives in a slot.  It asks for the triangle's plane part, takes pass (a), and if it is kept asks
/// for the barycentric part and takes pass (b).  A miss after (a) fetches nothing more.  One pass a
/// cycle when fed; a pass takes `PassLatency` cycles from the RA's answer.  Nothing inside ever stalls: each
/// queue has a place for every slot, and a slot is given back only when its result has left.
/// Without `EarlyExit` each test takes both passes and goes on to IST2, as a miss when it has failed one.
module ti_ist1 #(
  parameter int unsigned NumSlots = 8,
  parameter int unsigned Rows = 2,
  parameter int unsigned CacheBytes = 1024,
  parameter int unsigned Ways = 2,
  /// Tests inside with which the unit is crowded; above NumSlots it never is.
  parameter int unsigned Spill = 8,
  /// A test ends with the pass that it fails.
  parameter bit EarlyExit = 1'b1,
  localparam int unsigned OperandLatency = 1,  // slot memories
  localparam bit Np = ti_config_pkg::TriangleTest == ti_config_pkg::TriangleTestNp,
  localparam int unsigned PipeLatency = ti_fp_pkg::ChoiceLatency +
      (Np ? 5 : 4) * ti_fp_pkg::AddLatency + 3 * ti_fp_pkg::MulLatency +
      ti_fp_pkg::CmpLatency + 1,
  localparam int unsigned PassLatency = OperandLatency + PipeLatency
) (
  input  logic              clk_i,
  input  logic              rst_ni,
  input  logic              flush_i,       // forget all lines; only while idle
  output logic              idle_o,        // no test inside, nothing on its way
  input  ti_mem_pkg::addr_t plane_base_i,  // a multiple of 32
  input  ti_mem_pkg::addr_t bary_base_i,   // a multiple of 32

  input  logic                    test_valid_i,
  output logic                    test_ready_o,
  output logic                    crowded_o,     // `Spill` tests or more inside
  input  ti_intersect_pkg::test_t test_data_i,

  output logic                         candidate_valid_o,
  input  logic                         candidate_ready_i,
  output ti_intersect_pkg::candidate_t candidate_data_o,

  output logic            return_valid_o,  // misses and errors
  input  logic            return_ready_i,
  output ti_pkg::return_t return_data_o,

  output logic                  line_req_valid_o,
  input  logic                  line_req_ready_i,
  output ti_mem_pkg::line_req_t line_req_data_o,

  input  logic                  line_rsp_valid_i,
  output logic                  line_rsp_ready_o,
  input  ti_mem_pkg::line_rsp_t line_rsp_data_i,

  output ti_count_pkg::ist1_events_t events_o  // `room` where an output waits
);

  localparam int unsigned SlotWidth = $clog2(NumSlots);
  localparam int unsigned ElemBytes = 32;
  typedef logic [SlotWidth-1:0] slot_t;

  typedef struct packed {
    ti_pkg::ray_operands_t ray;
    ti_pkg::fp_t           tnear;
    ti_pkg::fp_t           tfar;
  } operands_t;

  /// What pass (a) leaves for pass (b).
  typedef struct packed {
    ti_pkg::prim_t prim;
    logic [1:0]    axis;
    logic          miss;
    ti_pkg::fp_t   det;
    ti_pkg::fp_t   dett;
    ti_pkg::fp_t   audet;
    ti_pkg::fp_t   av;
  } between_t;

  typedef struct packed {
    slot_t         slot;
    logic          miss;  // (a) has failed it
    logic [1:0]    axis;
    ti_pkg::prim_t prim;
  } tag_t;

  /// What the RA has answered.
  typedef struct packed {
    slot_t                  slot;
    logic                   pass_b;
    logic                   odd;
    logic [8*ElemBytes-1:0] elem;
  } issue_t;

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

  // What comes out of the pipeline of the two passes.
  logic result_valid, result_b, result_keep;
  tag_t result_tag;
  ti_pkg::fp_t result_det, result_dett, result_x, result_y;

  // Requests.
  logic req_valid, req_ready, go_on, rsp_pass_b, rsp_odd;
  slot_t req_slot, rsp_slot;
  ti_mem_pkg::addr_t req_addr;

  ti_ist1_requests #(
    .NumSlots(NumSlots)
  ) u_requests (
    .clk_i,
    .rst_ni,
    .plane_base_i,
    .bary_base_i,
    .take_i      (take),
    .take_slot_i (new_slot),
    .record_i    (test_data_i.record),
    .go_on_i     (go_on),
    .go_on_slot_i(result_tag.slot),
    .req_valid_o (req_valid),
    .req_ready_i (req_ready),
    .req_slot_o  (req_slot),
    .req_addr_o  (req_addr),
    .slot_i      (rsp_slot),
    .pass_b_o    (rsp_pass_b),
    .odd_o       (rsp_odd)
  );

  logic rsp_valid, rsp_error, ra_idle, ra_waits;
  ti_count_pkg::cache_events_t cache_events;
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
    .req_addr_i (req_addr),
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
  logic issues, fails;
  issue_t issue;
  operands_t operands;
  between_t between, between_new;
  ti_intersect_pkg::plane_t plane;
  ti_intersect_pkg::bary_t  bary;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      issues <= 1'b0;
      fails  <= 1'b0;
    end else begin
      issues <= rsp_valid && !rsp_error;
      fails  <= rsp_valid && rsp_error;
    end
  end
  always_ff @(posedge clk_i) begin
    if (rsp_valid) begin
      issue <= '{slot: rsp_slot, pass_b: rsp_pass_b, odd: rsp_odd, elem: rsp_elem};
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
    .write_data_i(
    '{ray: test_data_i.operands, tnear: test_data_i.tnear, tfar: test_data_i.tfar}
    )
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

  assign plane = issue.elem;
  assign bary  = issue.odd ? issue.elem[255:128] : issue.elem[127:0];

  // The two passes.
  tag_t issue_tag;

  assign issue_tag = '{
          slot: issue.slot,
          miss: issue.pass_b && between.miss,
          axis: issue.pass_b ? between.axis : plane.axis[1:0],
          prim: issue.pass_b ? between.prim : plane.prim
      };

  ti_ist1_pipe #(
    .TagWidth($bits(tag_t))
  ) u_pipe (
    .clk_i,
    .rst_ni,
    .valid_i (issues),
    .pass_b_i(issue.pass_b),
    .tag_i   (issue_tag),
    .axis_i  (issue_tag.axis),
    .o_i     (operands.ray.o),
    .d_i     (operands.ray.d),
    .tnear_i (operands.tnear),
    .tfar_i  (operands.tfar),
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

  assign go_on = result_valid && (result_keep || !EarlyExit) && !result_b;
  assign between_new = '{
          prim: result_tag.prim,
          axis: result_tag.axis,
          miss: !result_keep,
          det: result_det,
          dett: result_dett,
          audet: result_x,
          av: result_y
      };

  // What leaves: tests inside the triangle to IST2, misses and errors home.
  ti_ist1_egress #(
    .NumSlots(NumSlots)
  ) u_egress (
    .clk_i,
    .rst_ni,
    .take_i       (take),
    .take_slot_i  (new_slot),
    .take_home_i  (test_data_i.home),
    .inside_i     (result_valid && (result_keep || !EarlyExit) && result_b),
    .inside_miss_i(result_tag.miss || !result_keep),
    .miss_i       (result_valid && !result_keep && EarlyExit),
    .result_slot_i(result_tag.slot),
    .prim_i       (result_tag.prim),
    .values_i     ({result_det, result_dett, result_x, result_y}),
    .failed_i     (fails),
    .failed_slot_i(issue.slot),
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

    events_o.a_passes = issues && !issue.pass_b;
    events_o.b_passes = issues && issue.pass_b;
    events_o.cache    = cache_events;
  end

  // Else the parts of a triangle would lie across the elements that are fetched.
  `TI_ASSERT(PartsAreAligned, plane_base_i[4:0] == '0 && bary_base_i[4:0] == '0)

  if (ti_mem_pkg::LineBytes < ElemBytes) begin : gen_check_line_bytes
    $error("ti_ist1: LineBytes must hold a plane part, 32 bytes");
  end

  `TI_ASSERT_KNOWN(TestReadyKnown, test_ready_o)
  `TI_ASSERT_KNOWN(CandidateValidKnown, candidate_valid_o)
  `TI_ASSERT_KNOWN(ReturnValidKnown, return_valid_o)
  `TI_ASSERT_KNOWN(LineReqValidKnown, line_req_valid_o)
  `TI_ASSERT_KNOWN(LineRspReadyKnown, line_rsp_ready_o)

endmodule : ti_ist1
