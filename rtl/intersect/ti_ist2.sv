// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// IST2: pass (c), r = 1/det, t = dett*r, u = detu*r, v = detv*r, on 1 RCP and 3 MUL.
///
/// Fixed latency inside, `Latency` cycles to the output queue; credits in front hold back what the
/// queue could not take.  One candidate a cycle.  A t that is not finite makes the test a miss; a candidate that
/// is one stays one.
module ti_ist2 #(
  localparam int unsigned RcpLatency = ti_fp_pkg::rcp_latency(ti_num_pkg::FracBits),
  localparam int unsigned QueueLatency = 1,
  localparam int unsigned Latency = RcpLatency + ti_fp_pkg::MulLatency + QueueLatency
) (
  input  logic clk_i,
  input  logic rst_ni,
  output logic idle_o,  // nothing inside

  input  logic                         candidate_valid_i,
  output logic                         candidate_ready_o,
  input  ti_intersect_pkg::candidate_t candidate_data_i,

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

  logic r_valid, t_valid;
  ti_pkg::fp_t r, dett, detu, detv, t, u, v;
  who_t who;

  ti_fp_rcp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_rcp (
    .clk_i,
    .rst_ni,
    .valid_i(take),
    .a_i(candidate_data_i.det),
    .valid_o(r_valid),
    .result_o(r)
  );
  ti_delay #(
    .payload_t(logic [3*W-1:0]),
    .Cycles   (RcpLatency)
  ) u_to_mul (
    .clk_i,
    .rst_ni,
    .data_i({candidate_data_i.dett, candidate_data_i.detu, candidate_data_i.detv}),
    .data_o({dett, detu, detv})
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_t (
    .clk_i,
    .rst_ni,
    .valid_i(r_valid),
    .a_i(dett),
    .b_i(r),
    .valid_o(t_valid),
    .result_o(t)
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_u (
    .clk_i,
    .rst_ni,
    .valid_i(r_valid),
    .a_i(detu),
    .b_i(r),
    .valid_o(),
    .result_o(u)
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_v (
    .clk_i,
    .rst_ni,
    .valid_i(r_valid),
    .a_i(detv),
    .b_i(r),
    .valid_o(),
    .result_o(v)
  );
  ti_delay #(
    .payload_t(who_t),
    .Cycles   (RcpLatency + ti_fp_pkg::MulLatency)
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
    result.hit   = t[M+:E] != '1 && !who.miss;
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

  `TI_ASSERT_KNOWN(CandidateReadyKnown, candidate_ready_o)
  `TI_ASSERT_KNOWN(ReturnValidKnown, return_valid_o)

endmodule : ti_ist2
