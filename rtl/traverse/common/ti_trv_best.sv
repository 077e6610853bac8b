// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The best hit of each slot.  2 CMP.
///
/// A token a cycle, the same slot in a row included; never stalls.  A hit counts when tmin <= t and (t, prim) is
/// less than the best so far, which starts as (the ray's tmax, no primitive).  Both comparisons are made side by
/// side in the cycle after the token; 2 cycles after it stands what has become of the best.  A token that meets
/// the one before it in the same slot takes that one's result, as the memory does not have it yet.
module ti_trv_best #(
  parameter  int unsigned NumSlots = 8,
  localparam int unsigned Latency  = 2
) (
  input logic clk_i,
  input logic rst_ni,

  // A ray takes a slot.
  input logic              start_i,
  input ti_pkg::trv_slot_t start_slot_i,
  input ti_pkg::fp_t       start_tmin_i,
  input ti_pkg::fp_t       start_tmax_i,

  input logic            token_i,
  input ti_pkg::return_t token_data_i,

  // What a token leaves in its slot, `Latency` cycles after it.
  output logic        after_hit_o,
  output ti_pkg::fp_t after_t_o,    // the ray's tmax without a hit

  // The best t of a slot that has no token on its way: read one cycle ahead.
  input  logic              tbest_read_i,
  input  ti_pkg::trv_slot_t tbest_slot_i,
  output ti_pkg::fp_t       tbest_o,

  // The best hit of a slot that has no token on its way: read one cycle ahead, stays until the next read.
  input  logic                   final_read_i,
  input  ti_pkg::trv_slot_t      final_slot_i,
  output ti_traverse_pkg::best_t final_o
);

  typedef ti_pkg::trv_slot_t slot_t;
  typedef ti_pkg::fp_t fp_t;

  typedef struct packed {
    fp_t tmin;
    fp_t tmax;
  } interval_t;

  // What hits are compared by.
  typedef struct packed {
    fp_t           t;
    ti_pkg::prim_t prim;
  } key_t;

  typedef struct packed {
    key_t key;
    fp_t  u;
    fp_t  v;
  } accepted_t;

  logic [NumSlots-1:0] has_hit_q;

  // The token that is compared.
  logic hit_q;
  slot_t slot_q;
  accepted_t token_q;
  interval_t interval;
  key_t key_ram;
  // What came before it in its slot.
  logic same_slot_q, took_q, had_hit_q;
  key_t last_q;

  logic token_slot_has_hit, take_last, had_hit, in_range, less, equal, take;
  key_t  best;
  slot_t token_slot;

  assign token_slot = token_data_i.home.slot;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      hit_q  <= 1'b0;
      took_q <= 1'b0;
    end else begin
      hit_q  <= token_i && token_data_i.hit;
      took_q <= take;
    end
  end
  assign token_slot_has_hit = has_hit_q[token_slot];
  always_ff @(posedge clk_i) begin
    if (token_i) begin
      slot_q <= token_slot;
      token_q <= '{
          key: '{t: token_data_i.t, prim: token_data_i.prim},
          u: token_data_i.u,
          v: token_data_i.v
      };
      had_hit_q <= token_slot_has_hit;
    end
    same_slot_q <= token_slot == slot_q;
    last_q      <= token_q.key;
  end

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(interval_t)
  ) u_interval (
    .clk_i,
    .read_en_i   (token_i),
    .read_addr_i (token_slot),
    .read_data_o (interval),
    .write_en_i  (start_i),
    .write_addr_i(start_slot_i),
    .write_data_i('{tmin: start_tmin_i, tmax: start_tmax_i})
  );

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(key_t)
  ) u_key (
    .clk_i,
    .read_en_i   (token_i),
    .read_addr_i (token_slot),
    .read_data_o (key_ram),
    .write_en_i  (take),
    .write_addr_i(slot_q),
    .write_data_i(token_q.key)
  );

  // The best so far: what the token before has just put there, what stands in memory, or nothing.
  assign take_last = same_slot_q && took_q;
  assign had_hit   = take_last || had_hit_q;
  always_comb begin
    best = '{t: interval.tmax, prim: ti_pkg::NoPrim};
    if (take_last) best = last_q;
    else if (had_hit_q) best = key_ram;
  end

  ti_fp_cmp #(
    .ExpBits (ti_num_pkg::ExpBits),
    .FracBits(ti_num_pkg::FracBits)
  ) u_tmin (
    .a_i(interval.tmin),
    .b_i(token_q.key.t),
    .lt_o(),
    .eq_o(),
    .le_o(in_range),
    .unordered_o()
  );
  ti_fp_cmp #(
    .ExpBits (ti_num_pkg::ExpBits),
    .FracBits(ti_num_pkg::FracBits)
  ) u_best (
    .a_i(token_q.key.t),
    .b_i(best.t),
    .lt_o(less),
    .eq_o(equal),
    .le_o(),
    .unordered_o()
  );
  assign take = hit_q && in_range && (less || (equal && token_q.key.prim < best.prim));

  always_ff @(posedge clk_i) begin
    after_hit_o <= take || had_hit;
    after_t_o   <= take ? token_q.key.t : best.t;
    if (take) has_hit_q[slot_q] <= 1'b1;
    if (start_i) has_hit_q[start_slot_i] <= 1'b0;
  end

  // Copies for the step pipeline: the best t is the ray's tmax until it has a hit.
  fp_t tbest_hit, tbest_start;
  logic tbest_slot_has_hit, tbest_is_hit_q;
  assign tbest_slot_has_hit = has_hit_q[tbest_slot_i];
  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(fp_t)
  ) u_tbest_hit (
    .clk_i,
    .read_en_i   (tbest_read_i),
    .read_addr_i (tbest_slot_i),
    .read_data_o (tbest_hit),
    .write_en_i  (take),
    .write_addr_i(slot_q),
    .write_data_i(token_q.key.t)
  );
  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(fp_t)
  ) u_tbest_start (
    .clk_i,
    .read_en_i   (tbest_read_i),
    .read_addr_i (tbest_slot_i),
    .read_data_o (tbest_start),
    .write_en_i  (start_i),
    .write_addr_i(start_slot_i),
    .write_data_i(start_tmax_i)
  );
  always_ff @(posedge clk_i) begin
    if (tbest_read_i) tbest_is_hit_q <= tbest_slot_has_hit;
  end
  assign tbest_o = tbest_is_hit_q ? tbest_hit : tbest_start;

  // A copy for retirement, which so takes no token's turn.
  logic final_slot_has_hit, final_is_hit_q;
  accepted_t final_hit;
  assign final_slot_has_hit = has_hit_q[final_slot_i];
  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(accepted_t)
  ) u_final (
    .clk_i,
    .read_en_i   (final_read_i),
    .read_addr_i (final_slot_i),
    .read_data_o (final_hit),
    .write_en_i  (take),
    .write_addr_i(slot_q),
    .write_data_i(token_q)
  );
  always_ff @(posedge clk_i) begin
    if (final_read_i) final_is_hit_q <= final_slot_has_hit;
  end
  assign final_o = '{
          hit: final_is_hit_q,
          t: final_hit.key.t,
          u: final_hit.u,
          v: final_hit.v,
          prim: final_hit.key.prim
      };

  `TI_ASSERT(StepReadsNoSlotWithATokenOnItsWay, !(tbest_read_i && hit_q && tbest_slot_i == slot_q))
  `TI_ASSERT(RetirementReadsNoSlotWithATokenOnItsWay,
             !(final_read_i && hit_q && final_slot_i == slot_q))
  `TI_COVER(SameSlotInARow, hit_q && take_last)

endmodule : ti_trv_best
