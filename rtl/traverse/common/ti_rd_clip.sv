// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Set-up of a ray: the inverse direction and the interval inside the scene box, of a thick ray from its two origins.
///
/// A ray in `RayCycles` steps.  Lane 0 takes one of the first `RayCycles` axes in each step; each further axis has a
/// lane of its own and enters it one cycle after the axis before.  So the interval is gathered axis by axis, one
/// comparison of each end in a cycle, and the same number of cycles after the first step for each `RayCycles`:
/// `Latency` cycles after the last step; no stall. An axis whose inverse is infinite is parallel: it sets no bound, and
/// the ray misses when o lies outside.  tmin' = max(tmin, 0, near t's), tmax' = min(tmax, far t's), each moved outward
/// by `Outward` ulp, which covers the three roundings; the ray misses when tmin > tmax, tmin' > tmax' or tmax' < 0.
/// With u = 2^-(FracBits+1) an ulp is at least u of its number, so k of them upward are a factor of at least (1 + u)^k.
/// t is at least (1 - a)^2 (1 - H u) of what it stands for, with a = u to nearest and 2 u toward zero, and H half ulps
/// the error of the reciprocal, by division 1 or 2.  k = H + 3, or H + 6 toward zero, is enough for FracBits >= 2 and
/// H^2 <= 2^(FracBits+1), which `scripts/configure.py` holds; downward it asks for no more.  `docs/fp.md` says what is
/// lost where inverses end at the largest number, and where subnormals are flushed. A ray with a NaN or infinite o or
/// d, a NaN tmin or tmax, or three parallel axes is invalid; without `AnyHit` so is an any-hit ray. A lane has 1 RCP, 2
/// ADD, 2 MUL, 2 CMP; 2 CMP for all.
module ti_rd_clip #(
  /// Cycles a ray, 1 to 3.
  parameter int unsigned RayCycles = ti_config_pkg::RdCycles,
  /// Whether an any-hit ray can be traced.
  parameter bit AnyHit = ti_config_pkg::AnyHit,
  /// Whether the two origins differ.
  parameter bit Padded = ti_config_pkg::Traversal == ti_config_pkg::TraversalPadded,
  localparam int unsigned Lanes = 4 - RayCycles,
  localparam int unsigned AxisLatency = ti_fp_pkg::ChoiceLatency + ti_fp_pkg::rcp_latency(
      ti_num_pkg::FracBits
  ) + ti_fp_pkg::MulLatency,
  localparam int unsigned SkewLatency = Lanes - 1,  // of the last lane
  localparam int unsigned GatherLatency = 1,  // interval over the axes
  localparam int unsigned CheckLatency = 1 + ti_fp_pkg::CmpLatency,  // outward, hit or miss
  localparam int unsigned Latency = AxisLatency + SkewLatency + GatherLatency + CheckLatency
) (
  input logic clk_i,
  input logic rst_ni,
  input ti_pkg::vec3_t box_lo_i,  // constant while rays are inside
  input ti_pkg::vec3_t box_hi_i,

  input logic valid_i,
  input logic [1:0] step_i,  // 0 to RayCycles - 1 in consecutive valid cycles
  input ti_pkg::ray_t ray_i,  // the same for all steps
  // Valid for the axes of this step; without `Padded` that of the least t alone counts.
  input ti_traverse_pkg::origins_t origins_i,

  output logic            valid_o,
  output logic            miss_o,
  output ti_pkg::status_e status_o,
  output ti_pkg::vec3_t   inv_o,
  output ti_pkg::fp_t     tmin_o,
  output ti_pkg::fp_t     tmax_o
);

  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;
  localparam int unsigned W = ti_num_pkg::FpWidth;
  // Units in the last place by which the interval grows at each end.
  localparam int unsigned Outward = ti_fp_pkg::outward_ulps(M);
  localparam logic [1:0] LastStep = 2'(RayCycles - 1);
  typedef ti_pkg::fp_t fp_t;

  if (RayCycles < 1 || RayCycles > 3) begin : gen_check_ray_cycles
    $error("ti_rd_clip: RayCycles must be 1 to 3");
  end

  // The ray as given, beside lane 0.
  typedef struct packed {
    logic [1:0] step;
    logic       bad;    // cannot be traced
    logic       empty;  // tmin > tmax as given
    fp_t        tmin;   // 0 or more
    fp_t        tmax;
  } along_t;

  // What the axes say so far.
  typedef struct packed {
    fp_t           tmin;
    fp_t           tmax;
    ti_pkg::vec3_t inv;
    logic          outside;
    logic          all_parallel;
    logic          bad;
    logic          empty;
  } bounds_t;

  along_t along, along_in;
  logic [5:0] finite;
  logic nan_tmin, nan_tmax, refused;
  for (genvar i = 0; i < 3; i++) begin : gen_finite
    assign finite[i]   = ray_i.o[i][M+:E] != '1;
    assign finite[i+3] = ray_i.d[i][M+:E] != '1;
  end
  assign nan_tmin = ray_i.tmin[W-2:0] > ti_num_pkg::Inf[W-2:0];
  assign nan_tmax = ray_i.tmax[W-2:0] > ti_num_pkg::Inf[W-2:0];
  assign refused  = ray_i.any_hit && !AnyHit;
  logic given_ordered;
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_given (
    .a_i(ray_i.tmin),
    .b_i(ray_i.tmax),
    .lt_o(),
    .eq_o(),
    .le_o(given_ordered),
    .unordered_o()
  );
  always_comb begin
    along_in.step  = step_i;
    along_in.bad   = finite != '1 || nan_tmin || nan_tmax || refused;
    along_in.empty = !given_ordered;
    along_in.tmin  = ray_i.tmin[W-1] ? '0 : ray_i.tmin;
    along_in.tmax  = ray_i.tmax;
  end
  ti_delay #(
    .payload_t(along_t),
    .Cycles   (AxisLatency)
  ) u_along (
    .clk_i,
    .rst_ni,
    .data_i(along_in),
    .data_o(along)
  );

  bounds_t bounds_q[Lanes];
  logic start[Lanes], axis_valid[Lanes];

  for (genvar k = 0; k < Lanes; k++) begin : gen_lane
    fp_t lo, hi, near_o, far_o, d, inv, near_t, far_t;
    logic parallel, outside, raise, lower;
    logic [1:0] axis;
    bounds_t from, bounds;

    if (k == 0) begin : gen_first
      logic first;
      assign start[k] = valid_i;
      assign lo = box_lo_i[step_i];
      assign hi = box_hi_i[step_i];
      assign d = ray_i.d[step_i];
      assign near_o = origins_i.least[step_i];
      assign far_o = Padded ? origins_i.most[step_i] : near_o;

      assign first = along.step == 2'd0;
      assign axis = along.step;
      always_comb begin
        from = bounds_q[k];
        if (first) begin
          from.tmin         = along.tmin;
          from.tmax         = along.tmax;
          from.outside      = 1'b0;
          from.all_parallel = 1'b1;
          from.bad          = along.bad;
          from.empty        = along.empty;
        end
      end
    end else begin : gen_later
      localparam int unsigned Axis = RayCycles - 1 + k;
      logic enter, start_q;
      assign enter    = (k == 1) ? valid_i && step_i == LastStep : start[k-1];
      assign start[k] = start_q;
      always_ff @(`TI_CLK_RST) begin
        if (!rst_ni) start_q <= 1'b0;
        else start_q <= enter;
      end
      ti_delay #(
        .payload_t(logic [2*W-1:0]),
        .Cycles   (k)
      ) u_skew (
        .clk_i,
        .rst_ni,
        .data_i({origins_i.least[Axis], ray_i.d[Axis]}),
        .data_o({near_o, d})
      );
      if (Padded) begin : gen_far
        ti_delay #(
          .payload_t(fp_t),
          .Cycles   (k)
        ) u_skew_far (
          .clk_i,
          .rst_ni,
          .data_i(origins_i.most[Axis]),
          .data_o(far_o)
        );
      end else begin : gen_same
        assign far_o = near_o;
      end
      assign lo   = box_lo_i[Axis];
      assign hi   = box_hi_i[Axis];
      assign axis = 2'(Axis);
      assign from = bounds_q[k-1];
    end

    ti_rd_axis u_axis (
      .clk_i,
      .rst_ni,
      .valid_i   (start[k]),
      .lo_i      (lo),
      .hi_i      (hi),
      .near_o_i  (near_o),
      .far_o_i   (far_o),
      .d_i       (d),
      .valid_o   (axis_valid[k]),
      .inv_o     (inv),
      .near_o    (near_t),
      .far_o     (far_t),
      .parallel_o(parallel),
      .outside_o (outside)
    );

    // Gather the axis.
    ti_fp_cmp #(
      .ExpBits (E),
      .FracBits(M)
    ) u_raise (
      .a_i(from.tmin),
      .b_i(near_t),
      .lt_o(raise),
      .eq_o(),
      .le_o(),
      .unordered_o()
    );
    ti_fp_cmp #(
      .ExpBits (E),
      .FracBits(M)
    ) u_lower (
      .a_i(far_t),
      .b_i(from.tmax),
      .lt_o(lower),
      .eq_o(),
      .le_o(),
      .unordered_o()
    );
    always_comb begin
      bounds           = from;
      bounds.inv[axis] = inv;
      if (parallel) begin
        bounds.outside = from.outside || outside;
      end else begin
        bounds.all_parallel = 1'b0;
        if (raise) bounds.tmin = near_t;
        if (lower) bounds.tmax = far_t;
      end
    end
    always_ff @(posedge clk_i) if (axis_valid[k]) bounds_q[k] <= bounds;
  end

  // Outward, in the order of bit patterns: down to 0, up to infinity at most.
  bounds_t all;
  fp_t tmin_size, tmax_size;
  assign all       = bounds_q[Lanes-1];
  assign tmin_size = {1'b0, all.tmin[W-2:0]};
  assign tmax_size = {1'b0, all.tmax[W-2:0]};

  typedef struct packed {
    fp_t           tmin;
    fp_t           tmax;
    ti_pkg::vec3_t inv;
    logic          invalid;
    logic          misses;
  } checked_t;
  checked_t outward, checked;
  always_comb begin
    outward.tmin = (tmin_size > fp_t'(Outward)) ? tmin_size - fp_t'(Outward) : '0;
    outward.tmax = tmax_size + fp_t'(Outward);
    if (tmax_size >= ti_num_pkg::Inf - fp_t'(Outward)) outward.tmax = ti_num_pkg::Inf;
    outward.inv     = all.inv;
    outward.invalid = all.bad || all.all_parallel;
    outward.misses  = all.empty || all.outside || (all.tmax[W-1] && all.tmax[W-2:0] != '0);
  end
  ti_delay #(
    .payload_t(checked_t),
    .Cycles   (ti_fp_pkg::CmpLatency)
  ) u_checked (
    .clk_i,
    .rst_ni,
    .data_i(outward),
    .data_o(checked)
  );
  logic ordered;
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_ordered (
    .a_i(checked.tmin),
    .b_i(checked.tmax),
    .lt_o(),
    .eq_o(),
    .le_o(ordered),
    .unordered_o()
  );

  logic [CheckLatency:0] valid_q;
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) valid_q <= '0;
    else
      valid_q <= {
        valid_q[CheckLatency-1:0], axis_valid[Lanes-1] && (Lanes > 1 || along.step == LastStep)
      };
  end
  assign valid_o = valid_q[CheckLatency];

  always_ff @(posedge clk_i) begin
    if (valid_q[CheckLatency-1]) begin
      miss_o   <= checked.invalid || checked.misses || !ordered;
      status_o <= checked.invalid ? ti_pkg::InvalidRay : ti_pkg::Ok;
      inv_o    <= checked.inv;
      tmin_o   <= checked.tmin;
      tmax_o   <= checked.tmax;
    end
  end

  `TI_ASSERT(StepsOfARayInOrder, valid_i -> step_i <= LastStep)
  `TI_ASSERT_KNOWN(ValidKnown, valid_o)

endmodule : ti_rd_clip
