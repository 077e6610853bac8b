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
/// Latency 2 cycles on a hit, one answer a cycle.  `rsp` stalls the unit as a whole.  The caller has at
/// most one request in flight for a slot.  `line_rsp` is always accepted; an answer to nothing that was asked
/// for is dropped.  A line answered with an error is not kept; its rays get `rsp_error_o`, their element is
/// undefined.  `flush_i` forgets all lines and is up only while `idle_o` is and no request comes.
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
  localparam int unsigned LineBytes = ti_mem_pkg::LineBytes,
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
  localparam int unsigned Sets = CacheBytes / ((Ways > 0) ? Ways * LineBytes : 1);
  localparam int unsigned SetWidth = (Sets > 1) ? $clog2(Sets) : 1;
  localparam int unsigned WayWidth = (Ways > 1) ? $clog2(Ways) : 1;
  localparam bit Blocking = Mode == ti_config_pkg::RayAccumulationBlocking;
  localparam bit Retry = Mode == ti_config_pkg::RayAccumulationRetry;

  typedef logic [SlotWidth-1:0] slot_t;
  typedef logic [RowWidth-1:0] row_t;
  typedef logic [ElemWidth-1:0] elem_t;
  typedef ti_mem_pkg::line_addr_t line_addr_t;

  // Step 1: the request whose tags have been read.
  logic s1_valid_q, s1_done;
  slot_t s1_slot_q;
  line_addr_t s1_line_q;
  elem_t s1_elem_q;

  // Step 2: the line has been read.
  logic s2_valid_q, s2_error_q, s2_free;
  slot_t s2_slot_q;
  elem_t s2_elem_q;

  // Rows.
  logic [Rows-1:0] row_busy_q, row_filled_q, row_error_q;
  line_addr_t row_line_q[Rows];
  logic [SetWidth-1:0] row_set[Rows];
  logic [WayWidth-1:0] row_way_q[Rows];
  slot_t row_head_q[Rows];
  slot_t row_tail_q[Rows];
  slot_t next_q[NumSlots];
  elem_t elem_q[NumSlots];

  // Decisions of this cycle.
  logic
      hit,
      victim_valid,
      drain,
      drain_last,
      merge,
      row_free_any,
      use_hit,
      use_merge,
      use_miss,
      may_ask;
  logic line_queue_ready;
  logic [WayWidth-1:0] hit_way, victim_way;
  row_t merge_row, free_row, drain_row;
  slot_t drain_slot;
  logic [Rows-1:0] row_match;

  // An answer counts where its row waits for one.
  logic fill, row_exists;
  row_t fill_row;
  assign row_exists = 32'(line_rsp_data_i.id) < Rows;
  assign fill_row = line_rsp_data_i.id[RowWidth-1:0];
  assign fill = line_rsp_valid_i && row_exists && row_busy_q[fill_row] && !row_filled_q[fill_row];
  assign line_rsp_ready_o = 1'b1;

  // Who is looked up: a request or, in `Retry`, a ray that looks again.
  logic look_valid, look_ready, look_go, retries;
  slot_t look_slot;
  line_addr_t req_line, look_line;
  elem_t req_elem, look_elem;
  assign req_line = req_addr_i[ti_mem_pkg::AddrWidth-1:$clog2(LineBytes)];
  assign req_elem = (Elems > 1) ? elem_t'(req_addr_i[$clog2(
      LineBytes
  )-1:0] >> $clog2(
      ElemBytes
  )) : '0;
  assign look_ready = !s1_valid_q || s1_done;
  assign look_go = look_valid && look_ready;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) s1_valid_q <= 1'b0;
    else if (look_ready) s1_valid_q <= look_valid;
  end

  always_ff @(posedge clk_i) begin
    if (look_go) begin
      s1_slot_q <= look_slot;
      s1_line_q <= look_line;
      s1_elem_q <= look_elem;
    end
  end

  for (genvar r = 0; r < Rows; r++) begin : gen_row
    assign row_match[r] = row_busy_q[r] && !row_filled_q[r] && row_line_q[r] == s1_line_q;
    assign row_set[r]   = (Sets > 1) ? row_line_q[r][SetWidth-1:0] : '0;
  end

  always_comb begin
    merge_row = '0;
    free_row  = '0;
    for (int i = int'(Rows) - 1; i >= 0; i--) begin
      if (row_match[i]) merge_row = row_t'(i);
      if (!row_busy_q[i]) free_row = row_t'(i);
    end
  end

  logic filled, stopped, again;
  if (Retry) begin : gen_retry
    // A row is filled for the ray that asked for its line, when that looks again.
    logic [Rows-1:0] mine;
    for (genvar r = 0; r < Rows; r++) begin : gen_mine
      assign mine[r] = row_filled_q[r] && row_head_q[r] == s1_slot_q;
    end
    assign filled = s1_valid_q && mine != '0;
    always_comb begin
      drain_row = '0;
      for (int unsigned r = 0; r < Rows; r++) if (mine[r]) drain_row = row_t'(r);
    end

    // A ray that has neither its line nor a row, and not for the first time, keeps new rays out: those inside become
    // fewer until it has a row.
    logic s1_again_q, closed_q, refused, req_go;
    slot_t closed_slot_q;
    assign refused = s1_valid_q && !filled && !hit && !merge && !may_ask;
    assign again   = use_merge || use_miss || refused;

    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) closed_q <= 1'b0;
      else if (refused && s1_again_q) closed_q <= 1'b1;
      else if (s1_done && s1_slot_q == closed_slot_q) closed_q <= 1'b0;
    end
    always_ff @(posedge clk_i) begin
      if (refused && s1_again_q && !closed_q) closed_slot_q <= s1_slot_q;
      if (look_go) s1_again_q <= !req_go;
    end

    // New rays and those that look again take turns.
    logic req_first_q, retry_valid, retry_go;
    slot_t retry_slot;
    line_addr_t retry_line;
    elem_t retry_elem;
    ti_queue #(
      .payload_t(logic [SlotWidth+LineAddrWidth+ElemWidth-1:0]),
      .Depth    (NumSlots)
    ) u_again (
      .clk_i,
      .rst_ni,
      .push_i     (again),
      .push_data_i({s1_slot_q, s1_line_q, s1_elem_q}),
      .out_valid_o(retry_valid),
      .out_ready_i(retry_go),
      .out_data_o ({retry_slot, retry_line, retry_elem})
    );
    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) req_first_q <= 1'b0;
      else if (look_go) req_first_q <= !req_go;
    end
    assign req_ready_o = look_ready && !closed_q && (req_first_q || !retry_valid);
    assign req_go      = req_valid_i && req_ready_o;
    assign retry_go    = retry_valid && look_ready && !req_go;
    assign look_valid  = retry_valid || (req_valid_i && !closed_q);
    assign look_slot   = req_go ? req_slot_i : retry_slot;
    assign look_line   = req_go ? req_line : retry_line;
    assign look_elem   = req_go ? req_elem : retry_elem;
    assign retries     = retry_valid;
    assign stopped     = 1'b0;

    `TI_ASSERT(OneRowARay, s1_valid_q |-> $onehot0(mine))
  end else begin : gen_rows
    ti_queue #(
      .payload_t(row_t),
      .Depth    (Rows)
    ) u_filled (
      .clk_i,
      .rst_ni,
      .push_i     (fill),
      .push_data_i(fill_row),
      .out_valid_o(filled),
      .out_ready_i(drain_last),
      .out_data_o (drain_row)
    );
    assign req_ready_o = look_ready;
    assign look_valid  = req_valid_i;
    assign look_slot   = req_slot_i;
    assign look_line   = req_line;
    assign look_elem   = req_elem;
    assign retries     = 1'b0;
    assign again       = 1'b0;
    assign stopped     = Blocking && row_busy_q != '0;
  end

  // Filled rows hand out before hits, in the order in which they were filled.  A hit that waits keeps new rows
  // from forming, so it waits for at most the rows there are.
  assign merge                = |row_match;
  assign row_free_any         = !(&row_busy_q);
  assign s2_free              = !s2_valid_q || rsp_ready_i;
  assign drain                = filled && s2_free;
  assign drain_slot           = row_head_q[drain_row];
  assign drain_last           = drain && drain_slot == row_tail_q[drain_row];
  assign use_merge            = s1_valid_q && merge && !stopped && !(Retry && filled);
  assign use_hit              = s1_valid_q && !merge && hit && s2_free && !filled && !stopped;
  assign may_ask              = row_free_any && victim_valid && line_queue_ready && !stopped;
  assign use_miss             = s1_valid_q && !merge && !hit && may_ask && !(Retry && filled);
  assign s1_done              = use_merge || use_hit || use_miss || again || (Retry && drain);

  assign events_o.l1_accesses = s1_done;
  assign events_o.l1_hits     = use_hit || (Retry && drain);
  assign events_o.l1_merged   = use_merge || (again && !use_miss);
  assign events_o.l1_misses   = use_miss;

  assign idle_o               = !s1_valid_q && !s2_valid_q && row_busy_q == '0 && !retries;
  assign waits_o              = (row_busy_q & ~row_filled_q) != '0;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      row_busy_q   <= '0;
      row_filled_q <= '0;
    end else begin
      if (use_miss) row_busy_q[free_row] <= 1'b1;
      if (fill) row_filled_q[fill_row] <= 1'b1;
      if (drain_last) begin
        row_busy_q[drain_row]   <= 1'b0;
        row_filled_q[drain_row] <= 1'b0;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (fill) row_error_q[fill_row] <= line_rsp_data_i.error;
    if (use_miss) begin
      row_line_q[free_row] <= s1_line_q;
      row_way_q[free_row]  <= victim_way;
      row_head_q[free_row] <= s1_slot_q;
      row_tail_q[free_row] <= s1_slot_q;
    end
    if (use_merge && !Retry) begin
      next_q[row_tail_q[merge_row]] <= s1_slot_q;
      row_tail_q[merge_row]         <= s1_slot_q;
    end
    if (use_miss || use_merge) elem_q[s1_slot_q] <= s1_elem_q;
    if (drain) row_head_q[drain_row] <= next_q[drain_slot];
  end

  logic [8*LineBytes-1:0] read_line;

  ti_l1 #(
    .CacheBytes   (CacheBytes),
    .Ways         (Ways),
    .LineBytes    (LineBytes),
    .LineAddrWidth(LineAddrWidth)
  ) u_l1 (
    .clk_i,
    .rst_ni,
    .flush_i,
    .lookup_en_i   (look_go),
    .lookup_set_i  ((Sets > 1) ? look_line[SetWidth-1:0] : '0),
    .line_i        (s1_line_q),
    .hit_o         (hit),
    .hit_way_o     (hit_way),
    .victim_valid_o(victim_valid),
    .victim_way_o  (victim_way),
    .touch_i       (use_hit),
    .alloc_i       (use_miss),
    .fill_i        (fill),
    .fill_good_i   (!line_rsp_data_i.error),
    .fill_set_i    (row_set[fill_row]),
    .fill_way_i    (row_way_q[fill_row]),
    .fill_data_i   (line_rsp_data_i.data),
    .unpin_i       (drain_last),
    .unpin_set_i   (row_set[drain_row]),
    .unpin_way_i   (row_way_q[drain_row]),
    .read_en_i     (drain || use_hit),
    .read_set_i    (drain ? row_set[drain_row] : ((Sets > 1) ? s1_line_q[SetWidth-1:0] : '0)),
    .read_way_i    (drain ? row_way_q[drain_row] : hit_way),
    .line_o        (read_line)
  );

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) s2_valid_q <= 1'b0;
    else if (s2_free) s2_valid_q <= drain || use_hit;
  end

  always_ff @(posedge clk_i) begin
    if (drain) begin
      s2_slot_q  <= drain_slot;
      s2_elem_q  <= elem_q[drain_slot];
      s2_error_q <= row_error_q[drain_row];
    end else if (use_hit) begin
      s2_slot_q  <= s1_slot_q;
      s2_elem_q  <= s1_elem_q;
      s2_error_q <= 1'b0;
    end
  end

  assign rsp_valid_o = s2_valid_q;
  assign rsp_slot_o  = s2_slot_q;
  assign rsp_error_o = s2_error_q;
  assign rsp_elem_o  = read_line[(32'(s2_elem_q)*ElemBytes*8)+:ElemBytes*8];

  // Line requests wait here for the port; a row asks once, so Rows places are enough.
  ti_fifo #(
    .payload_t(ti_mem_pkg::line_req_t),
    .Depth    (Rows)
  ) u_line_requests (
    .clk_i,
    .rst_ni,
    .in_valid_i (use_miss),
    .in_ready_o (line_queue_ready),
    .in_data_i  ('{id: ti_mem_pkg::row_id_t'(free_row), line: s1_line_q}),
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
  if (Elems * ElemBytes != LineBytes || (Elems & (Elems - 1)) != 0) begin : gen_check_elem_bytes
    $error("ti_ra: ElemBytes must divide LineBytes into a power of two");
  end

  `TI_ASSERT(OutHeldUntilTaken, rsp_valid_o && !rsp_ready_i |=> rsp_valid_o && $stable
                                ({rsp_slot_o, rsp_elem_o, rsp_error_o}))
  `TI_ASSERT(OneRowALine, $onehot0(row_match))
  `TI_ASSERT(FlushedOnlyIdle, flush_i |-> idle_o && !req_valid_i)
  `TI_COVER(StrayAnswer, line_rsp_valid_i && !fill)
  `TI_COVER(JoinsARowAsItFills, use_merge && fill && fill_row == merge_row)
  `TI_ASSERT_KNOWN(ReqReadyKnown, req_ready_o)
  `TI_ASSERT_KNOWN(RspValidKnown, rsp_valid_o)
  `TI_ASSERT_KNOWN(LineReqValidKnown, line_req_valid_o)
  `TI_ASSERT_KNOWN(LineRspReadyKnown, line_rsp_ready_o)

endmodule : ti_ra
