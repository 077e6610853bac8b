// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The L2 of one kind of unit: a non-blocking cache in `NumBanks` banks.
///
/// The low bits of a line's number choose its bank; requests cross to the banks (`ti_xbar`), answers of each bank
/// come back to the unit that asked.  Each bank answers a line a cycle, so as many units as there are banks have an
/// answer in one cycle.  `Latency` cycles from a request to its answer when the line is here and nobody else asks.
/// A line that several units wait for is asked for once (`ti_l2_bank`).
/// An answer that has been offered stays until it is taken; units that take answers at once never hold a bank up.
/// Memory's answers are always taken.  `flush_i` forgets all lines and is up only while `idle_o` is.
module ti_l2 #(
  /// Units of the kind, 1 or more.
  parameter int unsigned NumUnits = 1,
  /// Ids under which a unit asks, 0 to UnitIds - 1.
  parameter int unsigned UnitIds = 2,
  /// A power of two.
  parameter int unsigned NumBanks = 1,
  /// Of all banks together.
  parameter int unsigned CacheBytes = 1024,
  parameter int unsigned Ways = 2,
  /// Lines on their way to a bank.
  parameter int unsigned Rows = 2,
  /// Cycles from a request to its answer on a hit, `ti_config_pkg::LookupStages` + 3 or more.
  parameter int unsigned Latency = 20
) (
  input  logic clk_i,
  input  logic rst_ni,
  input  logic flush_i,
  output logic idle_o,

  // From and to the units.
  input  logic                  [NumUnits-1:0] line_req_valid_i,
  output logic                  [NumUnits-1:0] line_req_ready_o,
  input  ti_mem_pkg::line_req_t                line_req_data_i [NumUnits],

  output logic                  [NumUnits-1:0] line_rsp_valid_o,
  input  logic                  [NumUnits-1:0] line_rsp_ready_i,
  output ti_mem_pkg::line_rsp_t                line_rsp_data_o [NumUnits],

  // To and from memory, a port a bank.
  output logic                  [NumBanks-1:0] bank_req_valid_o,
  input  logic                  [NumBanks-1:0] bank_req_ready_i,
  output ti_mem_pkg::line_req_t                bank_req_data_o [NumBanks],

  input  logic                  [NumBanks-1:0] bank_rsp_valid_i,
  output logic                  [NumBanks-1:0] bank_rsp_ready_o,
  input  ti_mem_pkg::line_rsp_t                bank_rsp_data_i [NumBanks],

  output ti_count_pkg::l2_events_t events_o[NumBanks]
);

  localparam int unsigned BankWidth = (NumBanks > 1) ? $clog2(NumBanks) : 1;
  localparam int unsigned UnitWidth = (NumUnits > 1) ? $clog2(NumUnits) : 1;
  localparam int unsigned CrossLatency = 1;
  // Values that the checks below refuse must not stop elaboration in another way.
  localparam int unsigned BankLatency = (Latency > CrossLatency) ? Latency - CrossLatency : 0;
  localparam int unsigned BankBytes = CacheBytes / ((NumBanks > 0) ? NumBanks : 1);
  typedef logic [BankWidth-1:0] bank_t;
  typedef logic [UnitWidth-1:0] unit_t;

  typedef struct packed {
    unit_t                 index;
    ti_mem_pkg::line_req_t req;
  } unit_req_t;

  // To the banks.
  unit_req_t unit_req[NumUnits];
  logic [NumUnits-1:0][BankWidth-1:0] bank_of;
  logic [NumUnits-1:0] lost;
  logic [NumBanks-1:0] req_valid, req_ready;
  unit_req_t req[NumBanks];

  for (genvar u = 0; u < NumUnits; u++) begin : gen_request
    assign unit_req[u] = '{index: unit_t'(u), req: line_req_data_i[u]};
    assign bank_of[u]  = (NumBanks > 1) ? line_req_data_i[u].line[BankWidth-1:0] : '0;
  end

  ti_xbar #(
    .payload_t(unit_req_t),
    .NumIn    (NumUnits),
    .NumOut   (NumBanks)
  ) u_requests (
    .clk_i,
    .rst_ni,
    .in_valid_i (line_req_valid_i),
    .in_ready_o (line_req_ready_o),
    .in_lost_o  (lost),
    .in_data_i  (unit_req),
    .in_dest_i  (bank_of),
    .out_valid_o(req_valid),
    .out_ready_i(req_ready),
    .out_data_o (req)
  );
  logic unused_lost;
  assign unused_lost = |lost;

  // The banks.
  logic [NumBanks-1:0] idle, rsp_valid, rsp_ready;
  unit_t rsp_unit[NumBanks];
  ti_mem_pkg::line_rsp_t rsp[NumBanks];

  for (genvar b = 0; b < NumBanks; b++) begin : gen_bank
    ti_l2_bank #(
      .NumUnits  (NumUnits),
      .UnitIds   (UnitIds),
      .NumBanks  (NumBanks),
      .CacheBytes(BankBytes),
      .Ways      (Ways),
      .Rows      (Rows),
      .Latency   (BankLatency)
    ) u_bank (
      .clk_i,
      .rst_ni,
      .flush_i,
      .idle_o          (idle[b]),
      .req_valid_i     (req_valid[b]),
      .req_ready_o     (req_ready[b]),
      .req_unit_i      (req[b].index),
      .req_data_i      (req[b].req),
      .rsp_valid_o     (rsp_valid[b]),
      .rsp_ready_i     (rsp_ready[b]),
      .rsp_unit_o      (rsp_unit[b]),
      .rsp_data_o      (rsp[b]),
      .line_req_valid_o(bank_req_valid_o[b]),
      .line_req_ready_i(bank_req_ready_i[b]),
      .line_req_data_o (bank_req_data_o[b]),
      .line_rsp_valid_i(bank_rsp_valid_i[b]),
      .line_rsp_ready_o(bank_rsp_ready_o[b]),
      .line_rsp_data_i (bank_rsp_data_i[b]),
      .events_o        (events_o[b])
    );
  end
  assign idle_o = &idle && req_valid == '0;

  // Back to the units: each takes the banks in turn, and stays with one until its answer is taken.
  logic [NumUnits-1:0][NumBanks-1:0] mine, taken;
  for (genvar u = 0; u < NumUnits; u++) begin : gen_answer
    bank_t from_q, index;
    logic any;
    for (genvar b = 0; b < NumBanks; b++) begin : gen_mine
      assign mine[u][b] = rsp_valid[b] && rsp_unit[b] == unit_t'(u);
    end

    ti_round_robin #(
      .Num(NumBanks)
    ) u_choice (
      .request_i(mine[u]),
      .from_i   (from_q),
      .any_o    (any),
      .index_o  (index)
    );

    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) from_q <= '0;
      else if (any) begin
        if (!line_rsp_ready_i[u]) from_q <= index;
        else from_q <= (index == bank_t'(NumBanks - 1)) ? '0 : index + 1'b1;
      end
    end

    assign line_rsp_valid_o[u] = any;
    assign line_rsp_data_o[u] = rsp[index];
    assign taken[u] = (any && line_rsp_ready_i[u]) ? NumBanks'(1) << index : '0;

    // Names of the module: of a name of this block, Verilator takes $stable for that of block 0.
    `TI_ASSERT_NEXT(OutHeldUntilTaken, line_rsp_valid_o[u] && !line_rsp_ready_i[u],
                    line_rsp_valid_o[u] && $stable(line_rsp_data_o[u]))
  end

  always_comb begin
    rsp_ready = '0;
    for (int unsigned u = 0; u < NumUnits; u++) rsp_ready |= taken[u];
  end

  if (NumBanks < 1 || (NumBanks & (NumBanks - 1)) != 0) begin : gen_check_banks
    $error("ti_l2: NumBanks must be a power of two");
  end
  if (BankBytes * NumBanks != CacheBytes) begin : gen_check_cache_bytes
    $error("ti_l2: CacheBytes must divide into NumBanks banks");
  end
  if (NumUnits < 1) begin : gen_check_units
    $error("ti_l2: NumUnits must be 1 or more");
  end
  if (Latency < ti_config_pkg::LookupStages + 3) begin : gen_check_latency
    $error("ti_l2: Latency must be LookupStages + 3 or more");
  end

  `TI_ASSERT(AnswersOneUnit, (rsp_ready & ~rsp_valid) == '0)
  `TI_COVER(TwoAnswersAtOnce, $countones(rsp_ready) > 1)
  `TI_ASSERT_KNOWN(LineReqReadyKnown, line_req_ready_o)
  `TI_ASSERT_KNOWN(LineRspValidKnown, line_rsp_valid_o)
  `TI_ASSERT_KNOWN(BankReqValidKnown, bank_req_valid_o)
  `TI_ASSERT_KNOWN(BankRspReadyKnown, bank_rsp_ready_o)

endmodule : ti_l2
