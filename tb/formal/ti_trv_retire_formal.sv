// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// Each ray that ends leaves `ti_trv_retire` once, as a hit of its number, status and steps and of its slot's best, or
/// as a miss, 2 cycles later when none waits before it.  The slot is free then and not before, and of the two kinds of
/// ends none waits for two of the other in a row.
module ti_trv_retire_formal #(
  parameter int unsigned NumSlots = 2
) (
  input logic                          clk_i,
  input logic                          rst_ni,
  input logic                          start_i,
  input ti_pkg::trv_slot_t             start_slot_i,
  input logic                   [31:0] start_ray_id_i,
  input logic                          start_any_hit_i,
  input logic                          park_i,
  input logic                          done_i,
  input ti_pkg::trv_slot_t             stop_slot_i,
  input ti_pkg::steps_t                stop_steps_i,
  input ti_pkg::status_e               done_status_i,
  input logic                          ended_i,
  input ti_pkg::trv_slot_t             ended_slot_i,
  input logic                          ended_error_i,
  input logic                          final_read_o,
  input ti_pkg::trv_slot_t             final_slot_o,
  input ti_traverse_pkg::best_t        final_i,
  input logic                          hit_valid_o,
  input logic                          hit_ready_i,
  input ti_pkg::hit_t                  hit_data_o,
  input logic                          free_o,
  input ti_pkg::trv_slot_t             free_slot_o
);
  `TI_STARTS_IN_RESET

  // Where the ray of each slot is.
  typedef enum logic [2:0] {
    Free,
    Walks,
    Parks,  // out with the tests of a leaf
    Ended,  // waits here, of the kind that a leaf has ended
    Done,   // of the kind whose walk has ended
    Read    // its hit is at the output
  } where_e;
  logic [NumSlots-1:0] starts, parks, dones, ends, reads, frees;
  logic [NumSlots-1:0] is_free, walks, is_parked, is_ended, is_done, is_read, waited_q;
  assign starts = start_i ? NumSlots'(1) << start_slot_i : '0;
  assign parks  = park_i ? NumSlots'(1) << stop_slot_i : '0;
  assign dones  = done_i ? NumSlots'(1) << stop_slot_i : '0;
  assign ends   = ended_i ? NumSlots'(1) << ended_slot_i : '0;
  assign reads  = final_read_o ? NumSlots'(1) << final_slot_o : '0;
  assign frees  = free_o ? NumSlots'(1) << free_slot_o : '0;
  logic [NumSlots-1:0] resumes;  // whatever goes on after a leaf
  for (genvar s = 0; s < NumSlots; s++) begin : gen_slot
    where_e where_q;
    assign is_free[s]   = where_q == Free;
    assign walks[s]     = where_q == Walks;
    assign is_parked[s] = where_q == Parks;
    assign is_ended[s]  = where_q == Ended;
    assign is_done[s]   = where_q == Done;
    assign is_read[s]   = where_q == Read;
    always_ff @(posedge clk_i) begin
      if (!rst_ni) where_q <= Free;
      else if (starts[s]) where_q <= Walks;
      else if (parks[s]) where_q <= Parks;
      else if (dones[s]) where_q <= Done;
      else if (ends[s]) where_q <= Ended;
      else if (reads[s]) where_q <= Read;
      else if (frees[s]) where_q <= Free;
      else if (is_parked[s] && resumes[s]) where_q <= Walks;
    end
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni) waited_q <= '0;
    else waited_q <= (is_ended | is_done | is_read) & ~frees;
  end

  // One slot, whichever: its ray.
  ti_pkg::trv_slot_t who;
  `TI_SYMBOL(who)
  WhoExists :
  assume property (@(posedge clk_i) (32'(who) < NumSlots));
  logic [31:0] ray_id_q;
  logic any_hit_q;
  ti_pkg::steps_t steps_q;
  ti_pkg::status_e status_q;
  always_ff @(posedge clk_i) begin
    if (starts[who]) begin
      ray_id_q  <= start_ray_id_i;
      any_hit_q <= start_any_hit_i;
    end
    if (parks[who] || dones[who]) steps_q <= stop_steps_i;
    if (dones[who]) status_q <= done_status_i;
    if (ends[who]) status_q <= ended_error_i ? ti_pkg::MemoryError : ti_pkg::Ok;
  end

  // ---- What the caller gives.
  logic stop_exists;
  assign stop_exists = !(park_i || done_i) || (parks | dones) != '0;
  // `ti_slot_pool` gives a slot to one ray until it is freed; `ti_kd_walk` stops the walk of a ray once;
  // `ti_trv_return` ends one whose leaf's tests are back.
  `TI_ASSUME(StartsWhenFree, (starts & ~is_free) == '0)
  `TI_ASSUME(StopsAWalk, ((parks | dones) & ~walks) == '0)
  `TI_ASSUME(EndsBehindALeaf, (ends & ~is_parked) == '0)
  `TI_ASSUME(SlotsExist, (start_i -> starts != '0) && (ended_i -> ends != '0) && stop_exists)
  // `ti_trv_best` gives the best of the slot that was read last.
  `TI_ASSUME(BestStays, $past(rst_ni && !final_read_o) -> $stable(final_i))

  // ---- A hit of each ray, once.
  logic is_who, reports;
  assign is_who  = hit_valid_o && is_read[who];
  assign reports = final_i.hit && status_q == ti_pkg::Ok;
  logic [3*ti_num_pkg::FpWidth+31:0] place, best;
  assign place = {hit_data_o.t, hit_data_o.u, hit_data_o.v, hit_data_o.prim};
  assign best  = {final_i.t, final_i.u, final_i.v, final_i.prim};
  `TI_ASSERT(ReadsWhoWaits, (reads & ~(is_ended | is_done)) == '0)
  `TI_ASSERT(HitOfWhoWasRead, $onehot0(is_read) && hit_valid_o == (is_read != '0))
  `TI_ASSERT(FreeWithItsHit, free_o == (hit_valid_o && hit_ready_i) && (frees & ~is_read) == '0)
  `TI_ASSERT(WorksWhileOneWaits, waited_q != '0 -> hit_valid_o)
  `TI_ASSERT(NumberOfTheRay, is_who -> hit_data_o.ray_id == ray_id_q)
  `TI_ASSERT(HowItEnded, is_who -> hit_data_o.status == status_q && hit_data_o.steps == steps_q)
  `TI_ASSERT(HitUnlessItFailed, is_who -> hit_data_o.hit == reports)
  `TI_ASSERT(MissIsFar,
             is_who && !reports -> hit_data_o.t == ti_num_pkg::Inf && hit_data_o.prim == '1)
  `TI_ASSERT(BestOfTheRay, is_who && reports && !any_hit_q -> place == best)
  `TI_ASSERT(NoPlaceOtherwise,
             is_who && !(reports && !any_hit_q) -> hit_data_o.u == '0 && hit_data_o.v == '0)

  // ---- In turn: what was read last, and whether one of the other kind waited then.
  logic last_done_q, other_waits_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      other_waits_q <= 1'b0;
    end else if (final_read_o) begin
      last_done_q   <= is_done[final_slot_o];
      other_waits_q <= (is_done[final_slot_o] ? is_ended : is_done) != '0;
    end
  end
  `TI_ASSERT(ThenTheOtherKind,
             final_read_o && other_waits_q -> is_done[final_slot_o] == !last_done_q)

  `TI_COVER(EndsAfterItsSecondLeaf, is_who && reports && $past(is_ended[who]) && steps_q != '0)
  `TI_COVER(OneOfEachKind, final_read_o && other_waits_q && last_done_q)
  `TI_COVER(AnyHitRay, is_who && reports && any_hit_q)
endmodule : ti_trv_retire_formal

// What is moved and not looked at has one bit, repeated.
module ti_trv_retire_top #(
  parameter int unsigned NumSlots = 2
) (
  input  logic                    clk_i,
  input  logic                    rst_ni,
  input  logic                    start_i,
  input  ti_pkg::trv_slot_t       start_slot_i,
  input  logic                    ray_id_i,
  input  logic                    start_any_hit_i,
  input  logic                    park_i,
  input  logic                    done_i,
  input  ti_pkg::trv_slot_t       stop_slot_i,
  input  logic                    steps_i,
  input  ti_pkg::status_e         done_status_i,
  input  logic                    ended_i,
  input  ti_pkg::trv_slot_t       ended_slot_i,
  input  logic                    ended_error_i,
  output logic                    final_read_o,
  output ti_pkg::trv_slot_t       final_slot_o,
  input  logic                    best_hit_i,
  input  logic              [3:0] best_i,
  output logic                    hit_valid_o,
  input  logic                    hit_ready_i,
  output ti_pkg::hit_t            hit_data_o,
  output logic                    free_o,
  output ti_pkg::trv_slot_t       free_slot_o
);
  ti_trv_retire #(
    .NumSlots(NumSlots)
  ) u_unit (
    .final_i(
    '{
        hit: best_hit_i,
        t: {ti_num_pkg::FpWidth{best_i[0]}},
        u: {ti_num_pkg::FpWidth{best_i[1]}},
        v: {ti_num_pkg::FpWidth{best_i[2]}},
        prim: {32{best_i[3]}}
    }
    ),
    .start_ray_id_i({32{ray_id_i}}),
    .stop_steps_i({$bits(ti_pkg::steps_t) {steps_i}}),
    .*
  );
endmodule : ti_trv_retire_top

bind ti_trv_retire ti_trv_retire_formal #(.NumSlots(NumSlots)) u_formal (.*);
