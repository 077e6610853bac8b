// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Set-up of a ray, one axis a cycle: the inverse direction and the interval inside the scene box.
///
/// Per axis inv = 1/d, t = (plane - o) * inv for the near and the far plane of the box (slabs, Kay and Kajiya
/// 1986); three axes in a row make a ray.  `Latency` cycles from the last axis to the result; no stall.
/// An axis whose inverse is infinite is parallel: it sets no bound, and the ray misses when o lies
/// outside.  tmin' = max(tmin, 0, near t's), tmax' = min(tmax, far t's), each moved outward by 4 ulp, which covers
/// the three roundings; the ray misses when tmin > tmax, tmin' > tmax' or tmax' < 0.
/// A ray with a NaN or infinite o or d, a NaN tmin or tmax, or three parallel axes is invalid.
/// 1 RCP, 2 ADD, 2 MUL, 4 CMP.
module ti_rd_clip #(
  localparam int unsigned RcpLatency = ti_fp_pkg::rcp_latency(ti_num_pkg::FracBits),
  localparam int unsigned GatherLatency = 1,  // interval over the axes
  localparam int unsigned CheckLatency = 1,  // outward, hit or miss
  localparam int unsigned Latency =
      RcpLatency + ti_fp_pkg::MulLatency + GatherLatency + CheckLatency
) (
  input logic clk_i,
  input logic rst_ni,
  input ti_pkg::vec3_t box_lo_i,
  input ti_pkg::vec3_t box_hi_i,

  input logic               valid_i,
  input logic         [1:0] axis_i,   // 0, 1, 2 in consecutive valid cycles
  input ti_pkg::ray_t       ray_i,    // the same for the three

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
  localparam int unsigned Outward = 4;
  typedef ti_pkg::fp_t fp_t;

  typedef struct packed {
    logic [1:0] axis;
    logic       bad;   // the ray as given cannot be traced
    fp_t        tmin;
    fp_t        tmax;
  } along_t;

  // Inverse, and beside it the way to the two planes.
  logic rcp_valid, mul_valid;
  fp_t inv, to_lo, to_hi, to_lo_mul, to_hi_mul, near_t, far_t;

  ti_fp_rcp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_rcp (
    .clk_i,
    .rst_ni,
    .valid_i,
    .a_i(ray_i.d[axis_i]),
    .valid_o(rcp_valid),
    .result_o(inv)
  );
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_lo (
    .clk_i,
    .rst_ni,
    .valid_i,
    .a_i(box_lo_i[axis_i]),
    .b_i(ray_i.o[axis_i]),
    .negate_b_i(1'b1),
    .valid_o(),
    .result_o(to_lo)
  );
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_hi (
    .clk_i,
    .rst_ni,
    .valid_i,
    .a_i(box_hi_i[axis_i]),
    .b_i(ray_i.o[axis_i]),
    .negate_b_i(1'b1),
    .valid_o(),
    .result_o(to_hi)
  );
  if (RcpLatency < ti_fp_pkg::AddLatency) begin : gen_check
    $error("ti_rd_clip: the reciprocal must not be faster than the adder");
  end
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (RcpLatency - ti_fp_pkg::AddLatency)
  ) u_to_mul (
    .clk_i,
    .rst_ni,
    .data_i({to_lo, to_hi}),
    .data_o({to_lo_mul, to_hi_mul})
  );

  logic negative, parallel, outside;
  assign negative = inv[W-1];
  assign parallel = inv[W-2:0] == ti_num_pkg::Inf[W-2:0];
  // lo - o > 0 or hi - o < 0.
  assign outside = (!to_lo_mul[W-1] && to_lo_mul[W-2:0] != '0) ||
      (to_hi_mul[W-1] && to_hi_mul[W-2:0] != '0);

  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_near (
    .clk_i,
    .rst_ni,
    .valid_i(rcp_valid),
    .a_i(negative ? to_hi_mul : to_lo_mul),
    .b_i(inv),
    .valid_o(mul_valid),
    .result_o(near_t)
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_far (
    .clk_i,
    .rst_ni,
    .valid_i(rcp_valid),
    .a_i(negative ? to_lo_mul : to_hi_mul),
    .b_i(inv),
    .valid_o(),
    .result_o(far_t)
  );

  along_t along, along_in;
  logic [5:0] finite;
  logic nan_tmin, nan_tmax;
  for (genvar i = 0; i < 3; i++) begin : gen_finite
    assign finite[i]   = ray_i.o[i][M+:E] != '1;
    assign finite[i+3] = ray_i.d[i][M+:E] != '1;
  end
  assign nan_tmin = ray_i.tmin[W-2:0] > ti_num_pkg::Inf[W-2:0];
  assign nan_tmax = ray_i.tmax[W-2:0] > ti_num_pkg::Inf[W-2:0];
  always_comb begin
    along_in.axis = axis_i;
    along_in.bad  = finite != '1 || nan_tmin || nan_tmax;
    along_in.tmin = ray_i.tmin;
    along_in.tmax = ray_i.tmax;
  end
  fp_t inv_end;
  logic parallel_end, outside_end;
  ti_delay #(
    .payload_t(along_t),
    .Cycles   (RcpLatency + ti_fp_pkg::MulLatency)
  ) u_along (
    .clk_i,
    .rst_ni,
    .data_i(along_in),
    .data_o(along)
  );
  ti_delay #(
    .payload_t(logic [W+1:0]),
    .Cycles   (ti_fp_pkg::MulLatency)
  ) u_inv (
    .clk_i,
    .rst_ni,
    .data_i({inv, parallel, outside}),
    .data_o({inv_end, parallel_end, outside_end})
  );

  // Gather the three axes.
  fp_t tmin_q, tmax_q, tmin_from, tmax_from;
  ti_pkg::vec3_t inv_q;
  logic gathered_q, empty_q, outside_q, bad_q, all_parallel_q;
  logic first, raise, lower, given_ordered;

  assign first     = along.axis == 2'd0;
  assign tmin_from = !first ? tmin_q : (along.tmin[W-1] ? '0 : along.tmin);
  assign tmax_from = !first ? tmax_q : along.tmax;

  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_raise (
    .a_i(tmin_from),
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
    .b_i(tmax_from),
    .lt_o(lower),
    .eq_o(),
    .le_o(),
    .unordered_o()
  );
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_given (
    .a_i(along.tmin),
    .b_i(along.tmax),
    .lt_o(),
    .eq_o(),
    .le_o(given_ordered),
    .unordered_o()
  );

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) gathered_q <= 1'b0;
    else gathered_q <= mul_valid && along.axis == 2'd2;
  end

  always_ff @(posedge clk_i) begin
    if (mul_valid) begin
      tmin_q            <= (raise && !parallel_end) ? near_t : tmin_from;
      tmax_q            <= (lower && !parallel_end) ? far_t : tmax_from;
      inv_q[along.axis] <= inv_end;
      outside_q         <= (parallel_end && outside_end) || (!first && outside_q);
      all_parallel_q    <= parallel_end && (first || all_parallel_q);
      bad_q             <= along.bad;
      empty_q           <= !given_ordered;
    end
  end

  // Outward, in the order of bit patterns: down to 0, up to infinity at most.
  fp_t tmin_out, tmax_out, tmin_size, tmax_size;
  logic ordered, invalid;
  assign tmin_size = {1'b0, tmin_q[W-2:0]};
  assign tmax_size = {1'b0, tmax_q[W-2:0]};
  assign tmin_out = (tmin_size > fp_t'(Outward)) ? tmin_size - fp_t'(Outward) : '0;
  assign tmax_out  = (tmax_size >= ti_num_pkg::Inf - fp_t'(Outward)) ? ti_num_pkg::Inf :
      tmax_size + fp_t'(Outward);
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_ordered (
    .a_i(tmin_out),
    .b_i(tmax_out),
    .lt_o(),
    .eq_o(),
    .le_o(ordered),
    .unordered_o()
  );
  assign invalid = bad_q || all_parallel_q;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) valid_o <= 1'b0;
    else valid_o <= gathered_q;
  end

  always_ff @(posedge clk_i) begin
    if (gathered_q) begin
      miss_o <= invalid || empty_q || outside_q || !ordered || (tmax_q[W-1] && tmax_q[W-2:0] != '0);
      status_o <= invalid ? ti_pkg::InvalidRay : ti_pkg::Ok;
      inv_o <= inv_q;
      tmin_o <= tmin_out;
      tmax_o <= tmax_out;
    end
  end

  `TI_ASSERT_KNOWN(ValidKnown, valid_o)

endmodule : ti_rd_clip
