// SPDX-License-Identifier: Apache-2.0

/// One core: rays in, hits out, the scene behind one line port a unit.
///
/// After the T&I Engine (Nah et al., ACM TOG 30(6), 2011).  Every ray that goes in comes out exactly once; hits come
/// in any order and carry the ray's number.  `scene_i` must be still while a ray is inside.  The taker of hits must
/// not wait for rays to be accepted.  Throughput, size and number format follow `ti_config_pkg`.
///
/// `count_o` is counter `count_event_i` of unit `count_unit_i` (`ti_count_pkg`), 1 cycle after it was asked for.
module ti_core #(
  localparam int unsigned NumTrv   = ti_config_pkg::NumTrv,
  localparam int unsigned NumList  = ti_config_pkg::NumList,
  localparam int unsigned NumIst1  = ti_config_pkg::NumIst1,
  localparam int unsigned NumPorts = ti_mem_pkg::NumPorts
) (
  input  logic           clk_i,
  input  logic           rst_ni,
  input  logic           flush_i,  // forget all lines; only while no ray is inside
  output logic           idle_o,   // behind RD nothing is inside or on its way
  input  ti_pkg::scene_t scene_i,

  input  logic         ray_valid_i,
  output logic         ray_ready_o,
  input  ti_pkg::ray_t ray_data_i,

  output logic         hit_valid_o,
  input  logic         hit_ready_i,
  output ti_pkg::hit_t hit_data_o,

  output logic                  [NumPorts-1:0] line_req_valid_o,
  input  logic                  [NumPorts-1:0] line_req_ready_i,
  output ti_mem_pkg::line_req_t                line_req_data_o [NumPorts],

  input  logic                  [NumPorts-1:0] line_rsp_valid_i,
  output logic                  [NumPorts-1:0] line_rsp_ready_o,
  input  ti_mem_pkg::line_rsp_t                line_rsp_data_i [NumPorts],

  input  logic                       count_run_i,    // counters count
  input  logic                       snapshot_i,     // and are copied (`counter_snapshot`)
  input  ti_count_pkg::unit_index_t  count_unit_i,
  input  ti_count_pkg::event_index_t count_event_i,
  output ti_count_pkg::count_t       count_o
);

  logic traverse_idle, intersect_idle;
  logic [NumTrv-1:0] leaf_valid, leaf_ready, leaf_lost, return_valid, return_ready;
  ti_pkg::leaf_t leaf_data[NumTrv];
  ti_pkg::return_t return_data[NumTrv];

  ti_mem_pkg::line_req_t traverse_req[NumTrv];
  ti_mem_pkg::line_rsp_t traverse_rsp[NumTrv];
  ti_mem_pkg::line_req_t intersect_req[NumList+NumIst1];
  ti_mem_pkg::line_rsp_t intersect_rsp[NumList+NumIst1];

  ti_count_pkg::rd_events_t rd_events;
  ti_count_pkg::trv_events_t trv_events[NumTrv];
  ti_count_pkg::list_events_t list_events[NumList];
  ti_count_pkg::ist1_events_t ist1_events[NumIst1];
  ti_count_pkg::ist2_events_t ist2_events;

  for (genvar p = 0; p < NumPorts; p++) begin : gen_port
    if (p < NumTrv) begin : gen_traverse
      assign line_req_data_o[p] = traverse_req[p];
      assign traverse_rsp[p] = line_rsp_data_i[p];
    end else begin : gen_intersect
      assign line_req_data_o[p] = intersect_req[p-NumTrv];
      assign intersect_rsp[p-NumTrv] = line_rsp_data_i[p];
    end
  end

  ti_traverse u_traverse (
    .clk_i,
    .rst_ni,
    .flush_i,
    .idle_o          (traverse_idle),
    .root_i          (scene_i.root),
    .node_base_i     (scene_i.node_base),
    .box_lo_i        (scene_i.box_lo),
    .box_hi_i        (scene_i.box_hi),
    .ray_valid_i,
    .ray_ready_o,
    .ray_data_i,
    .hit_valid_o,
    .hit_ready_i,
    .hit_data_o,
    .leaf_valid_o    (leaf_valid),
    .leaf_ready_i    (leaf_ready),
    .leaf_lost_i     (leaf_lost),
    .leaf_data_o     (leaf_data),
    .return_valid_i  (return_valid),
    .return_ready_o  (return_ready),
    .return_data_i   (return_data),
    .line_req_valid_o(line_req_valid_o[NumTrv-1:0]),
    .line_req_ready_i(line_req_ready_i[NumTrv-1:0]),
    .line_req_data_o (traverse_req),
    .line_rsp_valid_i(line_rsp_valid_i[NumTrv-1:0]),
    .line_rsp_ready_o(line_rsp_ready_o[NumTrv-1:0]),
    .line_rsp_data_i (traverse_rsp),
    .rd_events_o     (rd_events),
    .trv_events_o    (trv_events)
  );

  ti_intersect u_intersect (
    .clk_i,
    .rst_ni,
    .flush_i,
    .idle_o          (intersect_idle),
    .list_base_i     (scene_i.list_base),
    .num_list_i      (scene_i.num_list),
    .num_records_i   (scene_i.num_records),
    .plane_base_i    (scene_i.plane_base),
    .bary_base_i     (scene_i.bary_base),
    .leaf_valid_i    (leaf_valid),
    .leaf_ready_o    (leaf_ready),
    .leaf_lost_o     (leaf_lost),
    .leaf_data_i     (leaf_data),
    .return_valid_o  (return_valid),
    .return_ready_i  (return_ready),
    .return_data_o   (return_data),
    .line_req_valid_o(line_req_valid_o[NumPorts-1:NumTrv]),
    .line_req_ready_i(line_req_ready_i[NumPorts-1:NumTrv]),
    .line_req_data_o (intersect_req),
    .line_rsp_valid_i(line_rsp_valid_i[NumPorts-1:NumTrv]),
    .line_rsp_ready_o(line_rsp_ready_o[NumPorts-1:NumTrv]),
    .line_rsp_data_i (intersect_rsp),
    .list_events_o   (list_events),
    .ist1_events_o   (ist1_events),
    .ist2_events_o   (ist2_events)
  );

  assign idle_o = traverse_idle && intersect_idle;

  // A bank of counters beside each unit, in the order of `ti_count_pkg`.
  ti_count_pkg::count_t counts[ti_count_pkg::NumUnits];
  assign counts[ti_count_pkg::UnitAxi] = '0;  // that unit is not part of the core

  ti_counters #(
    .Num(ti_count_pkg::NumRdEvents)
  ) u_rd_counters (
    .clk_i,
    .rst_ni,
    .run_i   (count_run_i),
    .snapshot_i,
    .events_i(rd_events),
    .index_i (count_event_i),
    .count_o (counts[ti_count_pkg::UnitRd])
  );
  for (genvar t = 0; t < NumTrv; t++) begin : gen_trv_counters
    ti_counters #(
      .Num(ti_count_pkg::NumTrvEvents)
    ) u_counters (
      .clk_i,
      .rst_ni,
      .run_i   (count_run_i),
      .snapshot_i,
      .events_i(trv_events[t]),
      .index_i (count_event_i),
      .count_o (counts[ti_count_pkg::UnitTrv+t])
    );
  end
  for (genvar l = 0; l < NumList; l++) begin : gen_list_counters
    ti_counters #(
      .Num(ti_count_pkg::NumListEvents)
    ) u_counters (
      .clk_i,
      .rst_ni,
      .run_i   (count_run_i),
      .snapshot_i,
      .events_i(list_events[l]),
      .index_i (count_event_i),
      .count_o (counts[ti_count_pkg::UnitList+l])
    );
  end
  for (genvar i = 0; i < NumIst1; i++) begin : gen_ist1_counters
    ti_counters #(
      .Num(ti_count_pkg::NumIst1Events)
    ) u_counters (
      .clk_i,
      .rst_ni,
      .run_i   (count_run_i),
      .snapshot_i,
      .events_i(ist1_events[i]),
      .index_i (count_event_i),
      .count_o (counts[ti_count_pkg::UnitIst1+i])
    );
  end
  ti_counters #(
    .Num(ti_count_pkg::NumIst2Events)
  ) u_ist2_counters (
    .clk_i,
    .rst_ni,
    .run_i   (count_run_i),
    .snapshot_i,
    .events_i(ist2_events),
    .index_i (count_event_i),
    .count_o (counts[ti_count_pkg::UnitIst2])
  );

  ti_count_pkg::unit_index_t count_unit_q;
  always_ff @(posedge clk_i) count_unit_q <= count_unit_i;
  assign count_o = (32'(count_unit_q) < ti_count_pkg::NumUnits) ? counts[count_unit_q] : '0;

endmodule : ti_core
