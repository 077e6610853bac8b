// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Retirement: slots that have ended, after a leaf or on their walk, on their way to the taker of hits.
///
/// A slot that ends is always taken, as it stands in one of the two queues at most once: nobody before them waits for
/// the taker of hits.  Its hit is there `Latency` cycles later, one a cycle, round robin of the two kinds.  The slot is
/// free when its hit is taken.
module ti_trv_retire #(
  parameter int unsigned NumSlots = 8,
  /// Whether a ray may be an any-hit ray.
  parameter bit AnyHit = 1'b1,
  localparam int unsigned QueueLatency = 1,
  localparam int unsigned MemoryLatency = 1,
  localparam int unsigned Latency = QueueLatency + MemoryLatency
) (
  input logic clk_i,
  input logic rst_ni,

  // A ray takes a slot.
  input logic                     start_i,
  input ti_pkg::trv_slot_t        start_slot_i,
  input logic              [31:0] start_ray_id_i,
  input logic                     start_any_hit_i,

  // A walk stops: in a leaf with triangles (`park_i`) or for good (`done_i`).
  input logic              park_i,
  input logic              done_i,
  input ti_pkg::trv_slot_t stop_slot_i,
  input ti_pkg::steps_t    stop_steps_i,
  input ti_pkg::status_e   done_status_i,

  // A slot has ended after a leaf.
  input logic              ended_i,
  input ti_pkg::trv_slot_t ended_slot_i,
  input logic              ended_error_i,

  // Its best hit: read one cycle ahead, stays until the next read.
  output logic                   final_read_o,
  output ti_pkg::trv_slot_t      final_slot_o,
  input  ti_traverse_pkg::best_t final_i,

  output logic         hit_valid_o,
  input  logic         hit_ready_i,
  output ti_pkg::hit_t hit_data_o,

  output logic              free_o,      // the slot's ray has retired
  output ti_pkg::trv_slot_t free_slot_o
);

  typedef struct packed {
    ti_pkg::trv_slot_t slot;
    ti_pkg::status_e   status;
  } end_t;

  logic ended_valid, done_valid, ended_ready, done_ready, take_done, prefer_done_q;
  end_t ended, done, next;

  ti_queue #(
    .payload_t(end_t),
    .Depth    (NumSlots)
  ) u_ended (
    .clk_i,
    .rst_ni,
    .push_i     (ended_i),
    .push_data_i('{slot: ended_slot_i, status: ended_error_i ? ti_pkg::MemoryError : ti_pkg::Ok}),
    .out_valid_o(ended_valid),
    .out_ready_i(ended_ready),
    .out_data_o (ended)
  );
  ti_queue #(
    .payload_t(end_t),
    .Depth    (NumSlots)
  ) u_done (
    .clk_i,
    .rst_ni,
    .push_i     (done_i),
    .push_data_i('{slot: stop_slot_i, status: done_status_i}),
    .out_valid_o(done_valid),
    .out_ready_i(done_ready),
    .out_data_o (done)
  );

  // Neither kind waits for more than one of the other.
  logic room, take, hit_valid_q, any_hit_ray;
  ti_pkg::trv_slot_t slot_q;
  ti_pkg::status_e   status_q;

  assign room        = !hit_valid_q || hit_ready_i;
  assign take_done   = done_valid && (prefer_done_q || !ended_valid);
  assign done_ready  = room && take_done;
  assign ended_ready = room && !take_done;
  assign next        = take_done ? done : ended;
  assign take        = room && (done_valid || ended_valid);

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      hit_valid_q   <= 1'b0;
      prefer_done_q <= 1'b0;
    end else begin
      if (room) hit_valid_q <= done_valid || ended_valid;
      if (take) prefer_done_q <= !take_done;
    end
  end
  always_ff @(posedge clk_i) begin
    if (take) begin
      slot_q   <= next.slot;
      status_q <= next.status;
    end
  end

  if (AnyHit) begin : gen_any_hit
    logic any_hit, any_hit_ray_q;
    logic [NumSlots-1:0] any_hit_q;
    assign any_hit     = any_hit_q[next.slot];
    assign any_hit_ray = any_hit_ray_q;
    always_ff @(posedge clk_i) begin
      if (take) any_hit_ray_q <= any_hit;
      if (start_i) any_hit_q[start_slot_i] <= start_any_hit_i;
    end
  end else begin : gen_no_any_hit
    assign any_hit_ray = 1'b0;
    `TI_ASSERT(NoAnyHitRay, start_i -> !start_any_hit_i)
  end

  // What the hit is made of.
  logic [31:0] ray_id;
  ti_pkg::steps_t steps;

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(logic [31:0])
  ) u_ray_id (
    .clk_i,
    .read_en_i   (take),
    .read_addr_i (next.slot),
    .read_data_o (ray_id),
    .write_en_i  (start_i),
    .write_addr_i(start_slot_i),
    .write_data_i(start_ray_id_i)
  );
  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(ti_pkg::steps_t)
  ) u_steps (
    .clk_i,
    .read_en_i   (take),
    .read_addr_i (next.slot),
    .read_data_o (steps),
    .write_en_i  (park_i || done_i),
    .write_addr_i(stop_slot_i),
    .write_data_i(stop_steps_i)
  );
  assign final_read_o = take;
  assign final_slot_o = next.slot;

  // A ray that ends badly reports no hit; an any-hit ray reports only that it hit.
  logic reports_hit;
  assign reports_hit = final_i.hit && status_q == ti_pkg::Ok;
  assign hit_valid_o = hit_valid_q;
  always_comb begin
    hit_data_o        = '0;
    hit_data_o.ray_id = ray_id;
    hit_data_o.status = status_q;
    hit_data_o.steps  = steps;
    hit_data_o.hit    = reports_hit;
    if (!reports_hit) begin
      hit_data_o.t    = ti_num_pkg::Inf;
      hit_data_o.prim = ti_pkg::NoPrim;
    end else if (!any_hit_ray) begin
      hit_data_o.t    = final_i.t;
      hit_data_o.u    = final_i.u;
      hit_data_o.v    = final_i.v;
      hit_data_o.prim = final_i.prim;
    end
  end
  assign free_o      = hit_valid_q && hit_ready_i;
  assign free_slot_o = slot_q;

  `TI_ASSERT_NEXT(OutHeldUntilTaken, hit_valid_o && !hit_ready_i, hit_valid_o && $stable(hit_data_o
                                                                                            ))
  `TI_ASSERT(StopsOneWay, !(park_i && done_i))
  `TI_ASSERT_KNOWN(HitValidKnown, hit_valid_o)

endmodule : ti_trv_retire
