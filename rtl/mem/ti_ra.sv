// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Ray accumulation unit in front of an L1 (Nah et al. 2011, section 4): rays that need a line that is
/// on its way gather in the line's row and leave, one a cycle, when it has arrived; other rays pass them.
///
/// A row holds slot numbers as a linked list, one pointer a slot, not rays.  The place of a line is
/// reserved when it is asked for and pinned until its row is empty, so each gathered ray is served
/// by the line it waited for, whatever happens to the cache meanwhile.
///
/// For comparison (`Mode`), a unit without the idea.  Blocking: a miss stops the unit until its ray has its line.
/// Retry, plain multithreading: a ray whose line is not here goes to the end of a queue and looks the cache up
/// again, and again; the ray that asks for a line holds its row until it has looked up the line that came.
///
/// Latency `LookupStages` + 1 cycles on a hit, one answer a cycle.  `rsp` stalls the unit as a whole.  The caller has at
/// most one request in flight for a slot.  `line_rsp` is accepted without condition, each in the cycles that the L1 takes to
/// store it (`FillBytes`); an answer to nothing that was asked for is dropped.  A line answered with an error is not kept;
/// its rays get `rsp_error_o`, their element is undefined.  `flush_i` forgets all lines and is up only while `idle_o` is
/// and no request comes.
module ti_ra #(
  /// Requesters; each has at most one request in flight.
  parameter int unsigned NumSlots = 8,
  /// Lines on their way or handing out.
  parameter int unsigned Rows = 2,
  /// Bytes of an answer: the aligned element that holds the address; a power of two up to LineBytes.
  parameter int unsigned ElemBytes = 8,
  parameter int unsigned CacheBytes = 1024,
  parameter int unsigned Ways = 2,
  parameter ti_config_pkg::ray_accumulation_e Mode = ti_config_pkg::RayAccumulationGather,
  /// 1 to 5: from 2 on tags and rows are compared in a step of their own, with 5 requests wait; 3 and 4 are of `ti_ra_answers`.
  parameter int unsigned LookupStages = ti_config_pkg::LookupStages,
  /// Bytes that the L1 stores in a cycle, at least ElemBytes, at most a line: 8 or more.
  parameter int unsigned FillBytes = ti_config_pkg::FillBytes,
  localparam int unsigned LineBytes = ti_mem_pkg::LineBytes,
  localparam int unsigned LessBytes = (FillBytes < LineBytes) ? FillBytes : LineBytes,
  localparam int unsigned WordBytes = (LessBytes > ElemBytes) ? LessBytes : ElemBytes,
  localparam int unsigned SlotWidth = $clog2(NumSlots)
) (
  input  logic clk_i,
  input  logic rst_ni,
  input  logic flush_i,
  output logic idle_o,   // no request inside, no line on its way
  output logic waits_o,  // a line is on its way

  input  logic                              req_valid_i,
  output logic                              req_ready_o,
  input  logic              [SlotWidth-1:0] req_slot_i,
  input  ti_mem_pkg::addr_t                 req_addr_i,

  output logic                   rsp_valid_o,
  input  logic                   rsp_ready_i,
  output logic [  SlotWidth-1:0] rsp_slot_o,
  output logic [8*ElemBytes-1:0] rsp_elem_o,
  output logic                   rsp_error_o,

  output logic                  line_req_valid_o,
  input  logic                  line_req_ready_i,
  output ti_mem_pkg::line_req_t line_req_data_o,

  input  logic                  line_rsp_valid_i,
  output logic                  line_rsp_ready_o,
  input  ti_mem_pkg::line_rsp_t line_rsp_data_i,

  output ti_count_pkg::cache_events_t events_o
);

  localparam int unsigned LineAddrWidth = ti_mem_pkg::LineAddrWidth;
  localparam int unsigned RowWidth = (Rows > 1) ? $clog2(Rows) : 1;
  localparam int unsigned Elems = LineBytes / ElemBytes;
  localparam int unsigned ElemWidth = (Elems > 1) ? $clog2(Elems) : 1;
  localparam int unsigned Words = LineBytes / WordBytes;
  localparam int unsigned IndexWidth = (Words > 1) ? $clog2(Words) : 1;
  localparam int unsigned PartBits = $clog2(WordBytes / ElemBytes);  // of an element in its word
  localparam int unsigned PartWidth = (PartBits > 0) ? PartBits : 1;
  localparam int unsigned Sets = CacheBytes / ((Ways > 0) ? Ways * LineBytes : 1);
  localparam int unsigned SetWidth = (Sets > 1) ? $clog2(Sets) : 1;
  localparam int unsigned WayWidth = (Ways > 1) ? $clog2(Ways) : 1;
  localparam bit Compare = LookupStages > 1;
  localparam bit Blocking = Mode == ti_config_pkg::RayAccumulationBlocking;
  localparam bit Retry = Mode == ti_config_pkg::RayAccumulationRetry;

  typedef logic [SlotWidth-1:0] slot_t;
  typedef logic [RowWidth-1:0] row_t;
  typedef logic [ElemWidth-1:0] elem_t;
  typedef ti_mem_pkg::line_addr_t line_addr_t;

  typedef struct packed {
    slot_t      slot;
    line_addr_t line;
    elem_t      elem;
    logic       again;  // `Retry`: not for the first time
  } lookup_t;

  typedef struct packed {
    logic [SetWidth-1:0] set;
    logic [WayWidth-1:0] way;
  } place_t;

  // Step 1: the request whose tags have been read, and with `Compare` compared.
  lookup_t look, read, compare, s1;
  logic look_valid, look_ready, read_en, compare_en, s1_valid, s1_done, steps_empty;

  // Step 2: the word has been read.
  logic s2_valid_q, s2_error_q, s2_taken, s2_free;
  slot_t s2_slot_q;
  logic [PartWidth-1:0] s2_part_q;

  logic answers_idle;

  // Decisions of this cycle.
  logic hit, victim_valid, merge, row_free, use_hit, use_merge, use_miss, may_ask;
  logic [WayWidth-1:0] hit_way, victim_way;
  row_t free_row;

  // An answer that is awaited, its words, and the ray that a filled row hands out.
  logic awaited, store, fill, drain, drain_last, drain_error;
  logic [ IndexWidth-1:0] store_index;
  logic [8*WordBytes-1:0] store_word;
  place_t fill_place, drain_place;
  slot_t drain_slot;
  elem_t drain_elem;
  logic filled, rows_empty;

  // Who is looked up: a request or, in `Retry`, a ray that looks again.
  logic retries;
  lookup_t req;
  assign req = '{
          slot: req_slot_i,
          line: req_addr_i[ti_mem_pkg::AddrWidth-1:$clog2(LineBytes)],
          elem: (Elems > 1) ? elem_t'(req_addr_i[$clog2(LineBytes)-1:0] >> $clog2(ElemBytes)) : '0,
          again: 1'b0
      };

  ti_ra_steps #(
    .lookup_t(lookup_t),
    .Compare (Compare),
    .Wait    (LookupStages > 4)
  ) u_steps (
    .clk_i,
    .rst_ni,
    .empty_o       (steps_empty),
    .look_valid_i  (look_valid),
    .look_ready_o  (look_ready),
    .look_i        (look),
    .read_en_o     (read_en),
    .read_o        (read),
    .compare_en_o  (compare_en),
    .compare_o     (compare),
    .decide_valid_o(s1_valid),
    .decided_i     (s1_done),
    .decide_o      (s1)
  );
  logic unused_steps;
  assign unused_steps = (^read) ^ (^compare);

  ti_ra_rows #(
    .NumSlots (NumSlots),
    .Rows     (Rows),
    .ElemWidth(ElemWidth),
    .Sets     (Sets),
    .WayWidth (WayWidth),
    .Compare  (Compare),
    .Retry    (Retry),
    .Wait     (LookupStages > 4)
  ) u_rows (
    .clk_i,
    .rst_ni,
    .compare_en_i  (compare_en),
    .compare_line_i(compare.line),
    .valid_i       (s1_valid),
    .slot_i        (s1.slot),
    .line_i        (s1.line),
    .elem_i        (s1.elem),
    .same_o        (merge),
    .join_i        (use_merge && !Retry),
    .free_o        (row_free),
    .free_row_o    (free_row),
    .form_i        (use_miss),
    .way_i         (victim_way),
    .fill_i        (fill),
    .fill_id_i     (line_rsp_data_i.id),
    .fill_error_i  (line_rsp_data_i.error),
    .awaited_o     (awaited),
    .fill_set_o    (fill_place.set),
    .fill_way_o    (fill_place.way),
    .filled_o      (filled),
    .drain_i       (drain),
    .drain_slot_o  (drain_slot),
    .drain_elem_o  (drain_elem),
    .drain_error_o (drain_error),
    .drain_last_o  (drain_last),
    .drain_set_o   (drain_place.set),
    .drain_way_o   (drain_place.way),
    .waits_o,
    .empty_o       (rows_empty)
  );

  logic stopped, again;
  if (Retry) begin : gen_retry
    logic refused;
    assign refused = s1_valid && !filled && !hit && !merge && !may_ask;
    assign again   = use_merge || use_miss || refused;
    ti_ra_retry #(
      .NumSlots(NumSlots),
      .lookup_t(lookup_t)
    ) u_retry (
      .clk_i,
      .rst_ni,
      .req_valid_i,
      .req_ready_o,
      .req_data_i  (req),
      .look_valid_o(look_valid),
      .look_ready_i(look_ready),
      .look_data_o (look),
      .again_i     (again),
      .again_data_i('{slot: s1.slot, line: s1.line, elem: s1.elem, again: 1'b1}),
      .refused_i   (refused && s1.again),
      .done_i      (s1_done),
      .slot_i      (s1.slot),
      .waits_o     (retries)
    );
    assign stopped = 1'b0;
  end else begin : gen_rows
    assign req_ready_o = look_ready;
    assign look_valid  = req_valid_i;
    assign look        = req;
    assign retries     = 1'b0;
    assign again       = 1'b0;
    assign stopped     = Blocking && !rows_empty;
    logic unused;
    assign unused = s1.again;
  end

  // Filled rows hand out before hits, in the order in which they were filled.  A hit that waits keeps new rows
  // from forming, so it waits for at most the rows there are.
  assign s2_free = !s2_valid_q || s2_taken;
  assign drain = filled && s2_free;
  assign use_merge = s1_valid && merge && !stopped && !(Retry && filled);
  assign use_hit = s1_valid && !merge && hit && s2_free && !filled && !stopped;
  assign may_ask = row_free && victim_valid && !stopped;
  assign use_miss = s1_valid && !merge && !hit && may_ask && !(Retry && filled);
  assign s1_done = use_merge || use_hit || use_miss || again || (Retry && drain);

  assign events_o.l1_accesses = s1_done;
  assign events_o.l1_hits = use_hit || (Retry && drain);
  assign events_o.l1_merged = use_merge || (again && !use_miss);
  assign events_o.l1_misses = use_miss;

  assign idle_o = steps_empty && !s2_valid_q && answers_idle && rows_empty && !retries;

  ti_ra_fill #(
    .LineBytes(LineBytes),
    .WordBytes(WordBytes)
  ) u_fill (
    .clk_i,
    .rst_ni,
    .line_valid_i(line_rsp_valid_i),
    .line_ready_o(line_rsp_ready_o),
    .line_i      (line_rsp_data_i.data),
    .awaited_i   (awaited),
    .write_o     (store),
    .index_o     (store_index),
    .word_o      (store_word),
    .fill_o      (fill)
  );

  logic [8*WordBytes-1:0] read_word;
  elem_t read_elem;
  assign read_elem = filled ? drain_elem : s1.elem;

  ti_l1 #(
    .CacheBytes   (CacheBytes),
    .Ways         (Ways),
    .LineBytes    (LineBytes),
    .WordBytes    (WordBytes),
    .LineAddrWidth(LineAddrWidth),
    .Compare      (Compare)
  ) u_l1 (
    .clk_i,
    .rst_ni,
    .flush_i,
    .lookup_en_i   (read_en),
    .lookup_set_i  ((Sets > 1) ? read.line[SetWidth-1:0] : '0),
    .compare_en_i  (compare_en),
    .compare_line_i(compare.line),
    .line_i        (s1.line),
    .hit_o         (hit),
    .hit_way_o     (hit_way),
    .victim_valid_o(victim_valid),
    .victim_way_o  (victim_way),
    .touch_i       (use_hit),
    .alloc_i       (use_miss),
    .write_i       (store),
    .fill_i        (fill),
    .fill_good_i   (!line_rsp_data_i.error),
    .fill_set_i    (fill_place.set),
    .fill_way_i    (fill_place.way),
    .write_index_i (store_index),
    .write_word_i  (store_word),
    .unpin_i       (drain_last),
    .unpin_set_i   (drain_place.set),
    .unpin_way_i   (drain_place.way),
    .read_en_i     (s2_free && (filled || s1_valid)),
    .read_set_i    (filled ? drain_place.set : ((Sets > 1) ? s1.line[SetWidth-1:0] : '0)),
    .read_way_i    (filled ? drain_place.way : hit_way),
    .read_index_i  ((Words > 1) ? IndexWidth'(read_elem >> PartBits) : '0),
    .word_o        (read_word)
  );

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) s2_valid_q <= 1'b0;
    else if (s2_free) s2_valid_q <= drain || use_hit;
  end

  always_ff @(posedge clk_i) begin
    if (s2_free) begin
      s2_slot_q  <= filled ? drain_slot : s1.slot;
      s2_part_q  <= (PartBits > 0) ? PartWidth'(read_elem) : '0;
      s2_error_q <= filled && drain_error;
    end
  end

  ti_ra_answers #(
    .SlotWidth   (SlotWidth),
    .WordBytes   (WordBytes),
    .ElemBytes   (ElemBytes),
    .LookupStages(LookupStages)
  ) u_answers (
    .clk_i,
    .rst_ni,
    .idle_o      (answers_idle),
    .read_valid_i(s2_valid_q),
    .read_ready_o(s2_taken),
    .read_slot_i (s2_slot_q),
    .read_error_i(s2_error_q),
    .read_part_i (s2_part_q),
    .read_word_i (read_word),
    .rsp_valid_o,
    .rsp_ready_i,
    .rsp_slot_o,
    .rsp_elem_o,
    .rsp_error_o
  );

  // Line requests wait here for the port; a row asks once, so there is always a place.
  ti_queue #(
    .payload_t(ti_mem_pkg::line_req_t),
    .Depth    (Rows)
  ) u_line_requests (
    .clk_i,
    .rst_ni,
    .push_i     (use_miss),
    .push_data_i('{id: ti_mem_pkg::row_id_t'(free_row), line: s1.line}),
    .out_valid_o(line_req_valid_o),
    .out_ready_i(line_req_ready_i),
    .out_data_o (line_req_data_o)
  );

  if (NumSlots < 2) begin : gen_check_num_slots
    $error("ti_ra: NumSlots must be 2 or more");
  end
  if (Rows < 1 || Rows > ti_mem_pkg::MaxRows) begin : gen_check_rows
    $error("ti_ra: Rows must be 1 to ti_mem_pkg::MaxRows");
  end
  if (LookupStages < 1 || LookupStages > 5) begin : gen_check_lookup_stages
    $error("ti_ra: LookupStages must be 1 to 5");
  end
  if (Elems * ElemBytes != LineBytes || (Elems & (Elems - 1)) != 0) begin : gen_check_elem_bytes
    $error("ti_ra: ElemBytes must divide LineBytes into a power of two");
  end

  `TI_ASSERT_NEXT(OutHeldUntilTaken, rsp_valid_o && !rsp_ready_i, rsp_valid_o && $stable
                  ({rsp_slot_o, rsp_elem_o, rsp_error_o}))
  `TI_ASSERT(FlushedOnlyIdle, flush_i -> idle_o && !req_valid_i)
  `TI_ASSERT_KNOWN(ReqReadyKnown, req_ready_o)
  `TI_ASSERT_KNOWN(RspValidKnown, rsp_valid_o)
  `TI_ASSERT_KNOWN(LineReqValidKnown, line_req_valid_o)
  `TI_ASSERT_KNOWN(LineRspReadyKnown, line_rsp_ready_o)

endmodule : ti_ra
