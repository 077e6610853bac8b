// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_trv_best` keeps of each slot the least (t, primitive) of all hits that came since its ray did and whose t is in
/// the ray's interval, both ends included; it says so `Latency` cycles after each token, and whenever it is read.
module ti_trv_best_formal #(
  parameter int unsigned NumSlots = 2,
  parameter int unsigned CmpStages = 0,
  localparam int unsigned W = ti_num_pkg::FpWidth
) (
  input logic                                  clk_i,
  input logic                                  rst_ni,
  input logic                                  start_i,
  input ti_pkg::trv_slot_t                     start_slot_i,
  input ti_pkg::fp_t                           start_tmin_i,
  input ti_pkg::fp_t                           start_tmax_i,
  input logic                                  token_i,
  input ti_pkg::return_t                       token_data_i,
  input logic                                  after_hit_o,
  input ti_pkg::fp_t                           after_t_o,
  input logic                                  tbest_read_i,
  input ti_pkg::trv_slot_t                     tbest_slot_i,
  input ti_pkg::fp_t                           tbest_o,
  input logic                                  final_read_i,
  input ti_pkg::trv_slot_t                     final_slot_i,
  input ti_traverse_pkg::best_t                final_o,
  // What stands in the memories.
  input logic                   [NumSlots-1:0] has_hit_q,
  input logic                   [     2*W-1:0] intervals   [NumSlots],
  input logic                   [      W+31:0] keys        [NumSlots],
  input logic                   [    3*W+31:0] finals      [NumSlots],
  input ti_pkg::fp_t                           tbest_hits  [NumSlots],
  input ti_pkg::fp_t                           tbest_starts[NumSlots]
);
  `TI_STARTS_IN_RESET

  localparam int unsigned Latency = 2 + CmpStages;
  localparam int unsigned Written = 2 + 2 * CmpStages;  // cycles from a token to the memories
  localparam int unsigned M = ti_num_pkg::FracBits;

  // Sizes of numbers are in the order of their bits.
  function automatic logic signed [W:0] value(ti_pkg::fp_t a);
    logic signed [W:0] size;
    size = (W + 1)'(a[W-2:0]);
    if (ti_fp_pkg::Flush && a[W-2:M] == '0) size = '0;
    return a[W-1] ? -size : size;
  endfunction
  function automatic logic is_nan(ti_pkg::fp_t a);
    return a[W-2:0] > ti_num_pkg::Inf[W-2:0];
  endfunction

  // One slot, whichever: its ray, and the best of the tokens so far.
  ti_pkg::trv_slot_t who;
  `TI_SYMBOL(who)
  logic starts, comes, reads_t, reads_final;
  assign starts      = start_i && start_slot_i == who;
  assign comes       = token_i && token_data_i.home.slot == who;
  assign reads_t     = tbest_read_i && tbest_slot_i == who;
  assign reads_final = final_read_i && final_slot_i == who;

  logic here_q;  // a ray has taken the slot
  ti_pkg::fp_t tmin_q, tmax_q;
  ti_traverse_pkg::best_t start_best, best_q, best;
  logic nan, in_range, less;
  assign nan = is_nan(token_data_i.t) || is_nan(tmin_q) || is_nan(best_q.t);
  assign in_range = value(tmin_q) <= value(token_data_i.t);
  assign less = value(
      token_data_i.t
  ) < value(
      best_q.t
  ) || (value(
      token_data_i.t
  ) == value(
      best_q.t
  ) && token_data_i.prim < best_q.prim);
  assign start_best = '{hit: 1'b0, t: start_tmax_i, u: '0, v: '0, prim: ti_pkg::NoPrim};
  always_comb begin
    best = best_q;
    if (comes && token_data_i.hit && !nan && in_range && less) begin
      best = '{
          hit: 1'b1,
          t: token_data_i.t,
          u: token_data_i.u,
          v: token_data_i.v,
          prim: token_data_i.prim
      };
    end
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni) here_q <= 1'b0;
    else if (starts) here_q <= 1'b1;
    best_q <= best;
    if (starts) begin
      tmin_q <= start_tmin_i;
      best_q <= start_best;
      tmax_q <= start_tmax_i;
    end
  end

  // What was so before this cycle's token, the one before, and so on; and whether there was one.
  ti_traverse_pkg::best_t [Written:1] after_q;
  logic [Written:1] came_q;
  always_ff @(posedge clk_i) begin
    came_q  <= rst_ni ? Written'({came_q, comes}) : '0;
    after_q <= {after_q[Written-1:1], best};
    if (starts) after_q <= {Written{start_best}};
  end

  // What was so when it was read.
  logic read_t_q, read_final_q;
  ti_pkg::fp_t t_q;
  ti_traverse_pkg::best_t final_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      read_t_q     <= 1'b0;
      read_final_q <= 1'b0;
    end else begin
      read_t_q     <= reads_t;
      read_final_q <= reads_final || (read_final_q && !final_read_i);
    end
    t_q <= best_q.t;
    if (reads_final) final_q <= best_q;
  end

  // ---- What the caller gives.
  // Tokens are of the ray's leaves: `ti_trv` sends leaves of rays that are here, and they come back once each.
  `TI_ASSUME(TokenOfARay, comes -> here_q)
  // A slot is given away when its hit is taken, which is read when all of its tokens are in (`ti_trv_return`).
  `TI_ASSUME(StartsBehindItsTokens, starts -> !comes && came_q == '0)
  // A ray is read when it takes a step and when it has ended, after it came, with no token on its way, as assertions
  // of the RTL say too.
  `TI_ASSUME(StepOfARay, reads_t -> here_q && !starts && !comes && came_q[Written-1:1] == '0)
  `TI_ASSUME(EndOfARay, reads_final -> here_q && !starts && !comes && came_q[Written-1:1] == '0)
  // `ti_rd` lets no NaN in (rule 3).
  `TI_ASSUME(IntervalOfNumbers, starts -> !is_nan(start_tmin_i) && !is_nan(start_tmax_i))

  `TI_ASSERT(SaysWhetherThereIsAHit, came_q[Latency] -> after_hit_o == after_q[Latency].hit)
  `TI_ASSERT(SaysTheBestT, came_q[Latency] -> after_t_o == after_q[Latency].t)
  `TI_ASSERT(StepSeesTheBestT, read_t_q -> tbest_o == t_q)
  `TI_ASSERT(EndSeesTheHit, read_final_q -> final_o.hit == final_q.hit)
  `TI_ASSERT(EndSeesTheBest, read_final_q && final_q.hit -> final_o == final_q)

  // ---- What stands in the memories: the best without the tokens that are on their way.
  ti_traverse_pkg::best_t old;
  assign old = after_q[Written];
  `TI_ASSERT(NoneAtFirst,
             here_q && !best_q.hit -> best_q.t == tmax_q && best_q.prim == ti_pkg::NoPrim)
  `TI_ASSERT(IntervalStands, here_q -> intervals[who] == {tmin_q, tmax_q})
  `TI_ASSERT(TmaxStands, here_q -> tbest_starts[who] == tmax_q)
  `TI_ASSERT(HitStands, here_q -> has_hit_q[who] == old.hit)
  `TI_ASSERT(KeyStands, here_q && old.hit -> keys[who] == {old.t, old.prim})
  `TI_ASSERT(BestTStands, here_q && old.hit -> tbest_hits[who] == old.t)
  `TI_ASSERT(BestStands, here_q && old.hit -> finals[who] == {old.t, old.prim, old.u, old.v})

  // The token just before was the best, and this one has the same t and a lower number.
  logic tie_in_a_row, hit_before_q;
  assign tie_in_a_row = came_q[1] && best_q.hit && best.prim < best_q.prim && best.t == best_q.t;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) hit_before_q <= 1'b0;
    else if (starts) hit_before_q <= here_q && best_q.hit;
  end
  `TI_COVER(TieInARow, tie_in_a_row)
  `TI_COVER(EndSeesAHit, read_final_q && final_q.hit)
  `TI_COVER(NoHitOfTheRayBefore, read_t_q && !best_q.hit && hit_before_q)
endmodule : ti_trv_best_formal

// Numbers of primitives have two bits; u and v, which are moved and not looked at, one each.
module ti_trv_best_top #(
  parameter int unsigned CmpStages = 0
) (
  input  logic                         clk_i,
  input  logic                         rst_ni,
  input  logic                         start_i,
  input  ti_pkg::trv_slot_t            start_slot_i,
  input  ti_pkg::fp_t                  start_tmin_i,
  input  ti_pkg::fp_t                  start_tmax_i,
  input  logic                         token_i,
  input  ti_pkg::trv_slot_t            slot_i,
  input  logic                         hit_i,
  input  logic                   [1:0] prim_i,
  input  ti_pkg::fp_t                  t_i,
  input  logic                         u_i,
  input  logic                         v_i,
  input  logic                         tbest_read_i,
  input  ti_pkg::trv_slot_t            tbest_slot_i,
  input  logic                         final_read_i,
  input  ti_pkg::trv_slot_t            final_slot_i,
  output ti_traverse_pkg::best_t       final_o
);
  ti_trv_best #(
    .NumSlots (2 ** $bits(ti_pkg::trv_slot_t)),
    .CmpStages(CmpStages)
  ) u_unit (
    .token_data_i(
    '{
        home: '{trv: '0, slot: slot_i},
        count: 16'd1,
        error: 1'b0,
        hit: hit_i,
        prim: 32'(prim_i),
        t: t_i,
        u: {ti_num_pkg::FpWidth{u_i}},
        v: {ti_num_pkg::FpWidth{v_i}}
    }
    ),
    .after_hit_o(),
    .after_t_o(),
    .tbest_o(),
    .*
  );
endmodule : ti_trv_best_top

bind ti_trv_best ti_trv_best_formal #(
  .NumSlots (NumSlots),
  .CmpStages(CmpStages)
) u_formal (
  .intervals   (u_interval.mem_q),
  .keys        (u_key.mem_q),
  .finals      (u_final.mem_q),
  .tbest_hits  (u_tbest_hit.mem_q),
  .tbest_starts(u_tbest_start.mem_q),
  .*
);
