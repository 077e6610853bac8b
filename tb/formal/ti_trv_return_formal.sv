// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

// What `ti_trv_best` assumes of its caller is asserted here.
`undef TI_ASSUME
`define TI_ASSUME(name_, prop_) `TI_ASSERT(name_, prop_)
`include "ti_trv_best_formal.sv"
`undef TI_ASSUME
`define TI_ASSUME(name_, prop_) \
    name_: assume property (@(posedge clk_i) disable iff (!rst_ni) (prop_));

/// When the last test of a leaf is back, and not before, its ray goes on in `ti_trv_return` where it was to, or ends,
/// once, `LeafLatency` cycles later.  It ends exactly when a test of the leaf failed, nothing is left, its best t is at
/// most the leaf's bound, or it is an any-hit ray with a hit.  What `ti_trv_best` assumes of its caller holds here.
module ti_trv_return_formal #(
  parameter int unsigned NumSlots  = 2,
  parameter int unsigned CmpStages = 0
) (
  input logic clk_i,
  input logic rst_ni,
  input logic start_i,
  input ti_pkg::trv_slot_t start_slot_i,
  input logic start_any_hit_i,
  input ti_pkg::fp_t start_tmin_i,
  input ti_pkg::fp_t start_tmax_i,
  input logic park_i,
  input logic done_i,
  input ti_pkg::trv_slot_t stop_slot_i,
  input ti_pkg::tri_count_t park_count_i,
  input logic park_go_i,
  input logic park_restart_i,
  input ti_pkg::node_index_t park_next_i,
  input ti_pkg::fp_t park_bound_i,
  input logic return_valid_i,
  input logic return_ready_o,
  input ti_pkg::return_t return_data_i,
  input logic resume_o,
  input ti_pkg::trv_slot_t resume_slot_o,
  input ti_pkg::node_index_t resume_node_o,
  input logic resume_restart_o,
  input logic tbest_read_i,
  input ti_pkg::trv_slot_t tbest_slot_i,
  input logic free_o,
  input ti_pkg::trv_slot_t free_slot_o,
  // To `ti_trv_retire`, and what it reads.
  input logic retires,
  input ti_pkg::trv_slot_t retires_slot,
  input logic final_read,
  input ti_pkg::trv_slot_t final_slot,
  // A slot of those of `ti_trv_best`, whichever: its ray is here, and its best.
  input ti_pkg::trv_slot_t who,
  input logic best_here,
  input ti_traverse_pkg::best_t best,
  input logic [$bits(ti_pkg::tri_count_t):0] sum,  // of the token before
  // What stands in the memories.
  input logic [NumSlots-1:0] leaf_begun_q,
  input logic [NumSlots-1:0] any_hits,
  input ti_pkg::tri_count_t sents[NumSlots],
  input logic [$bits(ti_pkg::tri_count_t):0] backs[NumSlots],
  input logic [$bits(ti_pkg::node_index_t)+ti_num_pkg::FpWidth+1:0] parkings[NumSlots]
);
  `TI_STARTS_IN_RESET

  localparam int unsigned LeafLatency = 2 + 2 * CmpStages;
  localparam int unsigned M = ti_num_pkg::FracBits;
  localparam int unsigned W = ti_num_pkg::FpWidth;
  typedef ti_pkg::tri_count_t count_t;

  function automatic logic signed [W:0] value(ti_pkg::fp_t a);
    logic signed [W:0] size;
    size = (W + 1)'(a[W-2:0]);
    if (ti_fp_pkg::Flush && a[W-2:M] == '0) size = '0;
    return a[W-1] ? -size : size;
  endfunction
  function automatic logic is_nan(ti_pkg::fp_t a);
    return a[W-2:0] > ti_num_pkg::Inf[W-2:0];
  endfunction

  // Where the ray of each slot is, and of the tests of its leaf how many it has and how many are to come.
  typedef enum logic [1:0] {
    Free,
    Walks,
    Parks,  // out with the tests of a leaf
    Ends
  } where_e;
  logic [NumSlots-1:0] is_free, walks, is_parked, ends, last;
  logic [LeafLatency:1][NumSlots-1:0] last_q;  // the last token of a leaf came so many cycles ago
  count_t [NumSlots-1:0] sent_q, left_q;
  logic [NumSlots-1:0] failed_q;
  for (genvar s = 0; s < NumSlots; s++) begin : gen_slot
    where_e where_q;
    logic starts, parks, dones, comes, goes_on, retired, freed;
    assign starts       = start_i && 32'(start_slot_i) == s;
    assign parks        = park_i && 32'(stop_slot_i) == s;
    assign dones        = done_i && 32'(stop_slot_i) == s;
    assign comes        = return_valid_i && 32'(return_data_i.home.slot) == s;
    assign goes_on      = resume_o && 32'(resume_slot_o) == s;
    assign retired      = retires && 32'(retires_slot) == s;
    assign freed        = free_o && 32'(free_slot_o) == s;
    assign is_free[s]   = where_q == Free;
    assign walks[s]     = where_q == Walks;
    assign is_parked[s] = where_q == Parks;
    assign ends[s]      = where_q == Ends;
    assign last[s]      = comes && return_data_i.count == left_q[s];
    always_ff @(posedge clk_i) begin
      if (!rst_ni) where_q <= Free;
      else if (starts || goes_on) where_q <= Walks;
      else if (parks) where_q <= Parks;
      else if (dones || retired) where_q <= Ends;
      else if (freed) where_q <= Free;
      if (parks) begin
        sent_q[s]   <= park_count_i;
        left_q[s]   <= park_count_i;
        failed_q[s] <= 1'b0;
      end else if (comes) begin
        left_q[s]   <= left_q[s] - return_data_i.count;
        failed_q[s] <= failed_q[s] || return_data_i.error;
      end
    end

    // ---- What the caller gives.
    // `ti_slot_pool` gives a slot to one ray until it is freed.
    `TI_ASSUME(StartsWhenFree, starts -> is_free[s])
    // `ti_kd_walk` stops the walk of a ray once, in a leaf that has tests.
    `TI_ASSUME(StopsAWalk, parks || dones -> walks[s])
    // Each test of a leaf comes back once, behind the leaf: `ti_list` and the IST units end each once.
    `TI_ASSUME(TokenOfItsLeaf, comes -> is_parked[s] && return_data_i.count <= left_q[s])
    // A step is that of a ray that walks.
    `TI_ASSUME(StepOfAWalk, tbest_read_i && 32'(tbest_slot_i) == s -> walks[s])
    // `ti_trv_retire` reads and frees a slot that has ended (proven there).
    `TI_ASSUME(ReadsWhoHasEnded, final_read && 32'(final_slot) == s -> ends[s])
    `TI_ASSUME(FreesWhoHasEnded, freed -> ends[s])

    // ---- A leaf comes to its end once.
    `TI_ASSERT(GoesOnOrEnds, goes_on || retired -> last_q[LeafLatency][s] && !(goes_on && retired))
    `TI_ASSERT(WhenItsTimeIsUp, last_q[LeafLatency][s] -> goes_on || retired)
    logic [LeafLatency:1] on_its_way;
    for (genvar i = 1; i <= LeafLatency; i++) begin : gen_ago
      assign on_its_way[i] = last_q[i][s];
    end
    `TI_ASSERT(ParksUntilThen, (is_parked[s] && left_q[s] == '0) == (on_its_way != '0))
    `TI_ASSERT(EndsOneLeafAtATime, $onehot0(on_its_way))

    // ---- What stands in the memories, where no token is on its way.
    logic   quiet_q;
    count_t got;
    always_ff @(posedge clk_i) quiet_q <= !(rst_ni && comes);
    assign got = sent_q[s] - left_q[s];
    `TI_ASSERT(SomeAreSent, is_parked[s] -> left_q[s] <= sent_q[s] && sent_q[s] != '0)
    `TI_ASSERT(NoneHasFailedYet, is_parked[s] && got == '0 -> !failed_q[s])
    `TI_ASSERT(SentStands, is_parked[s] -> sents[s] == sent_q[s])
    `TI_ASSERT(BegunStands,
               quiet_q -> leaf_begun_q[s] == (is_parked[s] && got != '0 && left_q[s] != '0))
    `TI_ASSERT(SumIsTheirs, !quiet_q -> sum == {failed_q[s], got})
    `TI_ASSERT(BackStands, quiet_q && leaf_begun_q[s] -> backs[s] == {failed_q[s], got})
  end
  always_ff @(posedge clk_i) last_q <= rst_ni ? {last_q[LeafLatency-1:1], last} : '0;

  `TI_ASSUME(StopsOneWay, !(park_i && done_i))
  `TI_ASSUME(LeafHasTests, park_i -> park_count_i != '0)
  `TI_ASSUME(TokenHasTests, return_valid_i -> return_data_i.count != '0)
  // `ti_rd` lets no NaN in (rule 3).
  `TI_ASSUME(NumbersOnly, start_i -> !is_nan(start_tmin_i) && !is_nan(start_tmax_i))

  // ---- Where it goes on, and what ends it.
  logic any_hit_q, go_q, restart_q;
  ti_pkg::node_index_t next_q;
  ti_pkg::fp_t bound_q;
  always_ff @(posedge clk_i) begin
    if (start_i && start_slot_i == who) any_hit_q <= start_any_hit_i;
    if (park_i && stop_slot_i == who) begin
      go_q      <= park_go_i;
      restart_q <= park_restart_i;
      next_q    <= park_next_i;
      bound_q   <= park_bound_i;
    end
  end
  logic at_end, near_enough, must_end;
  assign at_end = last_q[LeafLatency][who];
  assign near_enough = !is_nan(best.t) && !is_nan(bound_q) && value(best.t) <= value(bound_q);
  assign must_end = failed_q[who] || !go_q || near_enough || (any_hit_q && best.hit);
  `TI_ASSERT(TakesEveryToken, return_ready_o)
  `TI_ASSERT(EndsByTheRule, at_end -> (resume_o && resume_slot_o == who) == !must_end)
  `TI_ASSERT(GoesOnWhereItWasTo, at_end && !must_end -> resume_node_o == next_q)
  `TI_ASSERT(GoesOnAsItWasTo, at_end && !must_end -> resume_restart_o == restart_q)

  // ---- What stands in the memories.
  `TI_ASSERT(HereUntilFree, !is_free[who] -> best_here)
  `TI_ASSERT(AnyHitStands, !is_free[who] -> any_hits[who] == any_hit_q)
  `TI_ASSERT(ParkingStands, is_parked[who] -> parkings[who] == {restart_q, go_q, next_q, bound_q})

  `TI_COVER(TwoTokensInARow, last[who] && $past(return_valid_i && return_data_i.home.slot == who))
  `TI_COVER(EndsByItsBest, at_end && near_enough && !failed_q[who] && go_q && best.hit)
  `TI_COVER(SecondLeaf, at_end && resume_o && best.hit && sent_q[who] != 16'd1)
  `TI_COVER(AllRetire, ends == '1)
endmodule : ti_trv_return_formal

// What is moved and not looked at has one bit, repeated; counts and numbers of primitives have two bits.
module ti_trv_return_top #(
  parameter int unsigned NumSlots  = 2,
  parameter int unsigned CmpStages = 0
) (
  input logic                    clk_i,
  input logic                    rst_ni,
  input logic                    start_i,
  input ti_pkg::trv_slot_t       start_slot_i,
  input logic                    start_any_hit_i,
  input ti_pkg::fp_t             start_tmin_i,
  input ti_pkg::fp_t             start_tmax_i,
  input logic                    park_i,
  input logic                    done_i,
  input ti_pkg::trv_slot_t       stop_slot_i,
  input logic              [1:0] count_i,
  input logic                    park_go_i,
  input logic                    park_restart_i,
  input logic                    next_i,
  input ti_pkg::fp_t             park_bound_i,
  input logic                    return_valid_i,
  input ti_pkg::trv_slot_t       slot_i,
  input logic              [1:0] back_i,
  input logic                    error_i,
  input logic                    hit_i,
  input logic              [1:0] prim_i,
  input ti_pkg::fp_t             t_i,
  input logic                    tbest_read_i,
  input ti_pkg::trv_slot_t       tbest_slot_i,
  input logic                    hit_ready_i
);
  ti_trv_return #(
    .NumSlots (NumSlots),
    .CmpStages(CmpStages)
  ) u_unit (
    .start_ray_id_i('0),
    .stop_steps_i('0),
    .done_status_i(ti_pkg::Ok),
    .park_count_i(16'(count_i)),
    .park_next_i({$bits(ti_pkg::node_index_t) {next_i}}),
    .return_data_i(
    '{
        home: '{trv: '0, slot: slot_i},
        count: 16'(back_i),
        error: error_i,
        hit: hit_i,
        prim: 32'(prim_i),
        t: t_i,
        u: '0,
        v: '0
    }
    ),
    .return_ready_o(),
    .resume_o(),
    .resume_slot_o(),
    .resume_node_o(),
    .resume_restart_o(),
    .tbest_o(),
    .hit_valid_o(),
    .hit_data_o(),
    .free_o(),
    .free_slot_o(),
    .*
  );
endmodule : ti_trv_return_top

bind ti_trv_return ti_trv_return_formal #(
  .NumSlots (NumSlots),
  .CmpStages(CmpStages)
) u_formal (
  .retires     (u_retire.ended_i),
  .retires_slot(u_retire.ended_slot_i),
  .who         (u_best.u_formal.who),
  .best_here   (u_best.u_formal.here_q),
  .best        (u_best.u_formal.best_q),
  .sum         (back),
  .any_hits    (gen_any_hit.any_hit_q),
  .sents       (u_sent.mem_q),
  .backs       (u_back.mem_q),
  .parkings    (u_park.mem_q),
  .*
);
