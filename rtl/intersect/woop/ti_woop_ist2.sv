// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// IST2 of Woop's triangle test: distance and barycentric coordinates of a test that is kept, on 4 ADD, 7 MUL and 1
/// RCP.
///
/// First the weights are brought to one size (`ti_woop_level`).
/// det = (U + V) + W, depth = (U A.z + V B.z) + W C.z, r = 1 / det, t = (depth * r) * sz, u = V * r, v = W * r.
/// Fixed latency inside, `Latency` cycles to the output queue; credits in front hold back what the queue could not
/// take.  One candidate a cycle.  A t that is not finite or less than 0 makes the test a miss, so does a det of 0; a
/// candidate that is one stays one.
module ti_woop_ist2 #(
  localparam int unsigned RcpLatency = ti_fp_pkg::rcp_latency(ti_num_pkg::FracBits),
  localparam int unsigned TimeLevel = 1,
  localparam int unsigned TimeSum = TimeLevel + ti_fp_pkg::MulLatency,  // of the first sums
  localparam int unsigned TimeSum2 = TimeSum + ti_fp_pkg::AddLatency,
  localparam int unsigned TimeRcp = TimeSum2 + ti_fp_pkg::AddLatency,
  localparam int unsigned TimeScale = TimeRcp + RcpLatency,
  localparam int unsigned TimeT = TimeScale + ti_fp_pkg::MulLatency,
  localparam int unsigned TimeEnd = TimeT + ti_fp_pkg::MulLatency,
  localparam int unsigned QueueLatency = 1,
  localparam int unsigned Latency = TimeEnd + QueueLatency
) (
  input  logic clk_i,
  input  logic rst_ni,
  output logic idle_o,  // nothing inside

  input  logic                              candidate_valid_i,
  output logic                              candidate_ready_o,
  input  ti_intersect_pkg::woop_candidate_t candidate_data_i,

  output logic            return_valid_o,
  input  logic            return_ready_i,
  output ti_pkg::return_t return_data_o,

  output ti_count_pkg::ist2_events_t events_o  // `room` where the output waits
);

  localparam int unsigned W = ti_num_pkg::FpWidth;
  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;
  // A credit comes back one cycle after a beat has left the queue.
  localparam int unsigned Depth = Latency + 2;
  typedef ti_pkg::fp_t fp_t;

  typedef struct packed {
    ti_pkg::home_t home;
    logic          miss;
    ti_pkg::prim_t prim;
  } who_t;

  logic take, egress;
  assign take   = candidate_valid_i && candidate_ready_o;
  assign egress = return_valid_o && return_ready_i;

  ti_credits #(
    .Num(Depth)
  ) u_credits (
    .clk_i,
    .rst_ni,
    .take_i(take),
    .give_i(egress),
    .any_o (candidate_ready_o),
    .all_o (idle_o)
  );

  ti_pkg::vec3_t weight, z;
  logic level_valid;
  ti_woop_level u_level (
    .clk_i,
    .rst_ni,
    .valid_i (take),
    .weight_i(candidate_data_i.edges.weight),
    .valid_o (level_valid),
    .level_o (weight)
  );
  ti_delay #(
    .payload_t(ti_pkg::vec3_t),
    .Cycles   (TimeLevel)
  ) u_z (
    .clk_i,
    .rst_ni,
    .data_i(candidate_data_i.edges.z),
    .data_o(z)
  );

  // Depth and det, side by side: the weights wait for the products.
  ti_pkg::vec3_t product, weight_sum;
  logic [2:0] product_valid;
  for (genvar k = 0; k < 3; k++) begin : gen_product
    ti_fp_mul #(
      .ExpBits (E),
      .FracBits(M)
    ) u_product (
      .clk_i,
      .rst_ni,
      .valid_i(level_valid),
      .a_i(weight[k]),
      .b_i(z[k]),
      .valid_o(product_valid[k]),
      .result_o(product[k])
    );
  end
  ti_delay #(
    .payload_t(ti_pkg::vec3_t),
    .Cycles   (ti_fp_pkg::MulLatency)
  ) u_weight (
    .clk_i,
    .rst_ni,
    .data_i(weight),
    .data_o(weight_sum)
  );

  fp_t det_part, depth_part, det_last, depth_last, det, depth, depth_scale;
  logic sum_valid, sum2_valid, det_valid, r_valid, scaled_valid, t_valid;
  assign sum_valid = product_valid[0];
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_det_part (
    .clk_i,
    .rst_ni,
    .valid_i(sum_valid),
    .a_i(weight_sum[0]),
    .b_i(weight_sum[1]),
    .negate_b_i(1'b0),
    .valid_o(sum2_valid),
    .result_o(det_part)
  );
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_depth_part (
    .clk_i,
    .rst_ni,
    .valid_i(sum_valid),
    .a_i(product[0]),
    .b_i(product[1]),
    .negate_b_i(1'b0),
    .valid_o(),
    .result_o(depth_part)
  );
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (ti_fp_pkg::AddLatency)
  ) u_last (
    .clk_i,
    .rst_ni,
    .data_i({weight_sum[2], product[2]}),
    .data_o({det_last, depth_last})
  );
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_det (
    .clk_i,
    .rst_ni,
    .valid_i(sum2_valid),
    .a_i(det_part),
    .b_i(det_last),
    .negate_b_i(1'b0),
    .valid_o(det_valid),
    .result_o(det)
  );
  ti_fp_add #(
    .ExpBits (E),
    .FracBits(M)
  ) u_depth (
    .clk_i,
    .rst_ni,
    .valid_i(sum2_valid),
    .a_i(depth_part),
    .b_i(depth_last),
    .negate_b_i(1'b0),
    .valid_o(),
    .result_o(depth)
  );

  // Scale by 1 / det, then by the inverse of the direction.
  fp_t r, scaled, t, u, v, sz_t;
  logic [2*W-1:0] vw_scale;
  who_t who;
  ti_fp_rcp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_rcp (
    .clk_i,
    .rst_ni,
    .valid_i(det_valid),
    .a_i(det),
    .valid_o(r_valid),
    .result_o(r)
  );
  ti_delay #(
    .payload_t(fp_t),
    .Cycles   (RcpLatency)
  ) u_depth_to_scale (
    .clk_i,
    .rst_ni,
    .data_i(depth),
    .data_o(depth_scale)
  );
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (TimeScale - TimeSum)
  ) u_vw (
    .clk_i,
    .rst_ni,
    .data_i({weight_sum[2], weight_sum[1]}),
    .data_o(vw_scale)
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_scaled (
    .clk_i,
    .rst_ni,
    .valid_i(r_valid),
    .a_i(depth_scale),
    .b_i(r),
    .valid_o(scaled_valid),
    .result_o(scaled)
  );
  ti_delay #(
    .payload_t(fp_t),
    .Cycles   (TimeT)
  ) u_sz (
    .clk_i,
    .rst_ni,
    .data_i(candidate_data_i.edges.sz),
    .data_o(sz_t)
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_t (
    .clk_i,
    .rst_ni,
    .valid_i(scaled_valid),
    .a_i(scaled),
    .b_i(sz_t),
    .valid_o(t_valid),
    .result_o(t)
  );
  fp_t u_scale, v_scale;
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_u (
    .clk_i,
    .rst_ni,
    .valid_i(r_valid),
    .a_i(vw_scale[W-1:0]),
    .b_i(r),
    .valid_o(),
    .result_o(u_scale)
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_v (
    .clk_i,
    .rst_ni,
    .valid_i(r_valid),
    .a_i(vw_scale[2*W-1:W]),
    .b_i(r),
    .valid_o(),
    .result_o(v_scale)
  );
  ti_delay #(
    .payload_t(logic [2*W-1:0]),
    .Cycles   (TimeEnd - TimeT)
  ) u_uv (
    .clk_i,
    .rst_ni,
    .data_i({v_scale, u_scale}),
    .data_o({v, u})
  );
  ti_delay #(
    .payload_t(who_t),
    .Cycles   (TimeEnd)
  ) u_who (
    .clk_i,
    .rst_ni,
    .data_i(
    '{home: candidate_data_i.home, miss: candidate_data_i.miss, prim: candidate_data_i.prim}
    ),
    .data_o(who)
  );

  ti_pkg::return_t result;
  always_comb begin
    result       = '0;
    result.home  = who.home;
    result.count = 16'd1;
    result.hit   = t[M+:E] != '1 && (!t[W-1] || t[W-2:0] == '0) && !who.miss;
    result.prim  = who.prim;
    result.t     = t;
    result.u     = u;
    result.v     = v;
  end

  ti_queue #(
    .payload_t(ti_pkg::return_t),
    .Depth    (Depth)
  ) u_out (
    .clk_i,
    .rst_ni,
    .push_i     (t_valid),
    .push_data_i(result),
    .out_valid_o(return_valid_o),
    .out_ready_i(return_ready_i),
    .out_data_o (return_data_o)
  );

  always_comb begin
    events_o.activity = '0;
    if (take) events_o.activity.works = 1'b1;
    else if (return_valid_o && !return_ready_i) events_o.activity.room = 1'b1;
    else if (!idle_o) events_o.activity.latency = 1'b1;
    else events_o.activity.empty = 1'b1;

    events_o.c_passes = take;
  end

  logic unused_valid;
  assign unused_valid = ^product_valid[2:1];

  `TI_ASSERT_KNOWN(CandidateReadyKnown, candidate_ready_o)
  `TI_ASSERT_KNOWN(ReturnValidKnown, return_valid_o)

endmodule : ti_woop_ist2
