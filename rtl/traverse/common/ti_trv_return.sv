// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The way home: the best hit of each slot (`ti_trv_best`), the end of leaves (here), retirement (`ti_trv_retire`).
///
/// Takes a return token in every cycle, whatever it is and whichever slot it is for.  When all tests of a leaf
/// are back, the ray ends if its best t <= the leaf's bound, if it is an any-hit ray with a hit, if memory failed,
/// or if nothing is left to visit; else it goes on, `LeafLatency` cycles after the last token.  The bound is a t below
/// which nothing of what is left to visit lies: a kd-tree gives the leaf's exit.  3 CMP, 2 of them in `ti_trv_best`.
module ti_trv_return #(
  parameter int unsigned NumSlots = 8,
  /// Whether a ray may be an any-hit ray.
  parameter bit AnyHit = 1'b1,
  /// Whether a ray may go back to the root.
  parameter bit Restart = 1'b1,
  /// Register stages beside each comparison, 0 or 1.
  parameter int unsigned CmpStages = ti_fp_pkg::CmpLatency,
  localparam int unsigned LeafLatency = 2 + 2 * CmpStages
) (
  input logic clk_i,
  input logic rst_ni,

  // A ray takes a slot.
  input logic                     start_i,
  input ti_pkg::trv_slot_t        start_slot_i,
  input logic              [31:0] start_ray_id_i,
  input logic                     start_any_hit_i,
  input ti_pkg::fp_t              start_tmin_i,
  input ti_pkg::fp_t              start_tmax_i,

  // A walk stops: in a leaf with triangles (`park_i`) or for good (`done_i`).
  input logic                park_i,
  input logic                done_i,
  input ti_pkg::trv_slot_t   stop_slot_i,
  input ti_pkg::steps_t      stop_steps_i,
  input ti_pkg::status_e     done_status_i,
  input ti_pkg::tri_count_t  park_count_i,
  input logic                park_go_i,       // there is more to visit after it
  input logic                park_restart_i,  // that is the root again
  input ti_pkg::node_index_t park_next_i,
  input ti_pkg::fp_t         park_bound_i,    // nothing after it is nearer

  input  logic            return_valid_i,
  output logic            return_ready_o,  // always
  input  ti_pkg::return_t return_data_i,

  // A slot goes on after a leaf; always accepted.
  output logic                resume_o,
  output ti_pkg::trv_slot_t   resume_slot_o,
  output ti_pkg::node_index_t resume_node_o,
  output logic                resume_restart_o,

  // The best t of a slot, for the step pipeline: read one cycle ahead.
  input  logic              tbest_read_i,
  input  ti_pkg::trv_slot_t tbest_slot_i,
  output ti_pkg::fp_t       tbest_o,

  output logic         hit_valid_o,
  input  logic         hit_ready_i,
  output ti_pkg::hit_t hit_data_o,

  output logic              free_o,      // the slot's ray has retired
  output ti_pkg::trv_slot_t free_slot_o
);

  typedef ti_pkg::trv_slot_t slot_t;
  typedef ti_pkg::fp_t fp_t;
  typedef ti_pkg::tri_count_t tri_count_t;

  typedef struct packed {
    logic       error;
    tri_count_t count;
  } back_t;

  typedef struct packed {
    logic                restart;  // kept only where a ray may restart
    logic                go;
    ti_pkg::node_index_t next;
    fp_t                 bound;
  } park_t;

  localparam int unsigned ParkWidth = $bits(park_t) - (Restart ? 0 : 1);
  typedef logic [ParkWidth-1:0] park_word_t;

  slot_t return_slot;
  assign return_ready_o = 1'b1;
  assign return_slot    = return_data_i.home.slot;

  // ---- A token: the tests of its leaf that are back, beside the best hit.
  logic token_q, same_slot_q, begun, begun_q, all_back;
  logic [NumSlots-1:0] leaf_begun_q;  // some of the leaf's tests are back
  slot_t slot_q;
  tri_count_t sent;
  back_t token_back_q, back_ram, earlier, back, last_back_q;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      token_q      <= 1'b0;
      leaf_begun_q <= '0;
    end else begin
      token_q <= return_valid_i;
      if (token_q) leaf_begun_q[slot_q] <= !all_back;
    end
  end
  assign begun = leaf_begun_q[return_slot];
  always_ff @(posedge clk_i) begin
    if (return_valid_i) begin
      slot_q       <= return_slot;
      token_back_q <= '{error: return_data_i.error, count: return_data_i.count};
      begun_q      <= begun;
    end
    same_slot_q <= token_q && return_slot == slot_q;
    last_back_q <= back;
  end

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(tri_count_t)
  ) u_sent (
    .clk_i,
    .read_en_i   (return_valid_i),
    .read_addr_i (return_slot),
    .read_data_o (sent),
    .write_en_i  (park_i),
    .write_addr_i(stop_slot_i),
    .write_data_i(park_count_i)
  );

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(back_t)
  ) u_back (
    .clk_i,
    .read_en_i   (return_valid_i),
    .read_addr_i (return_slot),
    .read_data_o (back_ram),
    .write_en_i  (token_q),
    .write_addr_i(slot_q),
    .write_data_i(back)
  );

  // A token right behind another of its slot takes the sum from there: the memory does not have it yet.
  always_comb begin
    earlier = '0;
    if (same_slot_q) earlier = last_back_q;
    else if (begun_q) earlier = back_ram;
  end
  assign back.error = earlier.error || token_back_q.error;
  assign back.count = earlier.count + token_back_q.count;
  assign all_back   = back.count == sent;

  logic has_hit, final_read;
  fp_t best_t;
  slot_t final_slot;
  ti_traverse_pkg::best_t final_best;

  ti_trv_best #(
    .NumSlots (NumSlots),
    .CmpStages(CmpStages)
  ) u_best (
    .clk_i,
    .rst_ni,
    .start_i,
    .start_slot_i,
    .start_tmin_i,
    .start_tmax_i,
    .token_i     (return_valid_i),
    .token_data_i(return_data_i),
    .after_hit_o (has_hit),
    .after_t_o   (best_t),
    .tbest_read_i,
    .tbest_slot_i,
    .tbest_o,
    .final_read_i(final_read),
    .final_slot_i(final_slot),
    .final_o     (final_best)
  );

  // ---- The end of a leaf: on, or the end of the ray.  The best t is compared when it is there, `CmpStages` later than
  // the count, and the ray ends or goes on as many after that.
  localparam int unsigned LeafStages = 1 + 2 * CmpStages;

  typedef struct packed {
    slot_t slot;
    logic  error;
    logic  any_hit;
  } leaf_t;

  typedef struct packed {
    leaf_t leaf;
    logic  has_hit;
    park_t park;
    logic  not_beyond;
  } end_t;

  logic any_hit, read, not_beyond, ends, ended;
  logic [LeafStages-1:0] leaf_q;  // all tests are back
  leaf_t counted, known, known_q;
  park_t park;
  park_word_t park_word;
  end_t at_end;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) leaf_q <= '0;
    else leaf_q <= LeafStages'({leaf_q, token_q && all_back});
  end

  if (AnyHit) begin : gen_any_hit
    logic [NumSlots-1:0] any_hit_q;
    assign any_hit = any_hit_q[slot_q];
    always_ff @(posedge clk_i) begin
      if (start_i) any_hit_q[start_slot_i] <= start_any_hit_i;
    end
  end else begin : gen_no_any_hit
    assign any_hit = 1'b0;
    `TI_ASSERT(NoAnyHitRay, start_i -> !start_any_hit_i)
  end

  assign counted = '{slot: slot_q, error: back.error, any_hit: any_hit};
  ti_delay #(
    .payload_t(logic [$bits(leaf_t):0]),
    .Cycles   (CmpStages)
  ) u_known (
    .clk_i,
    .rst_ni,
    .data_i({token_q, counted}),
    .data_o({read, known})
  );
  always_ff @(posedge clk_i) known_q <= known;

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(park_word_t)
  ) u_park (
    .clk_i,
    .read_en_i(read),
    .read_addr_i(known.slot),
    .read_data_o(park_word),
    .write_en_i(park_i),
    .write_addr_i(stop_slot_i),
    .write_data_i(park_word_t'({park_restart_i, park_go_i, park_next_i, park_bound_i}))
  );
  assign park = $bits(park_t)'(park_word);

  ti_fp_cmp #(
    .ExpBits (ti_num_pkg::ExpBits),
    .FracBits(ti_num_pkg::FracBits)
  ) u_bound (
    .a_i(best_t),
    .b_i(park.bound),
    .lt_o(),
    .eq_o(),
    .le_o(not_beyond),
    .unordered_o()
  );
  ti_delay #(
    .payload_t(end_t),
    .Cycles   (CmpStages)
  ) u_end (
    .clk_i,
    .rst_ni,
    .data_i('{leaf: known_q, has_hit: has_hit, park: park, not_beyond: not_beyond}),
    .data_o(at_end)
  );
  assign ended = leaf_q[LeafStages-1];
  assign ends = at_end.leaf.error || !at_end.park.go || at_end.not_beyond ||
      (at_end.leaf.any_hit && at_end.has_hit);

  assign resume_o = ended && !ends;
  assign resume_slot_o = at_end.leaf.slot;
  assign resume_node_o = at_end.park.next;
  assign resume_restart_o = at_end.park.restart;

  ti_trv_retire #(
    .NumSlots(NumSlots),
    .AnyHit  (AnyHit)
  ) u_retire (
    .clk_i,
    .rst_ni,
    .start_i,
    .start_slot_i,
    .start_ray_id_i,
    .start_any_hit_i,
    .park_i,
    .done_i,
    .stop_slot_i,
    .stop_steps_i,
    .done_status_i,
    .ended_i      (ended && ends),
    .ended_slot_i (at_end.leaf.slot),
    .ended_error_i(at_end.leaf.error),
    .final_read_o (final_read),
    .final_slot_o (final_slot),
    .final_i      (final_best),
    .hit_valid_o,
    .hit_ready_i,
    .hit_data_o,
    .free_o,
    .free_slot_o
  );

  `TI_ASSERT(RestartsOnlyWhereARayMay, park_i -> Restart || !park_restart_i)
  `TI_ASSERT(NeverMoreBackThanSent, token_q -> back.count >= earlier.count && back.count <= sent)
  `TI_ASSERT(StartsBetweenLeaves, start_i -> !leaf_begun_q[start_slot_i])
  `TI_COVER(SameSlotInARow, token_q && same_slot_q)
  `TI_ASSERT_KNOWN(ReturnReadyKnown, return_ready_o)
  `TI_ASSERT_KNOWN(ResumeKnown, resume_o)

endmodule : ti_trv_return
