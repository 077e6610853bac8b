// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Line requests to an AXI4 read port: one burst of one beat a line, the data bus as wide as a line.
///
/// At most `MaxReads` reads are outstanding.  ARID is the number of a free entry of the table that keeps the
/// identities of the requests, so answers may come in any order.  Outputs come from registers, RREADY too: 1 cycle for a
/// request, 1 for an answer; one a cycle each way.  SLVERR, DECERR and a beat without RLAST come back as an
/// error.  A beat under an id that is not outstanding is dropped and reported by the event `strays`: so beats that
/// a reset leaves behind do no harm while they come before their id is used again.  A reset in the middle of
/// traffic must therefore either reset the interconnect as well, as AXI4 asks, or be followed by no ray until the
/// reads in flight have been answered.
///
/// With a `Timeout` a read that has no answer after so many cycles, at most twice as many, is answered with an error; what
/// comes later is dropped (`ti_read_timeout`).  A memory that answers nothing any more answers errors, until reset.
///
/// ARCACHE is normal, non-cacheable, bufferable; ARPROT is unprivileged, secure data; no locks, no QoS.
module ti_axi_read #(
  /// What a request is known by.
  parameter type id_t = logic,
  /// Reads in flight, a power of two from 2 to 1024.
  parameter int unsigned MaxReads = 16,
  /// Cycles after which a read counts as failed; 0: never.
  parameter int unsigned Timeout = ti_config_pkg::ReadTimeout,
  localparam int unsigned LineBytes = ti_mem_pkg::LineBytes,
  localparam int unsigned AxiIdWidth = (MaxReads > 1) ? $clog2(MaxReads) : 1
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic                   req_valid_i,
  output logic                   req_ready_o,
  input  id_t                    req_id_i,
  input  ti_mem_pkg::line_addr_t req_line_i,

  output logic              rsp_valid_o,
  input  logic              rsp_ready_i,
  output id_t               rsp_id_o,
  output ti_mem_pkg::line_t rsp_data_o,
  output logic              rsp_error_o,

  output logic                               m_axi_arvalid,
  input  logic                               m_axi_arready,
  output logic              [AxiIdWidth-1:0] m_axi_arid,
  output ti_mem_pkg::addr_t                  m_axi_araddr,
  output logic              [           7:0] m_axi_arlen,
  output logic              [           2:0] m_axi_arsize,
  output logic              [           1:0] m_axi_arburst,
  output logic                               m_axi_arlock,
  output logic              [           3:0] m_axi_arcache,
  output logic              [           2:0] m_axi_arprot,
  output logic              [           3:0] m_axi_arqos,
  input  logic                               m_axi_rvalid,
  output logic                               m_axi_rready,
  input  logic              [AxiIdWidth-1:0] m_axi_rid,
  input  ti_mem_pkg::line_t                  m_axi_rdata,
  input  logic              [           1:0] m_axi_rresp,
  input  logic                               m_axi_rlast,

  output ti_count_pkg::axi_events_t events_o
);

  localparam int unsigned NumEntries = 1 << AxiIdWidth;
  typedef logic [AxiIdWidth-1:0] axi_id_t;

  typedef struct packed {
    axi_id_t                id;
    ti_mem_pkg::line_addr_t line;
  } ar_t;

  typedef struct packed {
    id_t               id;
    logic              error;
    ti_mem_pkg::line_t data;
  } rsp_t;

  // The table of reads in flight.
  logic free_valid, ar_room, take, beat, known;
  axi_id_t free_id;
  logic [NumEntries-1:0] outstanding_q;
  id_t beat_id;

  // Reads that are given up, and requests that are refused.
  logic [NumEntries-1:0] given_up;
  logic overdue_valid, overdue_taken, dead, refused_q, refused_taken;
  axi_id_t overdue_id;
  id_t refused_id_q;

  ti_slot_pool #(
    .NumSlots(NumEntries),
    .Late    (ti_config_pkg::LookupStages > 4)
  ) u_pool (
    .clk_i,
    .rst_ni,
    .free_valid_o(free_valid),
    .free_slot_o (free_id),
    .take_i      (take),
    .give_i      (beat && (known || given_up[m_axi_rid])),
    .give_slot_i (m_axi_rid)
  );

  assign req_ready_o = dead ? !refused_q : free_valid && ar_room;
  assign take        = req_valid_i && req_ready_o && !dead;
  assign beat        = m_axi_rvalid && m_axi_rready;
  assign known       = outstanding_q[m_axi_rid];

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      outstanding_q <= '0;
    end else begin
      if (beat) outstanding_q[m_axi_rid] <= 1'b0;
      if (overdue_taken) outstanding_q[overdue_id] <= 1'b0;
      if (take) outstanding_q[free_id] <= 1'b1;
    end
  end

  ti_regfile #(
    .Depth (NumEntries),
    .word_t(id_t)
  ) u_ids (
    .clk_i,
    .read_addr_i ((Timeout == 0 || m_axi_rvalid) ? m_axi_rid : overdue_id),
    .read_data_o (beat_id),
    .write_en_i  (take),
    .write_addr_i(free_id),
    .write_data_i(req_id_i)
  );

  // AR.
  ar_t ar;
  ti_fifo #(
    .payload_t(ar_t),
    .Depth    (2)
  ) u_ar (
    .clk_i,
    .rst_ni,
    .in_valid_i (req_valid_i && free_valid && !dead),
    .in_ready_o (ar_room),
    .in_data_i  ('{id: free_id, line: req_line_i}),
    .out_valid_o(m_axi_arvalid),
    .out_ready_i(m_axi_arready),
    .out_data_o (ar)
  );

  assign m_axi_arid    = ar.id;
  assign m_axi_araddr  = {ar.line, {$clog2(LineBytes) {1'b0}}};
  assign m_axi_arlen   = 8'd0;
  assign m_axi_arsize  = 3'($clog2(LineBytes));
  assign m_axi_arburst = 2'b01;
  assign m_axi_arlock  = 1'b0;
  assign m_axi_arcache = 4'b0011;
  assign m_axi_arprot  = 3'b000;
  assign m_axi_arqos   = 4'b0000;

  if (Timeout > 0) begin : gen_timeout
    ti_read_timeout #(
      .Timeout (Timeout),
      .NumReads(NumEntries)
    ) u_timeout (
      .clk_i,
      .rst_ni,
      .waiting_i      (req_valid_i && !dead),
      .take_i         (take),
      .take_id_i      (free_id),
      .beat_i         (beat),
      .beat_id_i      (m_axi_rid),
      .outstanding_i  (outstanding_q),
      .given_up_o     (given_up),
      .overdue_valid_o(overdue_valid),
      .overdue_id_o   (overdue_id),
      .overdue_taken_i(overdue_taken),
      .dead_o         (dead)
    );

    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) refused_q <= 1'b0;
      else refused_q <= (refused_q && !refused_taken) || (req_valid_i && req_ready_o && dead);
    end
    always_ff @(posedge clk_i) begin
      if (req_valid_i && req_ready_o && dead) refused_id_q <= req_id_i;
    end
  end else begin : gen_no_timeout
    assign given_up      = '0;
    assign overdue_valid = 1'b0;
    assign overdue_id    = '0;
    assign dead          = 1'b0;
    assign refused_q     = 1'b0;
    assign refused_id_q  = '0;
    logic unused_taken;
    assign unused_taken = overdue_taken || refused_taken;
  end

  // R: beats, and between them errors of our own.
  logic own, bad;
  rsp_t rsp;
  assign own           = !m_axi_rvalid && (overdue_valid || refused_q);
  assign bad           = m_axi_rresp[1] || !m_axi_rlast;
  assign overdue_taken = own && m_axi_rready && overdue_valid;
  assign refused_taken = own && m_axi_rready && !overdue_valid;
  ti_fifo #(
    .payload_t(rsp_t),
    .Depth    (2)
  ) u_rsp (
    .clk_i,
    .rst_ni,
    .in_valid_i(own || (m_axi_rvalid && known)),
    .in_ready_o(m_axi_rready),
    .in_data_i(
    '{id: (own && !overdue_valid) ? refused_id_q : beat_id, error: own || bad, data: m_axi_rdata}
    ),
    .out_valid_o(rsp_valid_o),
    .out_ready_i(rsp_ready_i),
    .out_data_o(rsp)
  );
  assign rsp_id_o    = rsp.id;
  assign rsp_error_o = rsp.error;
  assign rsp_data_o  = rsp.data;

  assign events_o.lines  = take;
  assign events_o.errors = (own && m_axi_rready) || (beat && known && bad);
  assign events_o.strays = beat && !known;
  always_comb begin
    events_o.activity       = '0;
    events_o.activity.works = take;
    if (!take) begin
      if (req_valid_i) events_o.activity.room = 1'b1;
      else if (outstanding_q != '0) events_o.activity.memory = 1'b1;
      else events_o.activity.empty = 1'b1;
    end
  end

  if (LineBytes < 8 || LineBytes > 128) begin : gen_check_line_bytes
    $error("ti_axi_read: LineBytes must be 8 to 128, the widths of an AXI4 data bus");
  end
  if (MaxReads < 2 || MaxReads > 1024 || MaxReads != NumEntries) begin : gen_check_max_reads
    $error("ti_axi_read: MaxReads must be a power of two from 2 to 1024");
  end

  `TI_ASSERT_NEXT(ArHeldUntilTaken, m_axi_arvalid && !m_axi_arready, m_axi_arvalid && $stable
                  ({m_axi_arid, m_axi_araddr}))
  `TI_ASSERT_NEXT(RspHeldUntilTaken, rsp_valid_o && !rsp_ready_i, rsp_valid_o && $stable
                  ({rsp_id_o, rsp_data_o, rsp_error_o}))
  `TI_ASSERT(OneActivity, $onehot(events_o.activity))
  `TI_COVER(TableFull, req_valid_i && !free_valid)
  `TI_COVER(StrayBeat, beat && !known)
  `TI_ASSERT_KNOWN(ReqReadyKnown, req_ready_o)
  `TI_ASSERT_KNOWN(RspValidKnown, rsp_valid_o)
  `TI_ASSERT_KNOWN(ArValidKnown, m_axi_arvalid)
  `TI_ASSERT_KNOWN(RReadyKnown, m_axi_rready)

endmodule : ti_axi_read
