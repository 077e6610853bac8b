// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The best hit of each slot.  2 CMP, with `CmpStages` 3.
///
/// A token a cycle, the same slot in a row included; never stalls.  A hit counts when tmin <= t and (t, prim) is
/// less than the best so far, which starts as (the ray's tmax, no primitive).  Both comparisons are made side by
/// side, `1 + CmpStages` cycles after the token; a cycle later stands what has become of the best.  A token behind
/// others of its slot takes their result, as the memory does not have it yet; with a stage in front of the
/// comparisons that choice is made there, and one behind them drives the memories.  The token right in front of one is
/// then decided only as that one is compared, so it is compared with both: 3 CMP.
module ti_trv_best #(
  parameter  int unsigned NumSlots  = 8,
  /// Register stages in front of the comparisons, 0 or 1.
  parameter  int unsigned CmpStages = ti_fp_pkg::CmpLatency,
  localparam int unsigned Latency   = 2 + CmpStages
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

  // A token, and the best of its slot before it.
  typedef struct packed {
    slot_t     slot;
    accepted_t token;
    fp_t       tmin;
    logic      had_hit;
    key_t      best;
  } compared_t;

  logic [NumSlots-1:0] has_hit_q;

  // The token whose slot has been read.
  logic hit_q, had_hit_q;
  slot_t slot_q;
  accepted_t token_q;
  interval_t interval;
  key_t key_ram;
  compared_t merged;

  // The token that is compared, whether it is less than the best, which may be the token in front of it; the one that
  // is kept if it was taken, and the one before that.
  logic at_hit, take, keep, kept_last_q, less, front_is_best;
  compared_t at;
  slot_t kept_slot;
  accepted_t kept;
  key_t last_q;

  logic token_slot_has_hit, same_slot_q, take_last, in_range, lower, equal, less_than_best;
  slot_t token_slot;
  assign token_slot = token_data_i.home.slot;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      hit_q       <= 1'b0;
      kept_last_q <= 1'b0;
    end else begin
      hit_q       <= token_i && token_data_i.hit;
      kept_last_q <= keep;
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
    same_slot_q <= token_slot == kept_slot;
    last_q      <= kept.key;
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
    .write_en_i  (keep),
    .write_addr_i(kept_slot),
    .write_data_i(kept.key)
  );

  // The best so far: what was written while the slot was read, what stands in memory, or nothing.
  assign take_last = same_slot_q && kept_last_q;
  always_comb begin
    merged = '{
        slot: slot_q,
        token: token_q,
        tmin: interval.tmin,
        had_hit: take_last || had_hit_q,
        best: '{t: interval.tmax, prim: ti_pkg::NoPrim}
    };
    if (take_last) merged.best = last_q;
    else if (had_hit_q) merged.best = key_ram;
  end

  if (CmpStages == 0) begin : gen_at_once
    assign at_hit        = hit_q;
    assign at            = merged;
    assign keep          = take;
    assign kept_slot     = at.slot;
    assign kept          = at.token;
    assign front_is_best = 1'b0;
    assign less          = less_than_best;
  end else begin : gen_later
    // Two tokens are in front of the one that is merged: one that is compared, one that is written if it was taken.
    logic at_hit_q, keep_q, same_as_kept_q, same_as_front_q, take_kept, less_than_front;
    compared_t at_q;
    slot_t kept_slot_q;
    accepted_t kept_q;
    assign take_kept = keep_q && same_as_kept_q;
    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) begin
        at_hit_q <= 1'b0;
        keep_q   <= 1'b0;
      end else begin
        at_hit_q <= hit_q;
        keep_q   <= take;
      end
    end
    always_ff @(posedge clk_i) begin
      same_as_kept_q  <= token_slot == at_q.slot;
      same_as_front_q <= slot_q == at_q.slot;
      kept_slot_q     <= at_q.slot;
      kept_q          <= at_q.token;
      at_q            <= merged;
      at_q.had_hit    <= merged.had_hit || take_kept;
      if (take_kept) at_q.best <= kept_q.key;
    end

    logic lower_than_front, equal_to_front;
    ti_fp_cmp #(
      .ExpBits (ti_num_pkg::ExpBits),
      .FracBits(ti_num_pkg::FracBits)
    ) u_front (
      .a_i(at_q.token.key.t),
      .b_i(kept_q.key.t),
      .lt_o(lower_than_front),
      .eq_o(equal_to_front),
      .le_o(),
      .unordered_o()
    );
    assign less_than_front = lower_than_front ||
        (equal_to_front && at_q.token.key.prim < kept_q.key.prim);
    assign at_hit = at_hit_q;
    assign at = at_q;
    assign keep = keep_q;
    assign kept_slot = kept_slot_q;
    assign kept = kept_q;
    assign front_is_best = keep_q && same_as_front_q;
    assign less = front_is_best ? less_than_front : less_than_best;
  end

  ti_fp_cmp #(
    .ExpBits (ti_num_pkg::ExpBits),
    .FracBits(ti_num_pkg::FracBits)
  ) u_tmin (
    .a_i(at.tmin),
    .b_i(at.token.key.t),
    .lt_o(),
    .eq_o(),
    .le_o(in_range),
    .unordered_o()
  );
  ti_fp_cmp #(
    .ExpBits (ti_num_pkg::ExpBits),
    .FracBits(ti_num_pkg::FracBits)
  ) u_best (
    .a_i(at.token.key.t),
    .b_i(at.best.t),
    .lt_o(lower),
    .eq_o(equal),
    .le_o(),
    .unordered_o()
  );
  assign less_than_best = lower || (equal && at.token.key.prim < at.best.prim);
  assign take = at_hit && in_range && less;

  always_ff @(posedge clk_i) begin
    after_hit_o <= take || front_is_best || at.had_hit;
    if (take) after_t_o <= at.token.key.t;
    else after_t_o <= front_is_best ? kept.key.t : at.best.t;
    if (keep) has_hit_q[kept_slot] <= 1'b1;
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
    .write_en_i  (keep),
    .write_addr_i(kept_slot),
    .write_data_i(kept.key.t)
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
    .write_en_i  (keep),
    .write_addr_i(kept_slot),
    .write_data_i(kept)
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

  // No slot is read that has a token on its way: read, compared or written.
  `TI_ASSERT(StepMeetsNoTokenRead, !(tbest_read_i && hit_q && tbest_slot_i == slot_q))
  `TI_ASSERT(StepMeetsNoTokenCompared, !(tbest_read_i && at_hit && tbest_slot_i == at.slot))
  `TI_ASSERT(StepMeetsNoTokenWritten, !(tbest_read_i && keep && tbest_slot_i == kept_slot))
  `TI_ASSERT(RetirementMeetsNoTokenRead, !(final_read_i && hit_q && final_slot_i == slot_q))
  `TI_ASSERT(RetirementMeetsNoTokenCompared, !(final_read_i && at_hit && final_slot_i == at.slot))
  `TI_ASSERT(RetirementMeetsNoTokenWritten, !(final_read_i && keep && final_slot_i == kept_slot))
  `TI_COVER(SameSlotInARow, hit_q && take_last)

endmodule : ti_trv_best
