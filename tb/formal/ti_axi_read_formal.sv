// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_axi_read` asks for each line once, by a burst of one beat that lies in its line and never crosses 4 KiB; it
/// holds each address until it is taken, uses no id again before its beat, and has at most `MaxReads` reads in flight.
/// A request is answered once, with the data of its own beat, and with an error exactly when that is SLVERR, DECERR or
/// without RLAST; beats that nobody asked for are dropped and counted.
module ti_axi_read_formal #(
  parameter  int unsigned Width      = 1,
  parameter  int unsigned MaxReads   = 2,
  localparam int unsigned AxiIdWidth = $clog2(MaxReads)
) (
  input logic                                          clk_i,
  input logic                                          rst_ni,
  input logic                                          req_valid_i,
  input logic                                          req_ready_o,
  input logic                      [        Width-1:0] req_id_i,
  input ti_mem_pkg::line_addr_t                        req_line_i,
  input logic                                          rsp_valid_o,
  input logic                                          rsp_ready_i,
  input logic                      [        Width-1:0] rsp_id_o,
  input ti_mem_pkg::line_t                             rsp_data_o,
  input logic                                          rsp_error_o,
  input logic                                          m_axi_arvalid,
  input logic                                          m_axi_arready,
  input logic                      [   AxiIdWidth-1:0] m_axi_arid,
  input ti_mem_pkg::addr_t                             m_axi_araddr,
  input logic                      [              7:0] m_axi_arlen,
  input logic                      [              2:0] m_axi_arsize,
  input logic                      [              1:0] m_axi_arburst,
  input logic                                          m_axi_arlock,
  input logic                      [              3:0] m_axi_arcache,
  input logic                      [              2:0] m_axi_arprot,
  input logic                      [              3:0] m_axi_arqos,
  input logic                                          m_axi_rvalid,
  input logic                                          m_axi_rready,
  input logic                      [   AxiIdWidth-1:0] m_axi_rid,
  input ti_mem_pkg::line_t                             m_axi_rdata,
  input logic                      [              1:0] m_axi_rresp,
  input logic                                          m_axi_rlast,
  input ti_count_pkg::axi_events_t                     events_o,
  input logic                      [2**AxiIdWidth-1:0] outstanding_q
);
  `TI_STARTS_IN_RESET

  localparam int unsigned LineBytes = ti_mem_pkg::LineBytes;
  localparam int unsigned CountWidth = $clog2(MaxReads + 1);
  localparam int unsigned Okay = 0;
  localparam int unsigned ExOkay = 1;
  localparam int unsigned Incrementing = 1;

  // Ids that have been asked under and whose beat has not come.
  logic req, ar, beat, rsp, is_answer, is_bad;
  logic [2**AxiIdWidth-1:0] asked_q;
  assign req       = req_valid_i && req_ready_o;
  assign ar        = m_axi_arvalid && m_axi_arready;
  assign beat      = m_axi_rvalid && m_axi_rready;
  assign rsp       = rsp_valid_o && rsp_ready_i;
  assign is_answer = beat && asked_q[m_axi_rid];
  assign is_bad    = (m_axi_rresp != 2'(Okay) && m_axi_rresp != 2'(ExOkay)) || !m_axi_rlast;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      asked_q <= '0;
    end else begin
      if (beat) asked_q[m_axi_rid] <= 1'b0;
      if (ar) asked_q[m_axi_arid] <= 1'b1;
    end
  end

  // Beats come under ids that have been asked under.  A stray one, of a read from before a reset, comes before its id
  // is used again: the interconnect is reset as well or whoever resets the engine waits, as the module's page asks.
  `TI_ASSUME(NoStrayUnderAnIdInUse, m_axi_rvalid && outstanding_q[m_axi_rid] -> asked_q[m_axi_rid])

  // Requests whose address has not been taken, whose beat has not come, and answers that wait.
  logic [CountWidth-1:0] reads_q;
  logic [1:0] asks_q, answers_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      asks_q    <= '0;
      reads_q   <= '0;
      answers_q <= '0;
    end else begin
      asks_q    <= asks_q + 2'(req) - 2'(ar);
      reads_q   <= reads_q + CountWidth'(req) - CountWidth'(is_answer);
      answers_q <= answers_q + 2'(is_answer) - 2'(rsp);
    end
  end

  // One request that is watched, whichever, and what comes before it on its way.
  typedef enum logic [1:0] {
    NotYet,
    Asks,    // its address is not taken
    Reads,   // its beat has not come
    Answers  // its answer is not taken
  } where_e;
  where_e where_q;
  logic pick, bad_q;
  logic [1:0] ahead_q;
  logic [Width-1:0] id_q;
  logic [AxiIdWidth-1:0] axi_id_q;
  ti_mem_pkg::line_addr_t line_q;
  ti_mem_pkg::line_t data_q;
  logic its_ar, its_beat, its_rsp;
  assign its_ar   = where_q == Asks && ahead_q == '0;
  assign its_beat = where_q == Reads && is_answer && m_axi_rid == axi_id_q;
  assign its_rsp  = where_q == Answers && ahead_q == '0;
  always_ff @(posedge clk_i) begin
    unique case (where_q)
      NotYet:  ahead_q <= asks_q - 2'(ar);
      Asks:    ahead_q <= ahead_q - 2'(ar);
      Reads:   ahead_q <= answers_q - 2'(rsp);
      default: ahead_q <= ahead_q - 2'(rsp);
    endcase
    if (where_q == NotYet) begin
      id_q   <= req_id_i;
      line_q <= req_line_i;
    end
    if (its_ar) axi_id_q <= m_axi_arid;
    if (where_q == Reads) begin
      data_q <= m_axi_rdata;
      bad_q  <= is_bad;
    end
    if (!rst_ni) begin
      where_q <= NotYet;
    end else begin
      if (where_q == NotYet && req && pick) where_q <= Asks;
      if (its_ar && ar) where_q <= Reads;
      if (its_beat) where_q <= Answers;
      if (its_rsp && rsp) where_q <= NotYet;
    end
  end

  // Reads that were asked for after it; one of them was answered before it.
  logic [2**AxiIdWidth-1:0] later_q;
  logic overtaken_q;
  always_ff @(posedge clk_i) begin
    if (where_q != Reads) begin
      later_q     <= '0;
      overtaken_q <= 1'b0;
    end else begin
      if (ar) later_q[m_axi_arid] <= 1'b1;
      if (is_answer && later_q[m_axi_rid]) overtaken_q <= 1'b1;
    end
  end

  // ---- AXI4.
  logic [8:0] beats;
  logic [31:0] bytes, first, last;
  assign beats = 9'(m_axi_arlen) + 1'b1;
  assign bytes = 32'(beats) << m_axi_arsize;
  assign first = 32'(m_axi_araddr[11:0]);
  assign last  = first + bytes - 1;
  // All that the channel says of a burst.
  logic [AxiIdWidth+$bits(m_axi_araddr)+24-1:0] address;
  assign address = {
    m_axi_arid,
    m_axi_araddr,
    m_axi_arlen,
    m_axi_arsize,
    m_axi_arburst,
    m_axi_arlock,
    m_axi_arcache,
    m_axi_arprot,
    m_axi_arqos
  };
  `TI_ASSERT_NEXT(AddressHeldUntilTaken, m_axi_arvalid && !m_axi_arready, m_axi_arvalid && $stable
                  (address))
  `TI_ASSERT(BurstOfOneLine, m_axi_arvalid -> bytes == LineBytes)
  `TI_ASSERT(BeatAsWideAsTheBus, m_axi_arvalid -> 8 << m_axi_arsize == $bits(m_axi_rdata))
  `TI_ASSERT(BeginsAtItsLine, m_axi_arvalid -> first % LineBytes == 0)
  `TI_ASSERT(NeverAcross4KiB, m_axi_arvalid -> last < 4096)
  `TI_ASSERT(AddressesGoUp, m_axi_arvalid -> m_axi_arburst == 2'(Incrementing))
  `TI_ASSERT(NormalMemory, m_axi_arvalid -> m_axi_arcache == 4'b0011 && m_axi_arprot == '0)
  `TI_ASSERT(NoLockNoQoS, m_axi_arvalid -> !m_axi_arlock && m_axi_arqos == '0)
  `TI_ASSERT(NoIdInUse, m_axi_arvalid -> !asked_q[m_axi_arid])

  // ---- Each request once.
  `TI_ASSERT(AddressWhileOneAsks, m_axi_arvalid == (asks_q != '0))
  `TI_ASSERT(AnswerWhileOneWaits, rsp_valid_o == (answers_q != '0))
  `TI_ASSERT(NeverMoreReads, 32'(reads_q) <= MaxReads)
  `TI_ASSERT(AsManyAsAreAsked, 32'(reads_q) == 32'(asks_q) + $countones(asked_q))
  `TI_ASSERT(TakesARequestWhileThereIsRoom,
             req_ready_o == (32'(reads_q) < MaxReads && asks_q != 2'd2))
  `TI_ASSERT(TakesABeatWhileThereIsRoom, m_axi_rready == (answers_q != 2'd2))
  `TI_ASSERT(AsksForItsLine, its_ar -> m_axi_arvalid && 32'(m_axi_araddr) == line_q * LineBytes)
  `TI_ASSERT(InFlightUntilItsBeat, where_q == Reads -> asked_q[axi_id_q])
  `TI_ASSERT(AnswerToWhoAsked, its_rsp -> rsp_valid_o && rsp_id_o == id_q)
  `TI_ASSERT(DataOfItsBeat, its_rsp -> rsp_data_o == data_q)
  `TI_ASSERT(ErrorOfItsBeat, its_rsp -> rsp_error_o == bad_q)

  // ---- What is counted.
  `TI_ASSERT(EachLineIsCounted, events_o.lines == req)
  `TI_ASSERT(EachErrorIsCounted, events_o.errors == (is_answer && is_bad))
  `TI_ASSERT(EachStrayIsCounted, events_o.strays == (beat && !is_answer))

  `TI_COVER(AllInFlight, 32'(reads_q) == MaxReads && asks_q == '0 && req_valid_i)
  `TI_COVER(OvertakenByALaterOne, its_beat && overtaken_q)
  `TI_COVER(WatchedFails, its_rsp && rsp && bad_q)
  `TI_COVER(Stray, beat && !is_answer && where_q == Reads)
endmodule : ti_axi_read_formal

// Numbers of lines and data are moved and not looked at: two bits, repeated, stand for all of theirs.
module ti_axi_read_top #(
  parameter  int unsigned MaxReads   = 2,
  localparam int unsigned AxiIdWidth = $clog2(MaxReads)
) (
  input  logic                               clk_i,
  input  logic                               rst_ni,
  input  logic                               req_valid_i,
  output logic                               req_ready_o,
  input  logic              [           1:0] req_id_i,
  input  logic              [           1:0] line_i,
  output logic                               rsp_valid_o,
  input  logic                               rsp_ready_i,
  output logic              [           1:0] rsp_id_o,
  output ti_mem_pkg::line_t                  rsp_data_o,
  output logic                               rsp_error_o,
  input  logic                               m_axi_arready,
  input  logic                               m_axi_rvalid,
  input  logic              [AxiIdWidth-1:0] m_axi_rid,
  input  logic              [           1:0] data_i,
  input  logic              [           1:0] m_axi_rresp,
  input  logic                               m_axi_rlast
);
  ti_axi_read #(
    .id_t    (logic [1:0]),
    .MaxReads(MaxReads)
  ) u_unit (
    .m_axi_arvalid(),
    .m_axi_arid   (),
    .m_axi_araddr (),
    .m_axi_arlen  (),
    .m_axi_arsize (),
    .m_axi_arburst(),
    .m_axi_arlock (),
    .m_axi_arcache(),
    .m_axi_arprot (),
    .m_axi_arqos  (),
    .m_axi_rready (),
    .req_line_i   ({ti_mem_pkg::LineAddrWidth / 2{line_i}}),
    .m_axi_rdata  ({ti_mem_pkg::LineBits / 2{data_i}}),
    .events_o     (),
    .*
  );
endmodule : ti_axi_read_top

bind ti_axi_read ti_axi_read_formal #(
  .Width   ($bits(id_t)),
  .MaxReads(MaxReads)
) u_formal (.*);
