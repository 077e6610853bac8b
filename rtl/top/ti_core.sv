// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// The traversal and intersection engine: rays in, hits out, the scene behind an AXI4 read port.
///
/// After the T&I Engine (Nah et al., ACM TOG 30(6), 2011).  Every ray that goes in comes out exactly
/// once; hits come in any order and carry the ray's number.  `scene_i` must be still while rays are
/// inside; another scene at the same address needs a reset, which empties the L1s.  The taker of hits
/// must not wait for rays to be accepted.  Throughput, size and number format follow the configuration
/// `ti_config_pkg`.
module ti_core #(
  localparam int unsigned NumTrv = ti_config_pkg::NumTrv,
  localparam int unsigned NumList = ti_config_pkg::NumList,
  localparam int unsigned NumIst1 = ti_config_pkg::NumIst1,
  localparam int unsigned TrvRows = ti_config_pkg::TrvRows,
  localparam int unsigned ListRows = ti_config_pkg::ListRows,
  localparam int unsigned Ist1Rows = ti_config_pkg::Ist1Rows,
  localparam int unsigned TrvRowWidth = (TrvRows > 1) ? $clog2(TrvRows) : 1,
  localparam int unsigned ListRowWidth = (ListRows > 1) ? $clog2(ListRows) : 1,
  localparam int unsigned Ist1RowWidth = (Ist1Rows > 1) ? $clog2(Ist1Rows) : 1,
  /// Width of ARID and RID: two bits for the kind of unit, then its port and row.
  localparam int unsigned AxiIdWidth = ti_pkg::memory_id_width(
      NumTrv, TrvRows, NumList, ListRows, NumIst1, Ist1Rows
  )
) (
  input logic clk_i,
  input logic rst_ni,
  input ti_pkg::scene_t scene_i,

  input  logic         ray_valid_i,
  output logic         ray_ready_o,
  input  ti_pkg::ray_t ray_data_i,

  output logic         hit_valid_o,
  input  logic         hit_ready_i,
  output ti_pkg::hit_t hit_data_o,

  output logic                           m_axi_arvalid,
  input  logic                           m_axi_arready,
  output logic          [AxiIdWidth-1:0] m_axi_arid,
  output ti_pkg::addr_t                  m_axi_araddr,
  output logic          [           7:0] m_axi_arlen,
  output logic          [           2:0] m_axi_arsize,
  output logic          [           1:0] m_axi_arburst,
  input  logic                           m_axi_rvalid,
  output logic                           m_axi_rready,
  input  logic          [AxiIdWidth-1:0] m_axi_rid,
  input  ti_pkg::line_t                  m_axi_rdata,
  input  logic          [           1:0] m_axi_rresp,
  input  logic                           m_axi_rlast,

  output ti_pkg::trv_counters_t  [ NumTrv-1:0] trv_counters_o,
  output ti_pkg::list_counters_t [NumList-1:0] list_counters_o,
  output ti_pkg::ist1_counters_t [NumIst1-1:0] ist1_counters_o,
  output ti_pkg::ist2_counters_t               ist2_counters_o
);

  localparam int unsigned Ist1IndexWidth = (NumIst1 > 1) ? $clog2(NumIst1) : 1;

  // Streams between the units.
  logic [NumTrv-1:0] dispatch_valid, dispatch_ready;
  ti_pkg::dispatch_t dispatch_data;
  logic [NumTrv:0] hit_valid, hit_ready;  // the last is RD's
  ti_pkg::hit_t [NumTrv:0] hit_data;
  logic [NumTrv-1:0] leaf_valid, leaf_ready, home_valid, home_ready;
  ti_pkg::leaf_t   [NumTrv-1:0] leaf_data;
  ti_pkg::return_t [NumTrv-1:0] home_data;

  logic [NumList-1:0] list_leaf_valid, list_leaf_ready;
  ti_pkg::leaf_t [NumList-1:0] list_leaf_data;
  logic [NumList-1:0] test_valid, test_ready, list_return_valid, list_return_ready;
  ti_pkg::test_t [NumList-1:0] test_data;
  ti_pkg::return_t [NumList-1:0] list_return_data;
  logic [NumList-1:0][Ist1IndexWidth-1:0] test_dest;

  logic [NumIst1-1:0] ist1_test_valid, ist1_test_ready, candidate_valid, candidate_ready;
  ti_pkg::test_t [NumIst1-1:0] ist1_test_data;
  ti_pkg::candidate_t [NumIst1-1:0] candidate_data;
  logic ist2_candidate_valid, ist2_candidate_ready;
  ti_pkg::candidate_t ist2_candidate_data;

  // Return tokens: IST1s, then IST2, then the LISTs' errors.
  localparam int unsigned NumReturn = NumIst1 + 2;
  logic [NumReturn-1:0] return_valid, return_ready;
  ti_pkg::return_t [NumReturn-1:0] return_data;
  logic [NumReturn-1:0][ti_pkg::TrvIndexWidth-1:0] return_dest;

  // Lines.
  logic [NumTrv-1:0] trv_req_valid, trv_req_ready, trv_rsp_valid;
  logic [NumTrv-1:0][TrvRowWidth-1:0] trv_req_row;
  ti_pkg::line_addr_t [NumTrv-1:0] trv_req_line;
  logic [NumList-1:0] list_req_valid, list_req_ready, list_rsp_valid;
  logic [NumList-1:0][ListRowWidth-1:0] list_req_row;
  ti_pkg::line_addr_t [NumList-1:0] list_req_line;
  logic [NumIst1-1:0] ist1_req_valid, ist1_req_ready, ist1_rsp_valid;
  logic [NumIst1-1:0][Ist1RowWidth-1:0] ist1_req_row;
  ti_pkg::line_addr_t [NumIst1-1:0] ist1_req_line;
  logic [TrvRowWidth-1:0] trv_rsp_row;
  logic [ListRowWidth-1:0] list_rsp_row;
  logic [Ist1RowWidth-1:0] ist1_rsp_row;
  logic rsp_error;
  ti_pkg::line_t rsp_data;

  ti_rd #(
    .NumTrv  (NumTrv),
    .DealTile(ti_config_pkg::DealTile)
  ) u_rd (
    .clk_i,
    .rst_ni,
    .box_lo_i        (scene_i.box_lo),
    .box_hi_i        (scene_i.box_hi),
    .ray_valid_i,
    .ray_ready_o,
    .ray_data_i,
    .dispatch_valid_o(dispatch_valid),
    .dispatch_ready_i(dispatch_ready),
    .dispatch_data_o (dispatch_data),
    .hit_valid_o     (hit_valid[NumTrv]),
    .hit_ready_i     (hit_ready[NumTrv]),
    .hit_data_o      (hit_data[NumTrv])
  );

  for (genvar t = 0; t < NumTrv; t++) begin : gen_trv
    ti_trv #(
      .NumSlots     (ti_config_pkg::TrvSlots),
      .StackDepth   (ti_config_pkg::StackDepth),
      .WatchdogSteps(ti_config_pkg::WatchdogSteps),
      .Rows         (TrvRows),
      .CacheBytes   (ti_config_pkg::TrvL1Bytes),
      .Ways         (ti_config_pkg::TrvL1Ways)
    ) u_trv (
      .clk_i,
      .rst_ni,
      .index_i         (ti_pkg::trv_index_t'(t)),
      .node_base_i     (scene_i.node_base),
      .root_i          (scene_i.root),
      .dispatch_valid_i(dispatch_valid[t]),
      .dispatch_ready_o(dispatch_ready[t]),
      .dispatch_data_i (dispatch_data),
      .leaf_valid_o    (leaf_valid[t]),
      .leaf_ready_i    (leaf_ready[t]),
      .leaf_data_o     (leaf_data[t]),
      .return_valid_i  (home_valid[t]),
      .return_ready_o  (home_ready[t]),
      .return_data_i   (home_data[t]),
      .hit_valid_o     (hit_valid[t]),
      .hit_ready_i     (hit_ready[t]),
      .hit_data_o      (hit_data[t]),
      .line_req_valid_o(trv_req_valid[t]),
      .line_req_ready_i(trv_req_ready[t]),
      .line_req_row_o  (trv_req_row[t]),
      .line_req_line_o (trv_req_line[t]),
      .line_rsp_valid_i(trv_rsp_valid[t]),
      .line_rsp_row_i  (trv_rsp_row),
      .line_rsp_data_i (rsp_data),
      .line_rsp_error_i(rsp_error),
      .counters_o      (trv_counters_o[t])
    );
  end

  // LIST l serves the TRVs l, l + NumList, l + 2 NumList, ...
  for (genvar l = 0; l < NumList; l++) begin : gen_list
    localparam int unsigned NumMine = (NumTrv - l + NumList - 1) / NumList;
    logic [NumMine-1:0] mine_valid, mine_ready;
    ti_pkg::leaf_t [NumMine-1:0] mine_data;
    for (genvar k = 0; k < NumMine; k++) begin : gen_mine
      assign mine_valid[k] = leaf_valid[l+k*NumList];
      assign mine_data[k] = leaf_data[l+k*NumList];
      assign leaf_ready[l+k*NumList] = mine_ready[k];
    end

    ti_arbiter #(
      .payload_t(ti_pkg::leaf_t),
      .NumIn    (NumMine)
    ) u_leaves (
      .clk_i,
      .rst_ni,
      .in_valid_i (mine_valid),
      .in_ready_o (mine_ready),
      .in_data_i  (mine_data),
      .out_valid_o(list_leaf_valid[l]),
      .out_ready_i(list_leaf_ready[l]),
      .out_data_o (list_leaf_data[l])
    );

    ti_list #(
      .NumSlots  (ti_config_pkg::ListSlots),
      .Rows      (ListRows),
      .CacheBytes(ti_config_pkg::ListL1Bytes),
      .Ways      (ti_config_pkg::ListL1Ways)
    ) u_list (
      .clk_i,
      .rst_ni,
      .list_base_i     (scene_i.list_base),
      .leaf_valid_i    (list_leaf_valid[l]),
      .leaf_ready_o    (list_leaf_ready[l]),
      .leaf_data_i     (list_leaf_data[l]),
      .test_valid_o    (test_valid[l]),
      .test_ready_i    (test_ready[l]),
      .test_data_o     (test_data[l]),
      .return_valid_o  (list_return_valid[l]),
      .return_ready_i  (list_return_ready[l]),
      .return_data_o   (list_return_data[l]),
      .line_req_valid_o(list_req_valid[l]),
      .line_req_ready_i(list_req_ready[l]),
      .line_req_row_o  (list_req_row[l]),
      .line_req_line_o (list_req_line[l]),
      .line_rsp_valid_i(list_rsp_valid[l]),
      .line_rsp_row_i  (list_rsp_row),
      .line_rsp_data_i (rsp_data),
      .line_rsp_error_i(rsp_error),
      .counters_o      (list_counters_o[l])
    );

    assign test_dest[l] = Ist1IndexWidth'(ist1_of(test_data[l].record));
  end

  // A triangle always goes to the same IST1, so the private L1s hold different triangles.
  // Pairs stay together: two plane parts share a line of 64 bytes.
  function automatic int unsigned ist1_of(input ti_pkg::record_t record);
    logic [9:0] folded;
    folded = record[10:1] ^ {record[13:11], record[20:14]} ^ {2'b00, record[28:21]};
    return 32'(folded) % NumIst1;
  endfunction

  ti_xbar #(
    .payload_t(ti_pkg::test_t),
    .NumIn    (NumList),
    .NumOut   (NumIst1)
  ) u_tests (
    .clk_i,
    .rst_ni,
    .in_valid_i (test_valid),
    .in_ready_o (test_ready),
    .in_data_i  (test_data),
    .in_dest_i  (test_dest),
    .out_valid_o(ist1_test_valid),
    .out_ready_i(ist1_test_ready),
    .out_data_o (ist1_test_data)
  );

  for (genvar i = 0; i < NumIst1; i++) begin : gen_ist1
    ti_ist1 #(
      .NumSlots  (ti_config_pkg::Ist1Slots),
      .Rows      (Ist1Rows),
      .CacheBytes(ti_config_pkg::Ist1L1Bytes),
      .Ways      (ti_config_pkg::Ist1L1Ways)
    ) u_ist1 (
      .clk_i,
      .rst_ni,
      .plane_base_i     (scene_i.plane_base),
      .bary_base_i      (scene_i.bary_base),
      .test_valid_i     (ist1_test_valid[i]),
      .test_ready_o     (ist1_test_ready[i]),
      .test_data_i      (ist1_test_data[i]),
      .candidate_valid_o(candidate_valid[i]),
      .candidate_ready_i(candidate_ready[i]),
      .candidate_data_o (candidate_data[i]),
      .return_valid_o   (return_valid[i]),
      .return_ready_i   (return_ready[i]),
      .return_data_o    (return_data[i]),
      .line_req_valid_o (ist1_req_valid[i]),
      .line_req_ready_i (ist1_req_ready[i]),
      .line_req_row_o   (ist1_req_row[i]),
      .line_req_line_o  (ist1_req_line[i]),
      .line_rsp_valid_i (ist1_rsp_valid[i]),
      .line_rsp_row_i   (ist1_rsp_row),
      .line_rsp_data_i  (rsp_data),
      .line_rsp_error_i (rsp_error),
      .counters_o       (ist1_counters_o[i])
    );
  end

  ti_arbiter #(
    .payload_t(ti_pkg::candidate_t),
    .NumIn    (NumIst1)
  ) u_candidates (
    .clk_i,
    .rst_ni,
    .in_valid_i (candidate_valid),
    .in_ready_o (candidate_ready),
    .in_data_i  (candidate_data),
    .out_valid_o(ist2_candidate_valid),
    .out_ready_i(ist2_candidate_ready),
    .out_data_o (ist2_candidate_data)
  );

  ti_ist2 u_ist2 (
    .clk_i,
    .rst_ni,
    .candidate_valid_i(ist2_candidate_valid),
    .candidate_ready_o(ist2_candidate_ready),
    .candidate_data_i (ist2_candidate_data),
    .return_valid_o   (return_valid[NumIst1]),
    .return_ready_i   (return_ready[NumIst1]),
    .return_data_o    (return_data[NumIst1]),
    .counters_o       (ist2_counters_o)
  );

  ti_arbiter #(
    .payload_t(ti_pkg::return_t),
    .NumIn    (NumList)
  ) u_list_returns (
    .clk_i,
    .rst_ni,
    .in_valid_i (list_return_valid),
    .in_ready_o (list_return_ready),
    .in_data_i  (list_return_data),
    .out_valid_o(return_valid[NumIst1+1]),
    .out_ready_i(return_ready[NumIst1+1]),
    .out_data_o (return_data[NumIst1+1])
  );

  for (genvar r = 0; r < NumReturn; r++) begin : gen_return
    assign return_dest[r] = return_data[r].home.trv;
  end

  ti_xbar #(
    .payload_t(ti_pkg::return_t),
    .NumIn    (NumReturn),
    .NumOut   (NumTrv)
  ) u_returns (
    .clk_i,
    .rst_ni,
    .in_valid_i (return_valid),
    .in_ready_o (return_ready),
    .in_data_i  (return_data),
    .in_dest_i  (return_dest),
    .out_valid_o(home_valid),
    .out_ready_i(home_ready),
    .out_data_o (home_data)
  );

  ti_arbiter #(
    .payload_t(ti_pkg::hit_t),
    .NumIn    (NumTrv + 1)
  ) u_hits (
    .clk_i,
    .rst_ni,
    .in_valid_i (hit_valid),
    .in_ready_o (hit_ready),
    .in_data_i  (hit_data),
    .out_valid_o(hit_valid_o),
    .out_ready_i(hit_ready_i),
    .out_data_o (hit_data_o)
  );

  ti_memory #(
    .NumTrv  (NumTrv),
    .NumList (NumList),
    .NumIst1 (NumIst1),
    .TrvRows (TrvRows),
    .ListRows(ListRows),
    .Ist1Rows(Ist1Rows)
  ) u_memory (
    .clk_i,
    .rst_ni,
    .trv_req_valid_i (trv_req_valid),
    .trv_req_ready_o (trv_req_ready),
    .trv_req_row_i   (trv_req_row),
    .trv_req_line_i  (trv_req_line),
    .trv_rsp_valid_o (trv_rsp_valid),
    .trv_rsp_row_o   (trv_rsp_row),
    .list_req_valid_i(list_req_valid),
    .list_req_ready_o(list_req_ready),
    .list_req_row_i  (list_req_row),
    .list_req_line_i (list_req_line),
    .list_rsp_valid_o(list_rsp_valid),
    .list_rsp_row_o  (list_rsp_row),
    .ist1_req_valid_i(ist1_req_valid),
    .ist1_req_ready_o(ist1_req_ready),
    .ist1_req_row_i  (ist1_req_row),
    .ist1_req_line_i (ist1_req_line),
    .ist1_rsp_valid_o(ist1_rsp_valid),
    .ist1_rsp_row_o  (ist1_rsp_row),
    .rsp_data_o      (rsp_data),
    .rsp_error_o     (rsp_error),
    .m_axi_arvalid,
    .m_axi_arready,
    .m_axi_arid,
    .m_axi_araddr,
    .m_axi_arlen,
    .m_axi_arsize,
    .m_axi_arburst,
    .m_axi_rvalid,
    .m_axi_rready,
    .m_axi_rid,
    .m_axi_rdata,
    .m_axi_rresp,
    .m_axi_rlast
  );

  if (NumList > NumTrv) begin : gen_check_num_list
    $error("ti_core: NumList must not exceed NumTrv");
  end

  `TI_ASSERT(OutHeldUntilTaken, hit_valid_o && !hit_ready_i |=> hit_valid_o && $stable(hit_data_o))

endmodule : ti_core
