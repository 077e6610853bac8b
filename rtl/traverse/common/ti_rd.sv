// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// RD, the ray dispatcher: sets rays up, answers those that miss the scene, deals the others to homes.
///
/// One ray in `RayCycles` cycles: the fewer, the more lanes of arithmetic (`ti_rd_clip`); the latency is the same.
/// Rays keep their order.  Credits bound the rays inside to `Depth`, so the set-up never stalls.  `DealTile` rays in a
/// row go to the same home while it has room, so that rays that lie together share an L1; then, and when that home is
/// full, to the next with room.  Rays that miss the scene box do not count.  A ray is dealt in each cycle, but for the
/// one in which a home is found full.
module ti_rd #(
  parameter int unsigned NumTrv = 1,
  parameter int unsigned DealTile = 16,
  /// Cycles a ray, 1 to 3.
  parameter int unsigned RayCycles = ti_config_pkg::RdCycles,
  /// Whether an any-hit ray can be traced; when not, it is answered as invalid.
  parameter bit AnyHit = ti_config_pkg::AnyHit,
  /// Whether rays are made thick for a padded traversal.
  parameter bit Padded = ti_config_pkg::Traversal == ti_config_pkg::TraversalPadded,
  /// Whether rays carry the constants of Woop's triangle test.
  parameter bit Woop = ti_config_pkg::TriangleTest == ti_config_pkg::TriangleTestWoop,
  localparam int unsigned AcceptLatency = 1,
  localparam int unsigned ThickLatency = Padded ? 2 * ti_fp_pkg::AddLatency + RayCycles + 1 : 0,
  localparam int unsigned ClipLatency = ti_fp_pkg::ChoiceLatency + ti_fp_pkg::rcp_latency(
      ti_num_pkg::FracBits
  ) + ti_fp_pkg::MulLatency + (3 - RayCycles) + 2 + ti_fp_pkg::CmpLatency,
  localparam int unsigned ShearLatency = Woop ? ti_fp_pkg::MulLatency + 1 : 0,
  localparam int unsigned QueueLatency = 1,
  localparam int unsigned Latency = AcceptLatency + RayCycles - 1 + ThickLatency + ClipLatency +
      ShearLatency + QueueLatency,
  // A credit is away for `Latency` + 1 cycles; some more are for rays that wait for a home.
  localparam int unsigned Depth = (Latency + RayCycles) / ((RayCycles > 0) ? RayCycles : 1) + 7
) (
  input logic clk_i,
  input logic rst_ni,
  input ti_pkg::vec3_t box_lo_i,
  input ti_pkg::vec3_t box_hi_i,

  input  logic         ray_valid_i,
  output logic         ray_ready_o,
  input  ti_pkg::ray_t ray_data_i,

  // To a home only while it is ready: a home that has room keeps it until it is dealt a ray.
  output logic                       [NumTrv-1:0] dispatch_valid_o,
  input  logic                       [NumTrv-1:0] dispatch_ready_i,
  output ti_traverse_pkg::dispatch_t              dispatch_data_o,

  output logic         hit_valid_o,  // rays that miss the scene box or are invalid
  input  logic         hit_ready_i,
  output ti_pkg::hit_t hit_data_o,

  output ti_count_pkg::rd_events_t events_o  // `room` where an output waits
);

  localparam int unsigned TileWidth = (DealTile > 1) ? $clog2(DealTile) : 1;
  localparam logic [1:0] LastStep = 2'(RayCycles - 1);

  // Of the rays that wait, the flag of an any-hit ray is the uppermost bit; without `AnyHit` it stays behind.
  localparam int unsigned RayWidth = $bits(ti_pkg::ray_t);
  localparam int unsigned WaitingWidth = AnyHit ? RayWidth : RayWidth - 1;
  typedef logic [WaitingWidth-1:0] waiting_t;

  typedef struct packed {
    logic            miss;
    ti_pkg::status_e status;
    ti_pkg::vec3_t   inv;
    ti_pkg::fp_t     tmin;
    ti_pkg::fp_t     tmax;
  } clipped_t;

  // Rays come in, `RayCycles` cycles each.
  logic take, hold_valid_q, last_step, egress, has_credit, empty;
  logic [1:0] step, step_q;
  ti_pkg::ray_t hold_q, ray;

  assign step        = (RayCycles == 1) ? '0 : step_q;
  assign last_step   = step == LastStep;
  assign ray_ready_o = has_credit && (!hold_valid_q || last_step);
  assign take        = ray_valid_i && ray_ready_o;

  ti_credits #(
    .Num(Depth)
  ) u_credits (
    .clk_i,
    .rst_ni,
    .take_i(take),
    .give_i(egress),
    .any_o (has_credit),
    .all_o (empty)
  );

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      hold_valid_q <= 1'b0;
      step_q       <= '0;
    end else begin
      if (take) hold_valid_q <= 1'b1;
      else if (last_step) hold_valid_q <= 1'b0;
      if (hold_valid_q) step_q <= last_step ? '0 : step + 1'b1;
    end
  end
  always_ff @(posedge clk_i) if (take) hold_q <= ray_data_i;

  // Clip, while the rays themselves wait.
  logic clip_valid, clipped_valid, ray_waits, all_valid;
  waiting_t waiting_in, waiting;
  clipped_t clip, clipped;

  logic thick_valid;
  logic [1:0] thick_step;
  ti_pkg::ray_t thick_ray;
  ti_traverse_pkg::origins_t thick_origins, origins;
  if (Padded) begin : gen_thick
    logic unused_waits;
    ti_rd_thick #(
      .RayCycles(RayCycles)
    ) u_thick (
      .clk_i,
      .rst_ni,
      .box_lo_i,
      .box_hi_i,
      .valid_i  (hold_valid_q),
      .step_i   (step),
      .ray_i    (hold_q),
      .valid_o  (thick_valid),
      .step_o   (thick_step),
      .ray_o    (thick_ray),
      .origins_o(thick_origins)
    );
    ti_queue #(
      .payload_t(ti_traverse_pkg::origins_t),
      .Depth    (Depth)
    ) u_origins (
      .clk_i,
      .rst_ni,
      .push_i     (thick_valid && thick_step == LastStep),
      .push_data_i(thick_origins),
      .out_valid_o(unused_waits),
      .out_ready_i(egress),
      .out_data_o (origins)
    );
  end else begin : gen_thin
    assign thick_valid   = hold_valid_q;
    assign thick_step    = step;
    assign thick_ray     = hold_q;
    assign thick_origins = '{least: hold_q.o, most: hold_q.o};
    assign origins       = '{least: ray.o, most: ray.o};
  end

  ti_rd_clip #(
    .RayCycles(RayCycles),
    .AnyHit   (AnyHit),
    .Padded   (Padded)
  ) u_clip (
    .clk_i,
    .rst_ni,
    .box_lo_i,
    .box_hi_i,
    .valid_i  (thick_valid),
    .step_i   (thick_step),
    .ray_i    (thick_ray),
    .origins_i(thick_origins),
    .valid_o  (clip_valid),
    .miss_o   (clip.miss),
    .status_o (clip.status),
    .inv_o    (clip.inv),
    .tmin_o   (clip.tmin),
    .tmax_o   (clip.tmax)
  );

  // Constants of the triangle test; they come last.
  ti_pkg::ray_operands_t operands;
  if (Woop) begin : gen_shear
    logic shear_valid, shear_waits;
    logic [1:0] z;
    ti_pkg::vec3_t clip_d, shear, shear_waiting;
    ti_delay #(
      .payload_t(ti_pkg::vec3_t),
      .Cycles   (ClipLatency)
    ) u_d (
      .clk_i,
      .rst_ni,
      .data_i(thick_ray.d),
      .data_o(clip_d)
    );
    ti_rd_shear u_shear (
      .clk_i,
      .rst_ni,
      .valid_i(clip_valid),
      .d_i    (clip_d),
      .inv_i  (clip.inv),
      .valid_o(shear_valid),
      .z_o    (z),
      .shear_o(shear)
    );
    ti_queue #(
      .payload_t(ti_pkg::vec3_t),
      .Depth    (Depth)
    ) u_shears (
      .clk_i,
      .rst_ni,
      .push_i     (shear_valid),
      .push_data_i(ti_pkg::with_axis(shear, z)),
      .out_valid_o(shear_waits),
      .out_ready_i(egress),
      .out_data_o (shear_waiting)
    );
    assign all_valid = clipped_valid && shear_waits;
    logic unused_d;
    assign unused_d = ^ray.d;
    assign operands = '{o: ray.o, d: shear_waiting};
  end else begin : gen_no_shear
    assign all_valid = clipped_valid;
    assign operands  = '{o: ray.o, d: ray.d};
  end

  ti_queue #(
    .payload_t(waiting_t),
    .Depth    (Depth)
  ) u_rays (
    .clk_i,
    .rst_ni,
    .push_i     (hold_valid_q && step == '0),
    .push_data_i(waiting_in),
    .out_valid_o(ray_waits),
    .out_ready_i(egress),
    .out_data_o (waiting)
  );
  assign waiting_in = waiting_t'({
    hold_q.any_hit,
    hold_q.ray_id,
    hold_q.o,
    Woop ? ti_pkg::vec3_t'('0) : hold_q.d,  // `operands` has what is needed of it
    hold_q.tmin,
    hold_q.tmax
  });
  assign {ray.any_hit, ray.ray_id, ray.o, ray.d, ray.tmin, ray.tmax} = RayWidth'(waiting);

  ti_queue #(
    .payload_t(clipped_t),
    .Depth    (Depth)
  ) u_clipped (
    .clk_i,
    .rst_ni,
    .push_i     (clip_valid),
    .push_data_i(clip),
    .out_valid_o(clipped_valid),
    .out_ready_i(egress),
    .out_data_o (clipped)
  );

  // Deal.
  localparam int unsigned HomeWidth = (NumTrv > 1) ? $clog2(NumTrv) : 1;
  logic [HomeWidth-1:0] home_q, next_home;
  logic [TileWidth-1:0] dealt_q;
  logic next_any, home_ready, enters, deal, dealt_tile;

  assign home_ready = dispatch_ready_i[home_q];
  assign enters = all_valid && !clipped.miss;
  assign deal = enters && home_ready;
  assign dealt_tile = deal && dealt_q == TileWidth'(DealTile - 1);
  assign dispatch_data_o = '{
          ray_id: ray.ray_id,
          any_hit: ray.any_hit,
          operands: operands,
          ray_tmin: ray.tmin,
          ray_tmax: ray.tmax,
          origins: origins,
          inv: clipped.inv,
          tmin: clipped.tmin,
          tmax: clipped.tmax
      };
  always_comb begin
    dispatch_valid_o         = '0;
    dispatch_valid_o[home_q] = deal;
  end

  ti_round_robin #(
    .Num(NumTrv)
  ) u_next_home (
    .request_i(dispatch_ready_i),
    .from_i   ((home_q == HomeWidth'(NumTrv - 1)) ? '0 : home_q + 1'b1),
    .any_o    (next_any),
    .index_o  (next_home)
  );

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      home_q  <= '0;
      dealt_q <= '0;
    end else if (dealt_tile || (enters && !home_ready)) begin
      if (next_any) home_q <= next_home;
      dealt_q <= '0;
    end else if (deal) begin
      dealt_q <= dealt_q + 1'b1;
    end
  end

  // Misses.
  assign hit_valid_o = all_valid && clipped.miss;
  always_comb begin
    hit_data_o        = '0;
    hit_data_o.ray_id = ray.ray_id;
    hit_data_o.status = clipped.status;
    hit_data_o.prim   = ti_pkg::NoPrim;
    hit_data_o.t      = ti_num_pkg::Inf;
  end
  assign egress = deal || (hit_valid_o && hit_ready_i);

  assign events_o.rays = take;
  assign events_o.misses = hit_valid_o && hit_ready_i;
  always_comb begin
    events_o.activity = '0;
    if (hold_valid_q) events_o.activity.works = 1'b1;
    else if (all_valid && !egress) events_o.activity.room = 1'b1;
    else if (!empty) events_o.activity.latency = 1'b1;
    else events_o.activity.empty = 1'b1;
  end

  `TI_ASSERT_NEXT(HitHeldUntilTaken, hit_valid_o && !hit_ready_i, hit_valid_o && $stable(hit_data_o
                                                                                            ))
  `TI_ASSERT(RayWaitsWithItsInterval, clipped_valid -> ray_waits)
  `TI_ASSERT(OneHomeARay, $onehot0(dispatch_valid_o))
  `TI_ASSERT(AnyHitRayOnlyWhereItCanBeTraced, deal -> AnyHit || !dispatch_data_o.any_hit)
  `TI_ASSERT_KNOWN(RayReadyKnown, ray_ready_o)
  `TI_ASSERT_KNOWN(DispatchValidKnown, dispatch_valid_o)
  `TI_ASSERT_KNOWN(HitValidKnown, hit_valid_o)

endmodule : ti_rd
