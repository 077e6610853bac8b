// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// One bank of an L2: a `ti_ra` whose rays are requests of units and whose elements are whole lines.
///
/// So it is non-blocking: `Rows` lines are on their way at a time, units that need one of them gather in its row, and
/// one fill serves them all, one a cycle; hits pass.  A request has a slot by its nature, the unit and the id under
/// which it asks.  `Latency` cycles from a request to its answer on a hit, one a cycle: the requests run
/// through a delay that stands for the wires and the large memory, then `ti_ra`.
/// The sets of a bank hold the lines whose number ends in the bank's: inside, a line's number is turned so that
/// these bits are the highest.
module ti_l2_bank #(
  /// Units that ask, 1 or more, and ids of each.
  parameter int unsigned NumUnits = 1,
  parameter int unsigned UnitIds = 2,
  /// Banks beside this one and itself, a power of two.
  parameter int unsigned NumBanks = 1,
  parameter int unsigned CacheBytes = 1024,
  parameter int unsigned Ways = 2,
  parameter int unsigned Rows = 2,
  /// Cycles from a request to its answer on a hit, `ti_config_pkg::LookupStages` + 2 or more.
  parameter int unsigned Latency = 19,
  localparam int unsigned UnitWidth = (NumUnits > 1) ? $clog2(NumUnits) : 1
) (
  input  logic clk_i,
  input  logic rst_ni,
  input  logic flush_i,
  output logic idle_o,

  input  logic                                  req_valid_i,
  output logic                                  req_ready_o,
  input  logic                  [UnitWidth-1:0] req_unit_i,
  input  ti_mem_pkg::line_req_t                 req_data_i,

  output logic                                  rsp_valid_o,
  input  logic                                  rsp_ready_i,
  output logic                  [UnitWidth-1:0] rsp_unit_o,
  output ti_mem_pkg::line_rsp_t                 rsp_data_o,

  output logic                  line_req_valid_o,
  input  logic                  line_req_ready_i,
  output ti_mem_pkg::line_req_t line_req_data_o,

  input  logic                  line_rsp_valid_i,
  output logic                  line_rsp_ready_o,
  input  ti_mem_pkg::line_rsp_t line_rsp_data_i,

  output ti_count_pkg::l2_events_t events_o
);

  localparam int unsigned RaLatency = ti_config_pkg::LookupStages + 1;
  localparam int unsigned QueueLatency = 1;
  localparam int unsigned LeastLatency = QueueLatency + RaLatency;
  localparam int unsigned DelayCycles = (Latency > LeastLatency) ? Latency - LeastLatency : 0;
  // Requests on their way to the look-up: enough for one a cycle.
  localparam int unsigned Depth = DelayCycles + QueueLatency + 1;
  localparam int unsigned IdWidth = (UnitIds > 1) ? $clog2(UnitIds) : 1;
  localparam int unsigned NumSlots = NumUnits << IdWidth;
  localparam int unsigned SlotWidth = $clog2(NumSlots);
  localparam int unsigned BankBits = $clog2(NumBanks);
  localparam int unsigned LineAddrWidth = ti_mem_pkg::LineAddrWidth;
  localparam int unsigned LineBytes = ti_mem_pkg::LineBytes;
  typedef ti_mem_pkg::line_addr_t line_addr_t;

  typedef struct packed {
    logic [SlotWidth-1:0] slot;
    line_addr_t           line;  // turned
  } lookup_t;

  // A bank's number at the top.
  lookup_t taken, late, lookup;
  line_addr_t line_in, line_out;
  assign line_in = req_data_i.line;
  assign taken.slot = SlotWidth'({req_unit_i, req_data_i.id[IdWidth-1:0]});
  assign taken.line = (line_in >> BankBits) | (line_in << (LineAddrWidth - BankBits));

  // The delay never stalls: credits bound what is in it and in the queue behind it.
  logic take, late_valid, lookup_valid, lookup_ready, leaves;
  logic all_back;
  assign take   = req_valid_i && req_ready_o;
  assign leaves = lookup_valid && lookup_ready;

  ti_credits #(
    .Num(Depth)
  ) u_credits (
    .clk_i,
    .rst_ni,
    .take_i(take),
    .give_i(leaves),
    .any_o (req_ready_o),
    .all_o (all_back)
  );

  if (DelayCycles == 0) begin : gen_no_delay
    assign late_valid = take;
  end else begin : gen_delay
    logic [DelayCycles-1:0] valid_q;
    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) valid_q <= '0;
      else valid_q <= DelayCycles'({valid_q, take});
    end
    assign late_valid = valid_q[DelayCycles-1];
  end
  ti_delay #(
    .payload_t(lookup_t),
    .Cycles   (DelayCycles)
  ) u_delay (
    .clk_i,
    .rst_ni,
    .data_i(taken),
    .data_o(late)
  );

  ti_queue #(
    .payload_t(lookup_t),
    .Depth    (Depth)
  ) u_lookups (
    .clk_i,
    .rst_ni,
    .push_i     (late_valid),
    .push_data_i(late),
    .out_valid_o(lookup_valid),
    .out_ready_i(lookup_ready),
    .out_data_o (lookup)
  );

  logic ra_idle, ra_waits, rsp_error;
  logic [SlotWidth-1:0] rsp_slot;
  ti_mem_pkg::line_t rsp_line;
  ti_mem_pkg::line_req_t ra_req;
  ti_count_pkg::cache_events_t cache_events;

  ti_ra #(
    .NumSlots  (NumSlots),
    .Rows      (Rows),
    .ElemBytes (LineBytes),
    .CacheBytes(CacheBytes),
    .Ways      (Ways)
  ) u_ra (
    .clk_i,
    .rst_ni,
    .flush_i,
    .idle_o         (ra_idle),
    .waits_o        (ra_waits),
    .req_valid_i    (lookup_valid),
    .req_ready_o    (lookup_ready),
    .req_slot_i     (lookup.slot),
    .req_addr_i     ({lookup.line, {$clog2(LineBytes) {1'b0}}}),
    .rsp_valid_o,
    .rsp_ready_i,
    .rsp_slot_o     (rsp_slot),
    .rsp_elem_o     (rsp_line),
    .rsp_error_o    (rsp_error),
    .line_req_valid_o,
    .line_req_ready_i,
    .line_req_data_o(ra_req),
    .line_rsp_valid_i,
    .line_rsp_ready_o,
    .line_rsp_data_i,
    .events_o       (cache_events)
  );

  assign line_out = ra_req.line;
  assign line_req_data_o = '{
          id: ra_req.id,
          line: (line_out << BankBits) | (line_out >> (LineAddrWidth - BankBits))
      };
  assign rsp_unit_o = UnitWidth'(rsp_slot >> IdWidth);
  assign rsp_data_o = '{
          id: ti_mem_pkg::row_id_t'(rsp_slot[IdWidth-1:0]),
          error: rsp_error,
          data: rsp_line
      };
  assign idle_o = all_back && ra_idle;

  // What happens, for counting.
  assign events_o.accesses = cache_events.l1_accesses;
  assign events_o.hits = cache_events.l1_hits;
  assign events_o.merged = cache_events.l1_merged;
  assign events_o.misses = cache_events.l1_misses;
  always_comb begin
    events_o.activity = '0;
    if (cache_events.l1_accesses) events_o.activity.works = 1'b1;
    else if (rsp_valid_o && !rsp_ready_i) events_o.activity.room = 1'b1;
    else if (ra_waits) events_o.activity.memory = 1'b1;
    else if (!idle_o) events_o.activity.latency = 1'b1;
    else events_o.activity.empty = 1'b1;
  end

  if (NumUnits < 1 || UnitIds < 1 || IdWidth > ti_mem_pkg::RowIdWidth) begin : gen_check_units
    $error(
        "ti_l2_bank: NumUnits and UnitIds must be 1 or more, UnitIds at most the ids of row_id_t"
    );
  end
  if (NumBanks < 1 || (NumBanks & (NumBanks - 1)) != 0 || BankBits >= LineAddrWidth)
  begin : gen_check_banks
    $error("ti_l2_bank: NumBanks must be a power of two, less than the lines of memory");
  end
  if (Latency < LeastLatency) begin : gen_check_latency
    $error("ti_l2_bank: Latency must be LookupStages + 2 or more");
  end

  `TI_ASSERT(AsksWithItsIds,
             req_valid_i -> 32'(req_data_i.id) < 2 ** IdWidth && 32'(req_unit_i) < NumUnits)
  `TI_ASSERT_KNOWN(ReqReadyKnown, req_ready_o)
  `TI_ASSERT_KNOWN(RspValidKnown, rsp_valid_o)
  `TI_ASSERT_KNOWN(LineReqValidKnown, line_req_valid_o)

endmodule : ti_l2_bank
