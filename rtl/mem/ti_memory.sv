// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// The memory side of a core: the line ports of its units, the L2 of each kind that has one, one AXI4 read port.
///
/// The units of a kind, or the banks of its L2, go through a `ti_lines`; the kinds share the port, round robin.  2
/// cycles for a request besides those of L2 and `ti_axi_read`, which also adds 1 to an answer.
/// `flush_i` forgets all lines and is up only while `idle_o` is.
module ti_memory #(
  localparam int unsigned NumPorts   = ti_mem_pkg::NumPorts,
  localparam int unsigned NumKinds   = ti_mem_pkg::NumKinds,
  // Banks of all L2s; without one, a port that stays silent.
  localparam int unsigned NumL2Banks = (ti_mem_pkg::NumBanks > 0) ? ti_mem_pkg::NumBanks : 1,
  localparam int unsigned MaxReads   = ti_config_pkg::MaxReads,
  localparam int unsigned AxiIdWidth = (MaxReads > 1) ? $clog2(MaxReads) : 1
) (
  input  logic clk_i,
  input  logic rst_ni,
  input  logic flush_i,
  output logic idle_o,   // nothing in an L2 or on its way to one

  input  logic                  [NumPorts-1:0] line_req_valid_i,
  output logic                  [NumPorts-1:0] line_req_ready_o,
  input  ti_mem_pkg::line_req_t                line_req_data_i [NumPorts],

  output logic                  [NumPorts-1:0] line_rsp_valid_o,
  input  logic                  [NumPorts-1:0] line_rsp_ready_i,
  output ti_mem_pkg::line_rsp_t                line_rsp_data_o [NumPorts],

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

  output ti_count_pkg::axi_events_t events_o,
  output ti_count_pkg::l2_events_t  l2_events_o[NumL2Banks]
);

  logic [NumKinds-1:0] l2_idle;
  logic [NumKinds-1:0] kind_req_valid, kind_req_ready, kind_rsp_valid, kind_rsp_ready, lost;
  ti_mem_pkg::port_req_t kind_req[NumKinds];
  ti_mem_pkg::port_rsp_t rsp;
  logic port_valid, port_ready, rsp_valid;
  ti_mem_pkg::port_req_t port_req;

  for (genvar k = 0; k < NumKinds; k++) begin : gen_kind
    localparam int unsigned First = ti_mem_pkg::KindFirst[k];
    localparam int unsigned Units = ti_mem_pkg::KindUnits[k];

    ti_mem_pkg::line_req_t unit_req[Units];
    ti_mem_pkg::line_rsp_t unit_rsp[Units];
    for (genvar u = 0; u < Units; u++) begin : gen_unit
      assign unit_req[u] = line_req_data_i[First+u];
      assign line_rsp_data_o[First+u] = unit_rsp[u];
    end

    // Who asks memory: the banks, or the units themselves.
    localparam int unsigned Clients = ti_mem_pkg::KindClients[k];
    localparam int unsigned FirstClient = ti_mem_pkg::KindFirstClient[k];
    logic [Clients-1:0] client_req_valid, client_req_ready, client_rsp_valid, client_rsp_ready;
    ti_mem_pkg::line_req_t client_req[Clients];
    ti_mem_pkg::line_rsp_t client_rsp[Clients];

    if (ti_mem_pkg::KindL2Bytes[k] > 0) begin : gen_l2
      ti_count_pkg::l2_events_t events[Clients];
      ti_l2 #(
        .NumUnits  (Units),
        .UnitIds   (ti_mem_pkg::KindRows[k]),
        .NumBanks  (Clients),
        .CacheBytes(ti_mem_pkg::KindL2Bytes[k]),
        .Ways      (ti_mem_pkg::KindL2Ways[k]),
        .Rows      (ti_mem_pkg::KindL2Rows[k]),
        .Latency   (ti_config_pkg::L2Latency)
      ) u_l2 (
        .clk_i,
        .rst_ni,
        .flush_i,
        .idle_o          (l2_idle[k]),
        .line_req_valid_i(line_req_valid_i[First+:Units]),
        .line_req_ready_o(line_req_ready_o[First+:Units]),
        .line_req_data_i (unit_req),
        .line_rsp_valid_o(line_rsp_valid_o[First+:Units]),
        .line_rsp_ready_i(line_rsp_ready_i[First+:Units]),
        .line_rsp_data_o (unit_rsp),
        .bank_req_valid_o(client_req_valid),
        .bank_req_ready_i(client_req_ready),
        .bank_req_data_o (client_req),
        .bank_rsp_valid_i(client_rsp_valid),
        .bank_rsp_ready_o(client_rsp_ready),
        .bank_rsp_data_i (client_rsp),
        .events_o        (events)
      );
      for (genvar b = 0; b < Clients; b++) begin : gen_events
        assign l2_events_o[ti_mem_pkg::KindFirstBank[k]+b] = events[b];
      end
    end else begin : gen_no_l2
      assign l2_idle[k]                     = 1'b1;
      assign client_req_valid               = line_req_valid_i[First+:Units];
      assign line_req_ready_o[First+:Units] = client_req_ready;
      assign client_req                     = unit_req;
      assign line_rsp_valid_o[First+:Units] = client_rsp_valid;
      assign client_rsp_ready               = line_rsp_ready_i[First+:Units];
      assign unit_rsp                       = client_rsp;
    end

    logic [Clients-1:0] mine;
    for (genvar c = 0; c < Clients; c++) begin : gen_mine
      assign mine[c] = rsp.client == ti_mem_pkg::client_t'(FirstClient + c);
    end
    assign kind_rsp_valid[k] = rsp_valid && |mine;

    ti_lines #(
      .NumUnits   (Clients),
      .FirstClient(FirstClient)
    ) u_lines (
      .clk_i,
      .rst_ni,
      .line_req_valid_i(client_req_valid),
      .line_req_ready_o(client_req_ready),
      .line_req_data_i (client_req),
      .line_rsp_valid_o(client_rsp_valid),
      .line_rsp_ready_i(client_rsp_ready),
      .line_rsp_data_o (client_rsp),
      .req_valid_o     (kind_req_valid[k]),
      .req_ready_i     (kind_req_ready[k]),
      .req_data_o      (kind_req[k]),
      .rsp_valid_i     (kind_rsp_valid[k]),
      .rsp_ready_o     (kind_rsp_ready[k]),
      .rsp_data_i      (rsp)
    );
  end
  assign idle_o = &l2_idle;

  if (ti_mem_pkg::NumBanks == 0) begin : gen_no_banks
    logic unused_flush;
    assign unused_flush   = flush_i;
    assign l2_events_o[0] = '0;
  end

  ti_arbiter #(
    .payload_t(ti_mem_pkg::port_req_t),
    .NumIn    (NumKinds)
  ) u_port (
    .clk_i,
    .rst_ni,
    .in_valid_i (kind_req_valid),
    .in_ready_o (kind_req_ready),
    .in_lost_o  (lost),
    .in_data_i  (kind_req),
    .out_valid_o(port_valid),
    .out_ready_i(port_ready),
    .out_data_o (port_req)
  );

  logic unused_lost;
  assign unused_lost = |lost;

  ti_axi_read #(
    .id_t    (ti_mem_pkg::port_id_t),
    .MaxReads(MaxReads)
  ) u_axi (
    .clk_i,
    .rst_ni,
    .req_valid_i(port_valid),
    .req_ready_o(port_ready),
    .req_id_i   ('{client: port_req.client, id: port_req.req.id}),
    .req_line_i (port_req.req.line),
    .rsp_valid_o(rsp_valid),
    .rsp_ready_i(&(kind_rsp_ready | ~kind_rsp_valid)),
    .rsp_id_o   ({rsp.client, rsp.rsp.id}),
    .rsp_data_o (rsp.rsp.data),
    .rsp_error_o(rsp.rsp.error),
    .m_axi_arvalid,
    .m_axi_arready,
    .m_axi_arid,
    .m_axi_araddr,
    .m_axi_arlen,
    .m_axi_arsize,
    .m_axi_arburst,
    .m_axi_arlock,
    .m_axi_arcache,
    .m_axi_arprot,
    .m_axi_arqos,
    .m_axi_rvalid,
    .m_axi_rready,
    .m_axi_rid,
    .m_axi_rdata,
    .m_axi_rresp,
    .m_axi_rlast,
    .events_o
  );

  `TI_ASSERT(FlushedOnlyIdle, flush_i -> idle_o)
  `TI_ASSERT_KNOWN(LineReqReadyKnown, line_req_ready_o)
  `TI_ASSERT_KNOWN(LineRspValidKnown, line_rsp_valid_o)
  `TI_ASSERT_KNOWN(ArValidKnown, m_axi_arvalid)
  `TI_ASSERT_KNOWN(RReadyKnown, m_axi_rready)

endmodule : ti_memory
