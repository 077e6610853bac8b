// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// The traversal cluster: rays in, hits out; leaves to test go out, results come back.
///
/// RD sets rays up and deals them to `NumTrv` homes, which walk the tree.  Another kind of tree stands behind the same
/// ports: it replaces `ti_trv` and the folder `kd`, and keeps what is in `common`.
/// The taker of leaves must always come to an end with them, and results are always taken, so no cycle of waiting
/// exists; the taker of hits must not wait for rays to be accepted.
module ti_traverse #(
  localparam int unsigned NumTrv = ti_config_pkg::NumTrv
) (
  input  logic                clk_i,
  input  logic                rst_ni,
  input  logic                flush_i,      // forget all lines; only while idle
  output logic                idle_o,       // no ray in a TRV, nothing on its way from memory
  // Where the scene stands.
  input  ti_pkg::node_index_t root_i,
  input  ti_mem_pkg::addr_t   node_base_i,
  input  ti_pkg::vec3_t       box_lo_i,
  input  ti_pkg::vec3_t       box_hi_i,

  input  logic         ray_valid_i,
  output logic         ray_ready_o,
  input  ti_pkg::ray_t ray_data_i,

  output logic         hit_valid_o,
  input  logic         hit_ready_i,
  output ti_pkg::hit_t hit_data_o,

  output logic          [NumTrv-1:0] leaf_valid_o,
  input  logic          [NumTrv-1:0] leaf_ready_i,
  input  logic          [NumTrv-1:0] leaf_lost_i,          // another TRV was served
  output ti_pkg::leaf_t              leaf_data_o [NumTrv],

  input  logic            [NumTrv-1:0] return_valid_i,
  output logic            [NumTrv-1:0] return_ready_o,
  input  ti_pkg::return_t              return_data_i [NumTrv],

  output logic                  [NumTrv-1:0] line_req_valid_o,
  input  logic                  [NumTrv-1:0] line_req_ready_i,
  output ti_mem_pkg::line_req_t              line_req_data_o [NumTrv],

  input  logic                  [NumTrv-1:0] line_rsp_valid_i,
  output logic                  [NumTrv-1:0] line_rsp_ready_o,
  input  ti_mem_pkg::line_rsp_t              line_rsp_data_i [NumTrv],

  output ti_count_pkg::rd_events_t  rd_events_o,
  output ti_count_pkg::trv_events_t trv_events_o[NumTrv]
);

  logic [NumTrv-1:0] dispatch_valid, dispatch_ready, trv_idle;
  ti_traverse_pkg::dispatch_t dispatch_data;

  // Hits of the TRVs, then RD's.
  logic [NumTrv:0] hit_valid, hit_ready, hit_lost;
  ti_pkg::hit_t hit_data[NumTrv+1];

  ti_count_pkg::rd_events_t rd_events;
  ti_count_pkg::trv_events_t trv_events[NumTrv];

  ti_rd #(
    .NumTrv   (NumTrv),
    .DealTile (ti_config_pkg::DealTile),
    .RayCycles(ti_config_pkg::RdCycles),
    .AnyHit   (ti_config_pkg::AnyHit)
  ) u_rd (
    .clk_i,
    .rst_ni,
    .box_lo_i,
    .box_hi_i,
    .ray_valid_i,
    .ray_ready_o,
    .ray_data_i,
    .dispatch_valid_o(dispatch_valid),
    .dispatch_ready_i(dispatch_ready),
    .dispatch_data_o (dispatch_data),
    .hit_valid_o     (hit_valid[NumTrv]),
    .hit_ready_i     (hit_ready[NumTrv]),
    .hit_data_o      (hit_data[NumTrv]),
    .events_o        (rd_events)
  );

  always_comb begin
    rd_events_o = rd_events;
    if (hit_lost[NumTrv]) begin
      rd_events_o.activity.room        = 1'b0;
      rd_events_o.activity.arbitration = rd_events.activity.room;
    end
  end

  for (genvar t = 0; t < NumTrv; t++) begin : gen_trv
    ti_trv #(
      .NumSlots     (ti_config_pkg::TrvSlots),
      .StackDepth   (ti_config_pkg::StackDepth),
      .WatchdogSteps(ti_config_pkg::WatchdogSteps),
      .AnyHit       (ti_config_pkg::AnyHit),
      .Restart      (ti_config_pkg::Restart),
      .Padded       (ti_config_pkg::Traversal == ti_config_pkg::TraversalPadded),
      .Rows         (ti_config_pkg::TrvRows),
      .CacheBytes   (ti_config_pkg::TrvL1Bytes),
      .Ways         (ti_config_pkg::TrvL1Ways)
    ) u_trv (
      .clk_i,
      .rst_ni,
      .flush_i,
      .idle_o          (trv_idle[t]),
      .index_i         (ti_pkg::trv_index_t'(t)),
      .node_base_i,
      .root_i,
      .dispatch_valid_i(dispatch_valid[t]),
      .dispatch_ready_o(dispatch_ready[t]),
      .dispatch_data_i (dispatch_data),
      .leaf_valid_o    (leaf_valid_o[t]),
      .leaf_ready_i    (leaf_ready_i[t]),
      .leaf_data_o     (leaf_data_o[t]),
      .return_valid_i  (return_valid_i[t]),
      .return_ready_o  (return_ready_o[t]),
      .return_data_i   (return_data_i[t]),
      .hit_valid_o     (hit_valid[t]),
      .hit_ready_i     (hit_ready[t]),
      .hit_data_o      (hit_data[t]),
      .line_req_valid_o(line_req_valid_o[t]),
      .line_req_ready_i(line_req_ready_i[t]),
      .line_req_data_o (line_req_data_o[t]),
      .line_rsp_valid_i(line_rsp_valid_i[t]),
      .line_rsp_ready_o(line_rsp_ready_o[t]),
      .line_rsp_data_i (line_rsp_data_i[t]),
      .events_o        (trv_events[t])
    );

    always_comb begin
      trv_events_o[t] = trv_events[t];
      if (leaf_lost_i[t] || hit_lost[t]) begin
        trv_events_o[t].activity.room        = 1'b0;
        trv_events_o[t].activity.arbitration = trv_events[t].activity.room;
      end
    end
  end

  // Hits in front of their arbiter: at once, or from `lookup_stages` 5 on out of a queue each.
  logic [NumTrv:0] queued_valid, queued_ready;
  ti_pkg::hit_t queued[NumTrv+1];
  for (genvar i = 0; i <= NumTrv; i++) begin : gen_hit
    if (ti_config_pkg::LookupStages < 5) begin : gen_at_once
      assign queued_valid[i] = hit_valid[i];
      assign hit_ready[i]    = queued_ready[i];
      assign queued[i]       = hit_data[i];
    end else begin : gen_queue
      ti_fifo #(
        .payload_t(ti_pkg::hit_t),
        .Depth    (2)
      ) u_queue (
        .clk_i,
        .rst_ni,
        .in_valid_i (hit_valid[i]),
        .in_ready_o (hit_ready[i]),
        .in_data_i  (hit_data[i]),
        .out_valid_o(queued_valid[i]),
        .out_ready_i(queued_ready[i]),
        .out_data_o (queued[i])
      );
    end
  end
  assign idle_o = &trv_idle;

  ti_arbiter #(
    .payload_t(ti_pkg::hit_t),
    .NumIn    (NumTrv + 1)
  ) u_hits (
    .clk_i,
    .rst_ni,
    .in_valid_i (queued_valid),
    .in_ready_o (queued_ready),
    .in_lost_o  (hit_lost),
    .in_data_i  (queued),
    .out_valid_o(hit_valid_o),
    .out_ready_i(hit_ready_i),
    .out_data_o (hit_data_o)
  );

  `TI_ASSERT_NEXT(OutHeldUntilTaken, hit_valid_o && !hit_ready_i, hit_valid_o && $stable(hit_data_o
                                                                                            ))
  `TI_ASSERT_KNOWN(RayReadyKnown, ray_ready_o)
  `TI_ASSERT_KNOWN(HitValidKnown, hit_valid_o)
  `TI_ASSERT_KNOWN(LeafValidKnown, leaf_valid_o)
  `TI_ASSERT_KNOWN(ReturnReadyKnown, return_ready_o)
  `TI_ASSERT_KNOWN(LineReqValidKnown, line_req_valid_o)
  `TI_ASSERT_KNOWN(LineRspReadyKnown, line_rsp_ready_o)

endmodule : ti_traverse
