// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// A look-up in `ti_l1` hits exactly when a way of its set holds its line: the last good line that was stored there, with
/// nothing reserved there and no flush since; a line answered with an error never hits.  A word that is read is the one
/// written last.  A pinned place is never the victim, an empty one is it before others, and with neither the way used last
/// is not; some way is offered whenever one is not pinned.
module ti_l1_formal #(
  parameter  int unsigned Ways          = 2,
  parameter  int unsigned Sets          = 1,
  parameter  int unsigned LineAddrWidth = 2,
  parameter  int unsigned WordWidth     = 8,
  parameter  int unsigned Words         = 1,
  parameter  bit          Compare       = 1'b0,
  localparam int unsigned SetWidth      = (Sets > 1) ? $clog2(Sets) : 1,
  localparam int unsigned WayWidth      = (Ways > 1) ? $clog2(Ways) : 1,
  localparam int unsigned IndexWidth    = (Words > 1) ? $clog2(Words) : 1
) (
  input logic clk_i,
  input logic rst_ni,
  input logic flush_i,
  input logic lookup_en_i,
  input logic [SetWidth-1:0] lookup_set_i,
  input logic compare_en_i,
  input logic [LineAddrWidth-1:0] compare_line_i,
  input logic [LineAddrWidth-1:0] line_i,
  input logic hit_o,
  input logic [WayWidth-1:0] hit_way_o,
  input logic victim_valid_o,
  input logic [WayWidth-1:0] victim_way_o,
  input logic touch_i,
  input logic alloc_i,
  input logic write_i,
  input logic fill_i,
  input logic fill_good_i,
  input logic [SetWidth-1:0] fill_set_i,
  input logic [WayWidth-1:0] fill_way_i,
  input logic [IndexWidth-1:0] write_index_i,
  input logic [WordWidth-1:0] write_word_i,
  input logic unpin_i,
  input logic [SetWidth-1:0] unpin_set_i,
  input logic [WayWidth-1:0] unpin_way_i,
  input logic read_en_i,
  input logic [SetWidth-1:0] read_set_i,
  input logic [WayWidth-1:0] read_way_i,
  input logic [IndexWidth-1:0] read_index_i,
  input logic [WordWidth-1:0] word_o,
  input logic [Ways-1:0] pinned_q[Sets]  // the reader takes it for no memory then
);
  `TI_STARTS_IN_RESET

  typedef logic [LineAddrWidth-1:0] line_addr_t;
  typedef logic [SetWidth-1:0] set_t;
  typedef logic [WayWidth-1:0] way_t;
  function automatic set_t set_of(line_addr_t line);
    return (Sets > 1) ? set_t'(line) : '0;
  endfunction

  // ---- The caller, `ti_ra`, in the order of `ti_ra_steps`: a set is read, with `Compare` its line compared, and the
  // look-up stands until the caller uses it, lets it go or another takes its place.
  logic reads_q, stands_q, held_q, lets_go, takes_place;
  set_t set, set_q;
  line_addr_t line_q;
  assign set         = set_of(line_i);
  assign takes_place = Compare ? compare_en_i && reads_q : lookup_en_i;
  always_ff @(posedge clk_i) begin
    if (lookup_en_i) set_q <= lookup_set_i;
    line_q <= (Compare && compare_en_i) ? compare_line_i : line_i;
    held_q <= Compare || !lookup_en_i;
    if (!rst_ni) begin
      reads_q  <= 1'b0;
      stands_q <= 1'b0;
    end else begin
      reads_q <= Compare && (lookup_en_i || (reads_q && !compare_en_i));
      if (takes_place) stands_q <= 1'b1;
      else if (touch_i || alloc_i || lets_go || (Compare && compare_en_i)) stands_q <= 1'b0;
    end
  end
  logic own_set;
  assign own_set = Compare || set == set_q;
  `TI_ASSUME(LineHeld, stands_q -> (held_q ? line_i == line_q : own_set))
  `TI_ASSUME(ComparesWhatWasRead, reads_q -> set_of(compare_line_i) == set_q)
  `TI_ASSUME(ReadsAsThePlaceIsFree, lookup_en_i && reads_q -> compare_en_i)
  `TI_ASSUME(UsesWhatStands, touch_i || alloc_i -> stands_q)
  if (Compare) begin : gen_compared
    `TI_ASSUME(UsesAsTheNextComes, touch_i || alloc_i -> compare_en_i)
  end
  `TI_ASSUME(UsesAHit, touch_i -> hit_o)
  `TI_ASSUME(ReservesForAMiss, alloc_i -> !hit_o && victim_valid_o)

  // ---- What stands where, by what the caller has done.
  logic [Sets-1:0][Ways-1:0] is_pinned_q, waits_q, asked_q, good_q, replaced_q, forgotten_q;
  logic [Sets-1:0][Ways-1:0][LineAddrWidth-1:0] lines_q;
  logic [Sets-1:0] used_q;  // once
  logic [Sets-1:0][WayWidth-1:0] used_way_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      is_pinned_q <= '0;
      waits_q     <= '0;
      asked_q     <= '0;
      good_q      <= '0;
      replaced_q  <= '0;
      forgotten_q <= '0;
      used_q      <= '0;
    end else begin
      asked_q <= waits_q;
      if (fill_i) begin
        waits_q[fill_set_i][fill_way_i] <= 1'b0;
        good_q[fill_set_i][fill_way_i]  <= fill_good_i;
      end
      if (unpin_i) is_pinned_q[unpin_set_i][unpin_way_i] <= 1'b0;
      if (alloc_i) begin
        is_pinned_q[set][victim_way_o] <= 1'b1;
        waits_q[set][victim_way_o]     <= 1'b1;
        good_q[set][victim_way_o]      <= 1'b0;
        replaced_q[set][victim_way_o]  <= good_q[set][victim_way_o];
      end
      if (flush_i) begin
        good_q      <= '0;
        forgotten_q <= good_q;
      end
      if (touch_i || alloc_i) used_q[set] <= 1'b1;
    end
    if (alloc_i) lines_q[set][victim_way_o] <= line_i;
    if (touch_i || alloc_i) used_way_q[set] <= touch_i ? hit_way_o : victim_way_o;
  end

  // Widths of ports are 1 or more, yet there may be one set, way or word: `ti_ra` and its rows name what there is.
  logic place_exists, unpin_exists, read_exists;
  assign place_exists = 32'(fill_set_i) < Sets && 32'(fill_way_i) < Ways &&
      32'(write_index_i) < Words;
  assign unpin_exists = 32'(unpin_set_i) < Sets && 32'(unpin_way_i) < Ways;
  assign read_exists = 32'(read_set_i) < Sets && 32'(read_way_i) < Ways &&
      32'(read_index_i) < Words;
  `TI_ASSUME(LooksUpWhatExists, lookup_en_i -> 32'(lookup_set_i) < Sets)
  `TI_ASSUME(WritesWhatExists, write_i -> place_exists)
  `TI_ASSUME(UnpinsWhatExists, unpin_i -> unpin_exists)
  `TI_ASSUME(ReadsWhatExists, read_en_i -> read_exists)

  // Memory answers a cycle after it is asked or later, and `ti_ra_rows` takes an answer that is awaited, once.
  `TI_ASSUME(WritesWhatIsAwaited,
             write_i -> waits_q[fill_set_i][fill_way_i] && asked_q[fill_set_i][fill_way_i])
  `TI_ASSUME(FillsWithItsLastWord, fill_i -> write_i)
  // A row hands out its last ray, after its line has come.
  `TI_ASSUME(UnpinsOnceAfterItsFill,
             unpin_i -> is_pinned_q[unpin_set_i][unpin_way_i] && !waits_q[unpin_set_i][unpin_way_i])
  // A ray whose line is on its way joins its row.
  logic [Ways-1:0] had, holds, on_its_way;
  for (genvar w = 0; w < Ways; w++) begin : gen_way
    assign had[w]        = lines_q[set][w] == line_i;
    assign holds[w]      = good_q[set][w] && had[w];
    assign on_its_way[w] = waits_q[set][w] && had[w];
  end
  `TI_ASSUME(NeverAsksTwice, alloc_i -> on_its_way == '0)
  // `FlushedOnlyIdle` of `ti_ra`.
  `TI_ASSUME(FlushedOnlyIdle, flush_i -> is_pinned_q == '0 && !reads_q && !stands_q && !lookup_en_i)

  // ---- Look-ups.
  logic [Ways-1:0] free, empty;
  logic all_stay;  // no place is empty or pinned
  assign all_stay = Ways > 1 && free == '1 && empty == '0;
  assign free = ~is_pinned_q[set];
  assign empty = free & ~good_q[set];
  `TI_ASSERT(HitsWhatIsHere, stands_q -> hit_o == (holds != '0))
  `TI_ASSERT(HitsWhereItIs, stands_q && hit_o -> holds[hit_way_o])
  `TI_ASSERT(InOneWay, stands_q -> $onehot0(holds))
  `TI_ASSERT(VictimWheneverOneIsFree, stands_q -> victim_valid_o == (free != '0))
  `TI_ASSERT(VictimNeverPinned, stands_q && victim_valid_o -> free[victim_way_o])
  `TI_ASSERT(VictimEmptyIfOneIs, stands_q && empty != '0 -> empty[victim_way_o])
  `TI_ASSERT(VictimNotTheOneUsedLast,
             stands_q && all_stay && used_q[set] -> victim_way_o != used_way_q[set])

  // ---- Words: one, whichever, as it is written, and as it was when it was read last.
  set_t its_set;
  way_t its_way;
  logic [IndexWidth-1:0] its_index;
  `TI_SYMBOL(its_set)
  `TI_SYMBOL(its_way)
  `TI_SYMBOL(its_index)
  InTheMemory :
  assume property (@(posedge clk_i)
      (32'(its_set) < Sets && 32'(its_way) < Ways && 32'(its_index) < Words));
  logic its_write, its_read, written_q, read_q;
  logic [WordWidth-1:0] stored_q, word_q;
  assign its_write = write_i && fill_set_i == its_set && fill_way_i == its_way &&
      write_index_i == its_index;
  assign its_read = read_en_i && read_set_i == its_set && read_way_i == its_way &&
      read_index_i == its_index;
  always_ff @(posedge clk_i) begin
    if (its_write) stored_q <= write_word_i;
    if (read_en_i) word_q <= stored_q;
    if (!rst_ni) begin
      written_q <= 1'b0;
      read_q    <= 1'b0;
    end else begin
      if (its_write) written_q <= 1'b1;
      // What is read as it is written is anything.
      if (read_en_i) read_q <= its_read && written_q && !its_write;
    end
  end
  `TI_ASSERT(WordAsWritten, read_q -> word_o == word_q)

  `TI_COVER(HitsBehindAnotherLine, touch_i && replaced_q[set][hit_way_o])
  `TI_COVER(AllPinned, stands_q && !hit_o && !victim_valid_o)
  `TI_COVER(AskedAgainAfterAnError,
            Ways == 1 || (alloc_i && (is_pinned_q[set] & ~waits_q[set]) != '0 && good_q[set] == '0))
  `TI_COVER(ForgottenByAFlush, alloc_i && (forgotten_q[set] & had) != '0)
  `TI_COVER(ReadsAWord, read_q && $past(its_write))
endmodule : ti_l1_formal

bind ti_l1 ti_l1_formal #(
  .Ways         (Ways),
  .Sets         (Sets),
  .LineAddrWidth(LineAddrWidth),
  .WordWidth    (8 * WordBytes),
  .Words        (Words),
  .Compare      (Compare)
) u_formal (.*);
