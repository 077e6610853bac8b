// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The way home: the best hit of each slot, the end of leaves, retirement.  1 CMP.
///
/// Takes return tokens and slots that are done, one at a time.  A miss costs 1 cycle, a hit 3, the last test
/// of a leaf 1 more, a retirement 1 more.  A hit counts when tmin <= t and (t, prim) is less than the
/// best so far, which starts as (the ray's tmax, no primitive).  When all tests of a leaf are back, the ray
/// ends if its best t <= the leaf's bound, if it is an any-hit ray with a hit, if memory failed, or if
/// nothing is left to visit; else it goes on.  The bound is a t below which nothing of what is left to visit
/// lies: a kd-tree gives the leaf's exit.  Waits only for the taker of hits.
module ti_trv_return #(
  parameter int unsigned NumSlots = 8
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

  // A slot enters a leaf with triangles.
  input logic                park_i,
  input ti_pkg::trv_slot_t   park_slot_i,
  input ti_pkg::tri_count_t  park_count_i,
  input logic                park_go_i,       // there is more to visit after it
  input logic                park_restart_i,  // that is the root again
  input ti_pkg::node_index_t park_next_i,
  input ti_pkg::fp_t         park_bound_i,    // nothing after it is nearer
  input ti_pkg::steps_t      park_steps_i,

  // A slot is done without a leaf.
  input  logic              done_valid_i,
  output logic              done_ready_o,
  input  ti_pkg::trv_slot_t done_slot_i,
  input  ti_pkg::status_e   done_status_i,
  input  ti_pkg::steps_t    done_steps_i,

  input  logic            return_valid_i,
  output logic            return_ready_o,
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

  typedef struct packed {
    logic [31:0] ray_id;
    logic        any_hit;
    fp_t         tmin;
    fp_t         tmax;
  } start_t;

  typedef struct packed {
    ti_pkg::tri_count_t  count;
    logic                go;
    logic                restart;
    ti_pkg::node_index_t next;
    fp_t                 bound;
    ti_pkg::steps_t      steps;
  } park_t;

  typedef struct packed {
    fp_t           t;
    fp_t           u;
    fp_t           v;
    ti_pkg::prim_t prim;
  } best_t;

  typedef enum logic [2:0] {
    Idle,    // nothing in hand
    Wait,    // a hit has just been written
    Token,   // a return token: compare with tmin
    Accept,  // a hit in range: compare with the best
    Leaf,    // all tests are back: end or go on
    Retire   // give the hit to the taker
  } state_e;

  state_e state_d, state_q;

  // What is in hand.
  slot_t load_slot, slot_q;
  ti_pkg::return_t token_q;
  ti_pkg::status_e status_d, status_q;
  ti_pkg::steps_t done_steps_q;
  logic done_q, prefer_done_q;
  start_t start;
  park_t  park;
  best_t best, best_ram, new_best_q;
  logic new_best_valid_q;

  // Per slot.
  logic [NumSlots-1:0] has_hit_q, error_q;
  ti_pkg::tri_count_t back_q[NumSlots];

  logic load, load_done, all_back, le, lt, eq, take_hit, finish_token, ends;
  fp_t cmp_a, cmp_b;

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(start_t)
  ) u_start (
    .clk_i,
    .read_en_i(load),
    .read_addr_i(load_slot),
    .read_data_o(start),
    .write_en_i(start_i),
    .write_addr_i(start_slot_i),
    .write_data_i(
    '{ray_id: start_ray_id_i, any_hit: start_any_hit_i, tmin: start_tmin_i, tmax: start_tmax_i}
    )
  );

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(park_t)
  ) u_park (
    .clk_i,
    .read_en_i(load),
    .read_addr_i(load_slot),
    .read_data_o(park),
    .write_en_i(park_i),
    .write_addr_i(park_slot_i),
    .write_data_i(
    '{
        count: park_count_i,
        go: park_go_i,
        restart: park_restart_i,
        next: park_next_i,
        bound: park_bound_i,
        steps: park_steps_i
    }
    )
  );

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(best_t)
  ) u_best (
    .clk_i,
    .read_en_i   (load),
    .read_addr_i (load_slot),
    .read_data_o (best_ram),
    .write_en_i  (take_hit),
    .write_addr_i(slot_q),
    .write_data_i('{t: token_q.t, u: token_q.u, v: token_q.v, prim: token_q.prim})
  );

  // Copies for the step pipeline: the best t is the ray's tmax until it has a hit.
  fp_t tbest_hit, tbest_start;
  logic tbest_is_hit_q;
  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(fp_t)
  ) u_tbest_hit (
    .clk_i,
    .read_en_i   (tbest_read_i),
    .read_addr_i (tbest_slot_i),
    .read_data_o (tbest_hit),
    .write_en_i  (take_hit),
    .write_addr_i(slot_q),
    .write_data_i(token_q.t)
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
    if (tbest_read_i) tbest_is_hit_q <= has_hit_q[tbest_slot_i];
  end
  assign tbest_o        = tbest_is_hit_q ? tbest_hit : tbest_start;

  // Next in hand: round robin between slots that are done and tokens, so neither waits for more than one of the other.
  assign load           = state_d == Idle;
  assign load_done      = done_valid_i && (prefer_done_q || !return_valid_i);
  assign load_slot      = load_done ? done_slot_i : return_data_i.home.slot;
  assign done_ready_o   = load && (prefer_done_q || !return_valid_i);
  assign return_ready_o = load && !(prefer_done_q && done_valid_i);

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      state_q       <= Idle;
      prefer_done_q <= 1'b0;
    end else begin
      if (!load) state_q <= state_d;
      else if (load_done) state_q <= Retire;
      else if (return_valid_i) state_q <= Token;
      else state_q <= Idle;
      if (load && (done_valid_i || return_valid_i)) prefer_done_q <= !load_done;
    end
  end

  always_ff @(posedge clk_i) begin
    if (load) begin
      slot_q       <= load_slot;
      token_q      <= return_data_i;
      done_q       <= load_done;
      done_steps_q <= done_steps_i;
      status_q     <= done_status_i;
    end else begin
      status_q <= status_d;
    end
  end

  // The best so far of the slot in hand, with what this token has just changed.
  always_ff @(posedge clk_i) begin
    new_best_valid_q <= take_hit || (new_best_valid_q && !load);
    if (take_hit) new_best_q <= '{t: token_q.t, u: token_q.u, v: token_q.v, prim: token_q.prim};
  end
  always_comb begin
    best = new_best_valid_q ? new_best_q : best_ram;
    if (!has_hit_q[slot_q]) best = '{t: start.tmax, u: '0, v: '0, prim: ti_pkg::NoPrim};
  end

  // One comparison a state: tmin with t, t with the best, the best with the bound.
  always_comb begin
    cmp_a = start.tmin;
    cmp_b = token_q.t;
    if (state_q == Accept) begin
      cmp_a = token_q.t;
      cmp_b = best.t;
    end else if (state_q == Leaf) begin
      cmp_a = best.t;
      cmp_b = park.bound;
    end
  end
  ti_fp_cmp #(
    .ExpBits (ti_num_pkg::ExpBits),
    .FracBits(ti_num_pkg::FracBits)
  ) u_cmp (
    .a_i(cmp_a),
    .b_i(cmp_b),
    .lt_o(lt),
    .eq_o(eq),
    .le_o(le),
    .unordered_o()
  );

  assign take_hit = state_q == Accept && (lt || (eq && token_q.prim < best.prim));
  assign all_back = back_q[slot_q] + token_q.count == park.count;
  assign ends     = error_q[slot_q] || !park.go || le || (start.any_hit && has_hit_q[slot_q]);

  always_comb begin
    state_d      = Idle;
    status_d     = status_q;
    finish_token = 1'b0;
    resume_o     = 1'b0;
    free_o       = 1'b0;

    unique case (state_q)
      Idle, Wait: ;
      Token: begin
        if (token_q.hit && le) begin
          state_d = Accept;
        end else begin
          finish_token = 1'b1;
          if (all_back) state_d = Leaf;
        end
      end
      Accept: begin
        finish_token = 1'b1;
        if (all_back) state_d = Leaf;
      end
      Leaf: begin
        status_d = error_q[slot_q] ? ti_pkg::MemoryError : ti_pkg::Ok;
        if (ends) state_d = Retire;
        else resume_o = 1'b1;
      end
      Retire: begin
        if (hit_ready_i) free_o = 1'b1;
        else state_d = Retire;
      end
      default: ;
    endcase
    // A hit that is written in this cycle could be what the next token reads.
    if (state_q == Accept && !all_back) state_d = take_hit ? Wait : Idle;
  end

  always_ff @(posedge clk_i) begin
    if (finish_token) begin
      back_q[slot_q] <= all_back ? '0 : back_q[slot_q] + token_q.count;
      if (token_q.error) error_q[slot_q] <= 1'b1;
      if (take_hit) has_hit_q[slot_q] <= 1'b1;
    end
    if (start_i) begin
      back_q[start_slot_i]    <= '0;
      error_q[start_slot_i]   <= 1'b0;
      has_hit_q[start_slot_i] <= 1'b0;
    end
  end

  assign resume_slot_o = slot_q;
  assign resume_node_o = park.next;
  assign resume_restart_o = park.restart;
  assign free_slot_o = slot_q;

  // A ray that ends badly reports no hit; an any-hit ray reports only that it hit.
  logic reports_hit;
  assign reports_hit = has_hit_q[slot_q] && status_q == ti_pkg::Ok;
  assign hit_valid_o = state_q == Retire;
  always_comb begin
    hit_data_o        = '0;
    hit_data_o.ray_id = start.ray_id;
    hit_data_o.status = status_q;
    hit_data_o.steps  = done_q ? done_steps_q : park.steps;
    hit_data_o.hit    = reports_hit;
    if (!reports_hit) begin
      hit_data_o.t    = ti_num_pkg::Inf;
      hit_data_o.prim = ti_pkg::NoPrim;
    end else if (!start.any_hit) begin
      hit_data_o.t    = best.t;
      hit_data_o.u    = best.u;
      hit_data_o.v    = best.v;
      hit_data_o.prim = best.prim;
    end
  end

  `TI_ASSERT(OutHeldUntilTaken, hit_valid_o && !hit_ready_i |=> hit_valid_o && $stable(hit_data_o))
  `TI_ASSERT(NeverMoreBackThanSent, finish_token |-> back_q[slot_q] + token_q.count <= park.count)
  `TI_ASSERT_KNOWN(DoneReadyKnown, done_ready_o)
  `TI_ASSERT_KNOWN(ReturnReadyKnown, return_ready_o)
  `TI_ASSERT_KNOWN(HitValidKnown, hit_valid_o)

endmodule : ti_trv_return
