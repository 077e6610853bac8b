// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// The intersection cluster: leaves in, results of their triangle tests out, to the home of the ray.
///
/// LISTs read the triangle numbers of a leaf, IST1s do passes (a) and (b), one IST2 pass (c).  The units of Woop's test
/// (`ti_woop_ist1`, `ti_woop_ist2`) stand in the places of Shevtsov's, with records at `plane_base_i`.  For each leaf
/// taken, return tokens whose counts add up to the leaf's come out, in any order.  Results never wait for leaves to be
/// taken.
///
/// LIST l serves the TRVs l, l + NumList, l + 2 NumList, ...  `ti_ist1_choice` names the IST1 of a test, anew in
/// each cycle in which the test waits.
module ti_intersect #(
  localparam int unsigned NumTrv   = ti_config_pkg::NumTrv,
  localparam int unsigned NumList  = ti_config_pkg::NumList,
  localparam int unsigned NumIst1  = ti_config_pkg::NumIst1,
  localparam int unsigned NumPorts = NumList + NumIst1
) (
  input  logic                clk_i,
  input  logic                rst_ni,
  input  logic                flush_i,        // forget all lines; only while idle
  output logic                idle_o,         // nothing inside, nothing on its way from memory
  // Where the scene stands.
  input  ti_mem_pkg::addr_t   list_base_i,
  input  ti_pkg::list_index_t num_list_i,
  input  ti_pkg::record_t     num_records_i,
  input  ti_mem_pkg::addr_t   plane_base_i,
  input  ti_mem_pkg::addr_t   bary_base_i,

  input  logic          [NumTrv-1:0] leaf_valid_i,
  output logic          [NumTrv-1:0] leaf_ready_o,
  output logic          [NumTrv-1:0] leaf_lost_o,          // another TRV was served
  input  ti_pkg::leaf_t              leaf_data_i [NumTrv],

  output logic            [NumTrv-1:0] return_valid_o,
  input  logic            [NumTrv-1:0] return_ready_i,
  output ti_pkg::return_t              return_data_o [NumTrv],

  // Lines: the ports of the LISTs, then those of the IST1s.
  output logic                  [NumPorts-1:0] line_req_valid_o,
  input  logic                  [NumPorts-1:0] line_req_ready_i,
  output ti_mem_pkg::line_req_t                line_req_data_o [NumPorts],

  input  logic                  [NumPorts-1:0] line_rsp_valid_i,
  output logic                  [NumPorts-1:0] line_rsp_ready_o,
  input  ti_mem_pkg::line_rsp_t                line_rsp_data_i [NumPorts],

  output ti_count_pkg::list_events_t list_events_o[NumList],
  output ti_count_pkg::ist1_events_t ist1_events_o[NumIst1],
  output ti_count_pkg::ist2_events_t ist2_events_o
);

  localparam int unsigned Ist1IndexWidth = (NumIst1 > 1) ? $clog2(NumIst1) : 1;

  logic [NumList-1:0] list_leaf_valid, list_leaf_ready, list_idle;
  ti_pkg::leaf_t list_leaf_data[NumList];
  logic [NumList-1:0] test_valid, test_ready, test_lost;
  ti_intersect_pkg::test_t test_data[NumList];
  logic [NumList-1:0][Ist1IndexWidth-1:0] test_dest;
  logic [NumList-1:0] list_return_valid, list_return_ready, list_return_lost;
  ti_pkg::return_t list_return_data[NumList];
  ti_count_pkg::list_events_t list_events[NumList];

  logic [NumIst1-1:0] ist1_test_valid, ist1_test_ready, ist1_crowded, ist1_idle;
  ti_intersect_pkg::test_t ist1_test_data[NumIst1];
  localparam bit Woop = ti_config_pkg::TriangleTest == ti_config_pkg::TriangleTestWoop;
  localparam int unsigned CandidateWidth = Woop ? $bits(
      ti_intersect_pkg::woop_candidate_t
  ) : $bits(
      ti_intersect_pkg::candidate_t
  );
  typedef logic [CandidateWidth-1:0] candidate_t;

  logic [NumIst1-1:0] candidate_valid, candidate_ready, candidate_lost;
  candidate_t candidate_data[NumIst1];
  ti_count_pkg::ist1_events_t ist1_events[NumIst1];

  logic ist2_candidate_valid, ist2_candidate_ready, ist2_idle;
  candidate_t ist2_candidate_data;
  ti_count_pkg::ist2_events_t ist2_events;

  // Return tokens: IST1s, then IST2, then the LISTs' errors.
  localparam int unsigned NumReturn = NumIst1 + 2;
  logic [NumReturn-1:0] result_valid, result_ready, result_lost;
  ti_pkg::return_t result_data[NumReturn];
  logic [NumReturn-1:0][ti_pkg::TrvIndexWidth-1:0] result_dest;

  // ---- LISTs.
  for (genvar l = 0; l < NumList; l++) begin : gen_list
    localparam int unsigned NumMine = (NumTrv - l + NumList - 1) / NumList;
    logic [NumMine-1:0] mine_valid, mine_ready, mine_lost;
    ti_pkg::leaf_t mine_data[NumMine];
    for (genvar k = 0; k < NumMine; k++) begin : gen_mine
      assign mine_valid[k] = leaf_valid_i[l+k*NumList];
      assign mine_data[k] = leaf_data_i[l+k*NumList];
      assign leaf_ready_o[l+k*NumList] = mine_ready[k];
      assign leaf_lost_o[l+k*NumList] = mine_lost[k];
    end

    ti_arbiter #(
      .payload_t(ti_pkg::leaf_t),
      .NumIn    (NumMine)
    ) u_leaves (
      .clk_i,
      .rst_ni,
      .in_valid_i (mine_valid),
      .in_ready_o (mine_ready),
      .in_lost_o  (mine_lost),
      .in_data_i  (mine_data),
      .out_valid_o(list_leaf_valid[l]),
      .out_ready_i(list_leaf_ready[l]),
      .out_data_o (list_leaf_data[l])
    );

    ti_list #(
      .NumSlots  (ti_config_pkg::ListSlots),
      .Rows      (ti_config_pkg::ListRows),
      .CacheBytes(ti_config_pkg::ListL1Bytes),
      .Ways      (ti_config_pkg::ListL1Ways)
    ) u_list (
      .clk_i,
      .rst_ni,
      .flush_i,
      .idle_o          (list_idle[l]),
      .list_base_i,
      .num_list_i,
      .num_records_i,
      .leaf_valid_i    (list_leaf_valid[l]),
      .leaf_ready_o    (list_leaf_ready[l]),
      .leaf_data_i     (list_leaf_data[l]),
      .test_valid_o    (test_valid[l]),
      .test_ready_i    (test_ready[l]),
      .test_data_o     (test_data[l]),
      .return_valid_o  (list_return_valid[l]),
      .return_ready_i  (list_return_ready[l]),
      .return_data_o   (list_return_data[l]),
      .line_req_valid_o(line_req_valid_o[l]),
      .line_req_ready_i(line_req_ready_i[l]),
      .line_req_data_o (line_req_data_o[l]),
      .line_rsp_valid_i(line_rsp_valid_i[l]),
      .line_rsp_ready_o(line_rsp_ready_o[l]),
      .line_rsp_data_i (line_rsp_data_i[l]),
      .events_o        (list_events[l])
    );

    always_comb begin
      list_events_o[l] = list_events[l];
      if (test_lost[l] || list_return_lost[l]) begin
        list_events_o[l].activity.room        = 1'b0;
        list_events_o[l].activity.arbitration = list_events[l].activity.room;
      end
    end

    ti_ist1_choice #(
      .NumIst1(NumIst1)
    ) u_choice (
      .record_i (test_data[l].record),
      .home_i   (test_data[l].home),
      .crowded_i(ist1_crowded),
      .index_o  (test_dest[l])
    );
  end

  ti_xbar #(
    .payload_t(ti_intersect_pkg::test_t),
    .NumIn    (NumList),
    .NumOut   (NumIst1)
  ) u_tests (
    .clk_i,
    .rst_ni,
    .in_valid_i (test_valid),
    .in_ready_o (test_ready),
    .in_lost_o  (test_lost),
    .in_data_i  (test_data),
    .in_dest_i  (test_dest),
    .out_valid_o(ist1_test_valid),
    .out_ready_i(ist1_test_ready),
    .out_data_o (ist1_test_data)
  );

  // ---- IST1s.
  for (genvar i = 0; i < NumIst1; i++) begin : gen_ist1
    if (Woop) begin : gen_woop
      ti_woop_ist1 #(
        .NumSlots  (ti_config_pkg::Ist1Slots),
        .Rows      (ti_config_pkg::Ist1Rows),
        .CacheBytes(ti_config_pkg::Ist1L1Bytes),
        .Ways      (ti_config_pkg::Ist1L1Ways),
        .Spill     (ti_config_pkg::Ist1Spill),
        .EarlyExit (ti_config_pkg::EarlyExit)
      ) u_ist1 (
        .clk_i,
        .rst_ni,
        .flush_i,
        .idle_o           (ist1_idle[i]),
        .corner_base_i    (plane_base_i),
        .test_valid_i     (ist1_test_valid[i]),
        .test_ready_o     (ist1_test_ready[i]),
        .test_data_i      (ist1_test_data[i]),
        .crowded_o        (ist1_crowded[i]),
        .candidate_valid_o(candidate_valid[i]),
        .candidate_ready_i(candidate_ready[i]),
        .candidate_data_o (candidate_data[i]),
        .return_valid_o   (result_valid[i]),
        .return_ready_i   (result_ready[i]),
        .return_data_o    (result_data[i]),
        .line_req_valid_o (line_req_valid_o[NumList+i]),
        .line_req_ready_i (line_req_ready_i[NumList+i]),
        .line_req_data_o  (line_req_data_o[NumList+i]),
        .line_rsp_valid_i (line_rsp_valid_i[NumList+i]),
        .line_rsp_ready_o (line_rsp_ready_o[NumList+i]),
        .line_rsp_data_i  (line_rsp_data_i[NumList+i]),
        .events_o         (ist1_events[i])
      );
      logic unused_bary;
      assign unused_bary = ^bary_base_i;
    end else begin : gen_shevtsov
      ti_ist1 #(
        .NumSlots  (ti_config_pkg::Ist1Slots),
        .Rows      (ti_config_pkg::Ist1Rows),
        .CacheBytes(ti_config_pkg::Ist1L1Bytes),
        .Ways      (ti_config_pkg::Ist1L1Ways),
        .Spill     (ti_config_pkg::Ist1Spill),
        .EarlyExit (ti_config_pkg::EarlyExit)
      ) u_ist1 (
        .clk_i,
        .rst_ni,
        .flush_i,
        .idle_o           (ist1_idle[i]),
        .plane_base_i,
        .bary_base_i,
        .test_valid_i     (ist1_test_valid[i]),
        .test_ready_o     (ist1_test_ready[i]),
        .test_data_i      (ist1_test_data[i]),
        .crowded_o        (ist1_crowded[i]),
        .candidate_valid_o(candidate_valid[i]),
        .candidate_ready_i(candidate_ready[i]),
        .candidate_data_o (candidate_data[i]),
        .return_valid_o   (result_valid[i]),
        .return_ready_i   (result_ready[i]),
        .return_data_o    (result_data[i]),
        .line_req_valid_o (line_req_valid_o[NumList+i]),
        .line_req_ready_i (line_req_ready_i[NumList+i]),
        .line_req_data_o  (line_req_data_o[NumList+i]),
        .line_rsp_valid_i (line_rsp_valid_i[NumList+i]),
        .line_rsp_ready_o (line_rsp_ready_o[NumList+i]),
        .line_rsp_data_i  (line_rsp_data_i[NumList+i]),
        .events_o         (ist1_events[i])
      );
    end

    always_comb begin
      ist1_events_o[i] = ist1_events[i];
      if (candidate_lost[i] || result_lost[i]) begin
        ist1_events_o[i].activity.room        = 1'b0;
        ist1_events_o[i].activity.arbitration = ist1_events[i].activity.room;
      end
    end
  end

  // ---- IST2.
  ti_arbiter #(
    .payload_t(candidate_t),
    .NumIn    (NumIst1)
  ) u_candidates (
    .clk_i,
    .rst_ni,
    .in_valid_i (candidate_valid),
    .in_ready_o (candidate_ready),
    .in_lost_o  (candidate_lost),
    .in_data_i  (candidate_data),
    .out_valid_o(ist2_candidate_valid),
    .out_ready_i(ist2_candidate_ready),
    .out_data_o (ist2_candidate_data)
  );

  if (Woop) begin : gen_woop_ist2
    ti_woop_ist2 u_ist2 (
      .clk_i,
      .rst_ni,
      .idle_o           (ist2_idle),
      .candidate_valid_i(ist2_candidate_valid),
      .candidate_ready_o(ist2_candidate_ready),
      .candidate_data_i (ist2_candidate_data),
      .return_valid_o   (result_valid[NumIst1]),
      .return_ready_i   (result_ready[NumIst1]),
      .return_data_o    (result_data[NumIst1]),
      .events_o         (ist2_events)
    );
  end else begin : gen_ist2
    ti_ist2 u_ist2 (
      .clk_i,
      .rst_ni,
      .idle_o           (ist2_idle),
      .candidate_valid_i(ist2_candidate_valid),
      .candidate_ready_o(ist2_candidate_ready),
      .candidate_data_i (ist2_candidate_data),
      .return_valid_o   (result_valid[NumIst1]),
      .return_ready_i   (result_ready[NumIst1]),
      .return_data_o    (result_data[NumIst1]),
      .events_o         (ist2_events)
    );
  end

  always_comb begin
    ist2_events_o = ist2_events;
    if (result_lost[NumIst1]) begin
      ist2_events_o.activity.room        = 1'b0;
      ist2_events_o.activity.arbitration = ist2_events.activity.room;
    end
  end

  // ---- The way home.
  ti_arbiter #(
    .payload_t(ti_pkg::return_t),
    .NumIn    (NumList)
  ) u_list_returns (
    .clk_i,
    .rst_ni,
    .in_valid_i (list_return_valid),
    .in_ready_o (list_return_ready),
    .in_lost_o  (list_return_lost),
    .in_data_i  (list_return_data),
    .out_valid_o(result_valid[NumIst1+1]),
    .out_ready_i(result_ready[NumIst1+1]),
    .out_data_o (result_data[NumIst1+1])
  );

  for (genvar r = 0; r < NumReturn; r++) begin : gen_result
    assign result_dest[r] = result_data[r].home.trv;
  end

  ti_xbar #(
    .payload_t(ti_pkg::return_t),
    .NumIn    (NumReturn),
    .NumOut   (NumTrv)
  ) u_returns (
    .clk_i,
    .rst_ni,
    .in_valid_i (result_valid),
    .in_ready_o (result_ready),
    .in_lost_o  (result_lost),
    .in_data_i  (result_data),
    .in_dest_i  (result_dest),
    .out_valid_o(return_valid_o),
    .out_ready_i(return_ready_i),
    .out_data_o (return_data_o)
  );

  assign idle_o = &list_idle && &ist1_idle && ist2_idle && return_valid_o == '0 &&
      result_valid == '0 && ist1_test_valid == '0 && list_leaf_valid == '0 && !ist2_candidate_valid;

  if (NumList > NumTrv) begin : gen_check_num_list
    $error("ti_intersect: NumList must not exceed NumTrv");
  end

  `TI_ASSERT_KNOWN(LeafReadyKnown, leaf_ready_o)
  `TI_ASSERT_KNOWN(ReturnValidKnown, return_valid_o)
  `TI_ASSERT_KNOWN(LineReqValidKnown, line_req_valid_o)
  `TI_ASSERT_KNOWN(LineRspReadyKnown, line_rsp_ready_o)

endmodule : ti_intersect
