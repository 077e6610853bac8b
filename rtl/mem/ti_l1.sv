// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The line store of a `ti_ra`: tags, lines, choice of a victim.  It knows nothing of who waits.
///
/// A look-up takes 2 cycles, with `Compare` 3.  `lookup_en_i` reads the tags of a set; `Compare` compares them with
/// `compare_line_i` in the cycle of `compare_en_i`, the next one or later; from the cycle after, `hit_o`, `hit_way_o`
/// and `victim_*_o` speak of `line_i`, which the caller holds still until it uses them.  `read_en_i` then reads a word of a line,
/// which stands in `word_o` from the cycle after until the next read.
///
/// `alloc_i` reserves the victim's place for `line_i`: its old line is forgotten and the place is
/// pinned.  `write_i` writes a word of an arrived line into a reserved place, two cycles after `alloc_i` or later; `fill_i`
/// says that it is the last one, `unpin_i` lets the place be a victim again.
/// Victims: an empty way, else the tree pseudo-LRU way, else the first that is not pinned.
/// `flush_i` forgets all lines; nothing may be pinned or looked up in its cycle, a look-up of the next one finds none.
/// Tags and lines map to block RAM; valid, pinned and LRU bits are registers, as many are read and
/// cleared at once.
module ti_l1 #(
  parameter int unsigned CacheBytes = 1024,
  parameter int unsigned Ways = 2,
  parameter int unsigned LineBytes = 64,
  /// What is read and written at once; divides LineBytes into a power of two.
  parameter int unsigned WordBytes = LineBytes,
  parameter int unsigned LineAddrWidth = 26,
  /// Tags are compared in a cycle of their own; else in the one that uses the result.
  parameter bit Compare = 1'b0,
  localparam int unsigned Sets = CacheBytes / ((Ways > 0) ? Ways * LineBytes : 1),
  localparam int unsigned SetWidth = (Sets > 1) ? $clog2(Sets) : 1,
  localparam int unsigned WayWidth = (Ways > 1) ? $clog2(Ways) : 1,
  localparam int unsigned Words = LineBytes / ((WordBytes > 0) ? WordBytes : 1),
  localparam int unsigned IndexWidth = (Words > 1) ? $clog2(Words) : 1
) (
  input logic clk_i,
  input logic rst_ni,
  input logic flush_i,

  input logic                lookup_en_i,
  input logic [SetWidth-1:0] lookup_set_i,

  // With `Compare`; a look-up is used only in the cycle in which the next one takes its place.
  input logic                     compare_en_i,
  input logic [LineAddrWidth-1:0] compare_line_i,

  input  logic [LineAddrWidth-1:0] line_i,
  output logic                     hit_o,
  output logic [     WayWidth-1:0] hit_way_o,
  output logic                     victim_valid_o,  // some way of the set is not pinned
  output logic [     WayWidth-1:0] victim_way_o,
  input  logic                     touch_i,         // the hit is used
  input  logic                     alloc_i,         // the victim's place is taken

  input logic                   write_i,
  input logic                   fill_i,         // with the last word
  input logic                   fill_good_i,    // 0: the answer was an error, nothing to keep
  input logic [   SetWidth-1:0] fill_set_i,
  input logic [   WayWidth-1:0] fill_way_i,
  input logic [ IndexWidth-1:0] write_index_i,
  input logic [8*WordBytes-1:0] write_word_i,

  input logic                unpin_i,
  input logic [SetWidth-1:0] unpin_set_i,
  input logic [WayWidth-1:0] unpin_way_i,

  input  logic                   read_en_i,
  input  logic [   SetWidth-1:0] read_set_i,
  input  logic [   WayWidth-1:0] read_way_i,
  input  logic [ IndexWidth-1:0] read_index_i,
  output logic [8*WordBytes-1:0] word_o
);

  localparam int unsigned SetBits = $clog2(Sets);
  localparam int unsigned TagWidth = LineAddrWidth - SetBits;
  localparam int Levels = $clog2(Ways);
  localparam int unsigned TreeNodes = (Ways > 1) ? Ways - 1 : 1;

  typedef logic [TagWidth-1:0] tag_t;
  typedef tag_t [Ways-1:0] tag_row_t;

  logic [SetWidth-1:0] set;
  tag_t tag;
  tag_row_t tags_ram, tags_read, tags, tags_new, tags_new_q;
  logic bypass_q;
  logic [Ways-1:0] valid_q[Sets];
  logic [Ways-1:0] pinned_q[Sets];
  logic [TreeNodes-1:0] tree_q[Sets];
  logic [Ways-1:0] same_tag, match;

  assign set = (Sets > 1) ? line_i[SetWidth-1:0] : '0;
  assign tag = tag_t'(line_i >> SetBits);

  ti_ram_1r1w #(
    .Depth ((Sets > 1) ? Sets : 2),
    .word_t(tag_row_t)
  ) u_tags (
    .clk_i,
    .read_en_i   (lookup_en_i),
    .read_addr_i (lookup_set_i),
    .read_data_o (tags_ram),
    .write_en_i  (alloc_i),
    .write_addr_i(set),
    .write_data_i(tags_new)
  );

  // A set that is written while it is read comes out as written.
  assign tags_read = bypass_q ? tags_new_q : tags_ram;

  always_comb begin
    tags_new = tags;
    tags_new[victim_way_o] = tag;
  end

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) bypass_q <= 1'b0;
    else if (lookup_en_i) bypass_q <= alloc_i && lookup_set_i == set;
  end

  always_ff @(posedge clk_i) if (alloc_i) tags_new_q <= tags_new;

  // The set that is looked up next, and a way of it that is taken in the same cycle.
  logic next_en, again;
  logic [SetWidth-1:0] next_set;
  logic [Ways-1:0] taken;
  assign again = next_set == set;
  for (genvar w = 0; w < Ways; w++) begin : gen_taken
    assign taken[w] = again && alloc_i && victim_way_o == WayWidth'(w);
  end

  if (!Compare) begin : gen_together
    assign next_en  = lookup_en_i;
    assign next_set = lookup_set_i;
    assign tags     = tags_read;
    for (genvar w = 0; w < Ways; w++) begin : gen_way
      assign same_tag[w] = tags[w] == tag;
    end
    logic unused;
    assign unused = compare_en_i ^ (^compare_line_i);
  end else begin : gen_compared
    tag_t compare_tag;
    tag_row_t tags_q;
    logic [Ways-1:0] same_tag_q;
    assign next_en     = compare_en_i;
    assign next_set    = (Sets > 1) ? compare_line_i[SetWidth-1:0] : '0;
    assign compare_tag = tag_t'(compare_line_i >> SetBits);
    for (genvar w = 0; w < Ways; w++) begin : gen_way
      always_ff @(posedge clk_i) begin
        if (compare_en_i) begin
          tags_q[w]     <= taken[w] ? tag : tags_read[w];
          same_tag_q[w] <= taken[w] ? compare_tag == tag : compare_tag == tags_read[w];
        end
      end
    end
    assign tags     = tags_q;
    assign same_tag = same_tag_q;

    `TI_ASSERT(UsedAsTheNextIsCompared, touch_i || alloc_i -> compare_en_i)
  end

  // What a use or an arrived line changes is written a cycle later: the bits of all sets are far away.
  logic update_q, update_alloc_q, update_again;
  logic [SetWidth-1:0] update_set_q;
  logic [WayWidth-1:0] update_way_q;
  logic [TreeNodes-1:0] update_tree_q, tree_after;
  logic filled_q, filled_good_q;
  logic [SetWidth-1:0] filled_set_q;
  logic [WayWidth-1:0] filled_way_q;
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      update_q <= 1'b0;
      filled_q <= 1'b0;
    end else begin
      update_q <= touch_i || alloc_i;
      filled_q <= fill_i;
    end
  end
  always_ff @(posedge clk_i) begin
    update_alloc_q <= alloc_i;
    update_set_q   <= set;
    update_way_q   <= victim_way_o;
    update_tree_q  <= tree_after;
    filled_good_q  <= fill_good_i;
    filled_set_q   <= fill_set_i;
    filled_way_q   <= fill_way_i;
  end
  assign update_again = update_q && update_set_q == next_set;

  // What is known of the set that is looked up, in registers that follow it.
  logic [Ways-1:0] set_valid_q, set_pinned_q;
  logic [TreeNodes-1:0] set_tree_q;
  always_ff @(posedge clk_i) begin
    if (next_en) begin
      if (again && (touch_i || alloc_i)) set_tree_q <= tree_after;
      else set_tree_q <= update_again ? update_tree_q : tree_q[next_set];
    end
  end
  for (genvar w = 0; w < Ways; w++) begin : gen_set
    logic fills, unpins, reserved, filled, valid;
    assign fills = fill_i && fill_way_i == WayWidth'(w);
    assign unpins = unpin_i && unpin_way_i == WayWidth'(w);
    assign reserved = taken[w] || (update_again && update_alloc_q && update_way_q == WayWidth'(w));
    assign filled = filled_q && filled_set_q == next_set && filled_way_q == WayWidth'(w);
    assign valid = filled ? filled_good_q : valid_q[next_set][w];
    always_ff @(posedge clk_i) begin
      if (next_en) begin
        set_valid_q[w] <= (fills && fill_set_i == next_set) ? fill_good_i : valid && !reserved;
        set_pinned_q[w] <= reserved ||
            (pinned_q[next_set][w] && !(unpins && unpin_set_i == next_set));
      end else begin
        if (fills && fill_set_i == set) set_valid_q[w] <= fill_good_i;
        if (unpins && unpin_set_i == set) set_pinned_q[w] <= 1'b0;
      end
    end
  end

  // Look-up.
  assign match = set_valid_q & same_tag;
  always_comb begin
    hit_o     = |match;
    hit_way_o = '0;
    for (int unsigned w = 0; w < Ways; w++) if (match[w]) hit_way_o = WayWidth'(w);
  end

  // Tree pseudo-LRU: each node points to the half used longer ago.  The victim is at the end of the pointers; the
  // nodes on the way to a way that is used point away from it afterwards.
  logic [WayWidth-1:0] lru_way, used_way;
  int unsigned victim_node, used_node;
  assign used_way = hit_o ? hit_way_o : victim_way_o;  // whether used or not

  always_comb begin
    lru_way     = '0;
    victim_node = 0;
    for (int level = 0; level < Levels; level++) begin
      lru_way = WayWidth'({lru_way, set_tree_q[victim_node]});
      victim_node = 2 * victim_node + 1 + 32'(set_tree_q[victim_node]);
    end
  end

  always_comb begin
    tree_after = set_tree_q;
    used_node  = 0;
    for (int level = 0; level < Levels; level++) begin
      tree_after[used_node] = !used_way[Levels-1-level];
      used_node = 2 * used_node + 1 + 32'(used_way[Levels-1-level]);
    end
  end

  logic [Ways-1:0] allowed;
  assign allowed        = ~set_pinned_q;
  assign victim_valid_o = |allowed;

  always_comb begin
    victim_way_o = lru_way;
    if (!allowed[lru_way]) begin
      for (int i = int'(Ways) - 1; i >= 0; i--) if (allowed[i]) victim_way_o = WayWidth'(i);
    end
    for (int i = int'(Ways) - 1; i >= 0; i--) begin
      if (allowed[i] && !set_valid_q[i]) victim_way_o = WayWidth'(i);
    end
  end

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      for (int unsigned s = 0; s < Sets; s++) begin
        pinned_q[s] <= '0;
        tree_q[s]   <= '0;
      end
    end else begin
      if (update_q) tree_q[update_set_q] <= update_tree_q;
      if (update_q && update_alloc_q) pinned_q[update_set_q][update_way_q] <= 1'b1;
      if (unpin_i) pinned_q[unpin_set_i][unpin_way_i] <= 1'b0;
    end
  end

  // With `Compare` lines are forgotten a cycle after the flush or the reset, from a register: a set is not looked up before.
  if (!Compare) begin : gen_forget
    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) begin
        for (int unsigned s = 0; s < Sets; s++) valid_q[s] <= '0;
      end else begin
        if (update_q && update_alloc_q) valid_q[update_set_q][update_way_q] <= 1'b0;
        if (filled_q) valid_q[filled_set_q][filled_way_q] <= filled_good_q;
        if (flush_i) begin
          for (int unsigned s = 0; s < Sets; s++) valid_q[s] <= '0;
        end
      end
    end
  end else begin : gen_forget_late
    logic forget_q;
    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) forget_q <= 1'b1;
      else forget_q <= flush_i;
    end
    always_ff @(posedge clk_i) begin
      if (update_q && update_alloc_q) valid_q[update_set_q][update_way_q] <= 1'b0;
      if (filled_q) valid_q[filled_set_q][filled_way_q] <= filled_good_q;
      if (forget_q) begin
        for (int unsigned s = 0; s < Sets; s++) valid_q[s] <= '0;
      end
    end
    `TI_ASSERT(ForgetsNothingNew, forget_q -> !filled_q)
    `TI_ASSERT(NothingIsFoundMeanwhile, forget_q -> !touch_i)
    `TI_ASSERT_NEXT(NothingHadBeenLookedUp, forget_q, !touch_i)
  end

  localparam int unsigned Places = Sets * Ways * Words;
  localparam int unsigned PlaceWidth = (Places > 1) ? $clog2(Places) : 1;

  logic [PlaceWidth-1:0] read_place, write_place;
  assign read_place = (PlaceWidth'(read_set_i) * PlaceWidth'(Ways) + PlaceWidth'(read_way_i)) *
      PlaceWidth'(Words) + PlaceWidth'(read_index_i);
  assign write_place = (PlaceWidth'(fill_set_i) * PlaceWidth'(Ways) + PlaceWidth'(fill_way_i)) *
      PlaceWidth'(Words) + PlaceWidth'(write_index_i);

  ti_ram_1r1w #(
    .Depth ((Places > 1) ? Places : 2),
    .word_t(logic [8*WordBytes-1:0])
  ) u_lines (
    .clk_i,
    .read_en_i,
    .read_addr_i (read_place),
    .read_data_o (word_o),
    .write_en_i  (write_i),
    .write_addr_i(write_place),
    .write_data_i(write_word_i)
  );

  if (Ways < 1 || (Ways & (Ways - 1)) != 0) begin : gen_check_ways
    $error("ti_l1: Ways must be a power of two");
  end
  if (Sets < 1 || (Sets & (Sets - 1)) != 0 ||
      Sets * Ways * LineBytes != CacheBytes) begin : gen_check_cache_bytes
    $error("ti_l1: CacheBytes must be Ways * LineBytes times a power of two");
  end
  if (Words * WordBytes != LineBytes || (Words & (Words - 1)) != 0) begin : gen_check_word_bytes
    $error("ti_l1: WordBytes must divide LineBytes into a power of two");
  end
  if (LineAddrWidth <= SetBits) begin : gen_check_line_addr_width
    $error("ti_l1: LineAddrWidth must be more than the bits of the number of a set");
  end

  // Of a look-up that is used: behind one that was, old tags may stand beside new valid bits.
  `TI_ASSERT(HitsOneWay, touch_i -> $onehot(match))
  `TI_ASSERT(AllocatesWhatMissed, alloc_i -> match == '0)
  `TI_ASSERT(WritesReserved, write_i -> pinned_q[fill_set_i][fill_way_i])
  `TI_ASSERT(FillsWithAWord, fill_i -> write_i)
  `TI_ASSERT(UnpinsPinned, unpin_i -> pinned_q[unpin_set_i][unpin_way_i])
  `TI_ASSERT(AllocatesFree, alloc_i -> victim_valid_o)
  `TI_ASSERT(UsesOneWayAtATime, !(touch_i && alloc_i))

endmodule : ti_l1
