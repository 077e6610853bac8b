// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The rows of a `ti_ra`: lines on their way or handing out, and the rays that wait for each.
///
/// A row is a list of slots, linked by one pointer a slot.  It is free, waits for its line, or is filled and hands
/// out, in the order in which they were filled; with `Retry` when the look-up that is decided is its first ray.  The look-up that is decided (`valid_i`, `slot_i`, `line_i`, `elem_i`) joins the row of its line (`join_i`, while
/// `same_o`) or forms one (`form_i`, while `free_o`).  `drain_i` takes the first ray out of the row
/// that hands out, while `filled_o`; with its last the row is free.  `awaited_o` says whether a row waits for the answer of an id, and `fill_i` that
/// all of it has come.  All outputs follow from registers and the answer's id, none from `join_i`,
/// `form_i` or the answer's data.
module ti_ra_rows #(
  /// Rays, each in at most one row.
  parameter int unsigned NumSlots = 8,
  parameter int unsigned Rows = 2,
  parameter int unsigned ElemWidth = 3,
  /// Of the L1 that holds the lines.
  parameter int unsigned Sets = 8,
  parameter int unsigned WayWidth = 1,
  /// Lines are compared with those of the rows in a cycle of their own, that of `compare_en_i`.
  parameter bit Compare = 1'b0,
  /// Rays look again; no more than the first one is in a row.
  parameter bit Retry = 1'b0,
  /// A filled row hands out a cycle later, and the path from the answer's id ends before that.
  parameter bit Wait = 1'b0,
  localparam int unsigned SlotWidth = $clog2(NumSlots),
  localparam int unsigned SetWidth = (Sets > 1) ? $clog2(Sets) : 1,
  localparam int unsigned RowWidth = (Rows > 1) ? $clog2(Rows) : 1
) (
  input logic clk_i,
  input logic rst_ni,

  // With `Compare`, what is decided from the next cycle on.
  input logic                   compare_en_i,
  input ti_mem_pkg::line_addr_t compare_line_i,

  // What is decided.
  input  logic                                   valid_i,
  input  logic                   [SlotWidth-1:0] slot_i,
  input  ti_mem_pkg::line_addr_t                 line_i,
  input  logic                   [ElemWidth-1:0] elem_i,
  output logic                                   same_o,      // its line is on its way
  input  logic                                   join_i,
  output logic                                   free_o,      // a row is free
  output logic                   [ RowWidth-1:0] free_row_o,
  input  logic                                   form_i,
  input  logic                   [ WayWidth-1:0] way_i,       // the place of the line

  // An answer of memory.
  input  logic                               fill_i,
  input  ti_mem_pkg::row_id_t                fill_id_i,
  input  logic                               fill_error_i,
  output logic                               awaited_o,
  output logic                [SetWidth-1:0] fill_set_o,
  output logic                [WayWidth-1:0] fill_way_o,

  // The row that hands out.
  output logic                 filled_o,       // there is one
  input  logic                 drain_i,
  output logic [SlotWidth-1:0] drain_slot_o,
  output logic [ElemWidth-1:0] drain_elem_o,
  output logic                 drain_error_o,
  output logic                 drain_last_o,   // its last ray, with `drain_i`
  output logic [ SetWidth-1:0] drain_set_o,
  output logic [ WayWidth-1:0] drain_way_o,

  output logic waits_o,  // a line is on its way
  output logic empty_o   // no row is taken
);

  typedef logic [SlotWidth-1:0] slot_t;
  typedef logic [RowWidth-1:0] row_t;
  typedef ti_mem_pkg::line_addr_t line_addr_t;

  logic [Rows-1:0] busy_q, waits_q, error_q;
  line_addr_t line_q[Rows];
  logic [SetWidth-1:0] set[Rows];
  logic [WayWidth-1:0] way_q[Rows];
  slot_t head_q[Rows];
  slot_t tail_q[Rows];
  row_t drain_row, fill_row;
  slot_t next;  // the ray behind the first one of the row that hands out

  // The row of the look-up's line, and a free one.
  logic [Rows-1:0] same_line, match, forms;
  row_t match_row;
  assign match   = waits_q & same_line;
  assign same_o  = |match;
  assign free_o  = !(&busy_q);
  assign waits_o = |waits_q;
  assign empty_o = busy_q == '0;

  always_comb begin
    match_row  = '0;
    free_row_o = '0;
    for (int i = int'(Rows) - 1; i >= 0; i--) begin
      if (match[i]) match_row = row_t'(i);
      if (!busy_q[i]) free_row_o = row_t'(i);
    end
  end

  for (genvar r = 0; r < Rows; r++) begin : gen_row
    assign forms[r] = !busy_q[r] && free_row_o == row_t'(r);
    assign set[r]   = (Sets > 1) ? line_q[r][SetWidth-1:0] : '0;

    if (!Compare) begin : gen_together
      assign same_line[r] = line_q[r] == line_i;
    end else begin : gen_compared
      logic same_q;
      always_ff @(posedge clk_i) begin
        if (compare_en_i) same_q <= compare_line_i == (forms[r] ? line_i : line_q[r]);
      end
      assign same_line[r] = same_q;
    end

    // A row that is free takes what comes, and so does not wait for the decision.
    always_ff @(posedge clk_i) begin
      if (valid_i && forms[r]) begin
        line_q[r] <= line_i;
        way_q[r]  <= way_i;
        head_q[r] <= slot_i;
        tail_q[r] <= slot_i;
      end
      if (join_i && match[r]) tail_q[r] <= slot_i;
      if (drain_i && drain_row == row_t'(r)) head_q[r] <= next;
    end
  end
  if (!Compare) begin : gen_no_compare
    logic unused;
    assign unused = compare_en_i ^ (^compare_line_i);
  end

  // Answers.
  logic row_exists;
  assign row_exists = 32'(fill_id_i) < Rows;
  assign fill_row   = fill_id_i[RowWidth-1:0];
  assign awaited_o  = row_exists && waits_q[fill_row];
  assign fill_set_o = set[fill_row];
  assign fill_way_o = way_q[fill_row];
  always_ff @(posedge clk_i) if (fill_i) error_q[fill_row] <= fill_error_i;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      busy_q  <= '0;
      waits_q <= '0;
    end else begin
      if (form_i) begin
        busy_q[free_row_o]  <= 1'b1;
        waits_q[free_row_o] <= 1'b1;
      end
      if (fill_i) waits_q[fill_row] <= 1'b0;
      if (drain_last_o) busy_q[drain_row] <= 1'b0;
    end
  end

  // Which row hands out, and the place of its line.
  if (Retry) begin : gen_retry
    logic [Rows-1:0] mine;
    for (genvar r = 0; r < Rows; r++) begin : gen_mine
      assign mine[r] = busy_q[r] && !waits_q[r] && head_q[r] == slot_i;
    end
    always_comb begin
      drain_row = '0;
      for (int unsigned r = 0; r < Rows; r++) if (mine[r]) drain_row = row_t'(r);
    end
    assign filled_o    = valid_i && mine != '0;
    assign drain_set_o = set[drain_row];
    assign drain_way_o = way_q[drain_row];

    `TI_ASSERT(OneRowARay, valid_i -> $onehot0(mine))
  end else begin : gen_gather
    typedef struct packed {
      row_t                row;
      logic [SetWidth-1:0] set;
      logic [WayWidth-1:0] way;
    } filled_t;
    filled_t fills, push_data, first;
    logic push;
    assign fills = '{row: fill_row, set: fill_set_o, way: fill_way_o};
    if (!Wait) begin : gen_at_once
      assign push      = fill_i;
      assign push_data = fills;
    end else begin : gen_wait
      always_ff @(`TI_CLK_RST) begin
        if (!rst_ni) push <= 1'b0;
        else push <= fill_i;
      end
      always_ff @(posedge clk_i) push_data <= fills;
    end
    ti_queue #(
      .payload_t(filled_t),
      .Depth    (Rows)
    ) u_filled (
      .clk_i,
      .rst_ni,
      .push_i     (push),
      .push_data_i(push_data),
      .out_valid_o(filled_o),
      .out_ready_i(drain_last_o),
      .out_data_o (first)
    );
    assign {drain_row, drain_set_o, drain_way_o} = first;
  end

  // Hand-out.
  assign drain_slot_o  = head_q[drain_row];
  assign drain_last_o  = drain_i && drain_slot_o == tail_q[drain_row];
  assign drain_error_o = error_q[drain_row];

  // Behind the last ray of a row any pointer may stand, and any element of a ray that waits in none.
  ti_regfile #(
    .Depth (NumSlots),
    .word_t(slot_t)
  ) u_next (
    .clk_i,
    .read_addr_i (drain_slot_o),
    .read_data_o (next),
    .write_en_i  (valid_i && same_o),
    .write_addr_i(tail_q[match_row]),
    .write_data_i(slot_i)
  );
  ti_regfile #(
    .Depth (NumSlots),
    .word_t(logic [ElemWidth-1:0])
  ) u_elem (
    .clk_i,
    .read_addr_i (drain_slot_o),
    .read_data_o (drain_elem_o),
    .write_en_i  (valid_i),
    .write_addr_i(slot_i),
    .write_data_i(elem_i)
  );

  if (NumSlots < 2 || Rows < 1 || Sets < 1 || ElemWidth < 1 || WayWidth < 1) begin : gen_check
    $error("ti_ra_rows: NumSlots must be 2 or more, other sizes 1 or more");
  end

  `TI_ASSERT(OneRowALine, valid_i -> $onehot0(match))
  `TI_ASSERT(JoinsTheRowOfItsLine, join_i -> valid_i && same_o)
  `TI_ASSERT(FormsAFreeRow, form_i -> valid_i && free_o && !join_i)
  `TI_ASSERT(DrainsAFilledRow, drain_i -> filled_o && busy_q[drain_row] && !waits_q[drain_row])
  `TI_ASSERT(FillsARowThatWaits, fill_i -> awaited_o)
  `TI_COVER(JoinsARowAsItFills, join_i && fill_i && match[fill_row])

endmodule : ti_ra_rows
