// SPDX-License-Identifier: Apache-2.0

/// The memory side of the engine: line requests of all L1s to one AXI4 read port, answers back.
///
/// One stream a kind of unit, where an L2 of the kind will stand, then one for the port.  2 cycles for a request,
/// 1 for an answer, one line a cycle.  An identity is {kind, port, row}; each is in flight at most once.
module ti_memory #(
  parameter int unsigned NumTrv = 1,
  parameter int unsigned NumList = 1,
  parameter int unsigned NumIst1 = 1,
  parameter int unsigned TrvRows = 2,
  parameter int unsigned ListRows = 2,
  parameter int unsigned Ist1Rows = 2,
  localparam int unsigned TrvRowWidth = (TrvRows > 1) ? $clog2(TrvRows) : 1,
  localparam int unsigned ListRowWidth = (ListRows > 1) ? $clog2(ListRows) : 1,
  localparam int unsigned Ist1RowWidth = (Ist1Rows > 1) ? $clog2(Ist1Rows) : 1,
  localparam int unsigned AxiIdWidth = ti_pkg::memory_id_width(
      NumTrv, TrvRows, NumList, ListRows, NumIst1, Ist1Rows
  )
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic               [     NumTrv-1:0]                  trv_req_valid_i,
  output logic               [     NumTrv-1:0]                  trv_req_ready_o,
  input  logic               [     NumTrv-1:0][TrvRowWidth-1:0] trv_req_row_i,
  input  ti_pkg::line_addr_t [     NumTrv-1:0]                  trv_req_line_i,
  output logic               [     NumTrv-1:0]                  trv_rsp_valid_o,
  output logic               [TrvRowWidth-1:0]                  trv_rsp_row_o,

  input  logic               [     NumList-1:0]                   list_req_valid_i,
  output logic               [     NumList-1:0]                   list_req_ready_o,
  input  logic               [     NumList-1:0][ListRowWidth-1:0] list_req_row_i,
  input  ti_pkg::line_addr_t [     NumList-1:0]                   list_req_line_i,
  output logic               [     NumList-1:0]                   list_rsp_valid_o,
  output logic               [ListRowWidth-1:0]                   list_rsp_row_o,

  input  logic               [     NumIst1-1:0]                   ist1_req_valid_i,
  output logic               [     NumIst1-1:0]                   ist1_req_ready_o,
  input  logic               [     NumIst1-1:0][Ist1RowWidth-1:0] ist1_req_row_i,
  input  ti_pkg::line_addr_t [     NumIst1-1:0]                   ist1_req_line_i,
  output logic               [     NumIst1-1:0]                   ist1_rsp_valid_o,
  output logic               [Ist1RowWidth-1:0]                   ist1_rsp_row_o,

  // Of the answer that goes with any rsp_valid.
  output ti_pkg::line_t rsp_data_o,
  output logic          rsp_error_o,

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
  input  logic                           m_axi_rlast
);

  localparam int unsigned TrvIdWidth = ((NumTrv > 1) ? $clog2(NumTrv) : 1) + TrvRowWidth;
  localparam int unsigned ListIdWidth = ((NumList > 1) ? $clog2(NumList) : 1) + ListRowWidth;
  localparam int unsigned Ist1IdWidth = ((NumIst1 > 1) ? $clog2(NumIst1) : 1) + Ist1RowWidth;
  localparam int unsigned KindIdWidth = AxiIdWidth - 2;

  logic rsp_valid;
  logic [AxiIdWidth-1:0] rsp_id;

  typedef struct packed {
    logic [AxiIdWidth-1:0] id;
    ti_pkg::line_addr_t    line;
  } line_req_t;

  localparam logic [1:0] KindTrv = 2'd0;
  localparam logic [1:0] KindList = 2'd1;
  localparam logic [1:0] KindIst1 = 2'd2;

  logic [2:0] kind_valid, kind_ready;
  line_req_t [2:0] kind_req;
  logic [TrvIdWidth-1:0] trv_id;
  logic [ListIdWidth-1:0] list_id;
  logic [Ist1IdWidth-1:0] ist1_id;
  logic [1:0] rsp_kind;
  logic port_valid, port_ready;
  line_req_t port_req;

  assign rsp_kind       = rsp_id[AxiIdWidth-1-:2];
  assign kind_req[0].id = {KindTrv, KindIdWidth'(trv_id)};
  assign kind_req[1].id = {KindList, KindIdWidth'(list_id)};
  assign kind_req[2].id = {KindIst1, KindIdWidth'(ist1_id)};

  ti_mem_arbiter #(
    .NumPorts     (NumTrv),
    .RowWidth     (TrvRowWidth),
    .LineAddrWidth(ti_pkg::LineAddrWidth)
  ) u_trv_lines (
    .clk_i,
    .rst_ni,
    .req_valid_i(trv_req_valid_i),
    .req_ready_o(trv_req_ready_o),
    .req_row_i  (trv_req_row_i),
    .req_line_i (trv_req_line_i),
    .mem_valid_o(kind_valid[0]),
    .mem_ready_i(kind_ready[0]),
    .mem_id_o   (trv_id),
    .mem_line_o (kind_req[0].line),
    .rsp_valid_i(rsp_valid && rsp_kind == KindTrv),
    .rsp_id_i   (rsp_id[TrvIdWidth-1:0]),
    .rsp_valid_o(trv_rsp_valid_o),
    .rsp_row_o  (trv_rsp_row_o)
  );

  ti_mem_arbiter #(
    .NumPorts     (NumList),
    .RowWidth     (ListRowWidth),
    .LineAddrWidth(ti_pkg::LineAddrWidth)
  ) u_list_lines (
    .clk_i,
    .rst_ni,
    .req_valid_i(list_req_valid_i),
    .req_ready_o(list_req_ready_o),
    .req_row_i  (list_req_row_i),
    .req_line_i (list_req_line_i),
    .mem_valid_o(kind_valid[1]),
    .mem_ready_i(kind_ready[1]),
    .mem_id_o   (list_id),
    .mem_line_o (kind_req[1].line),
    .rsp_valid_i(rsp_valid && rsp_kind == KindList),
    .rsp_id_i   (rsp_id[ListIdWidth-1:0]),
    .rsp_valid_o(list_rsp_valid_o),
    .rsp_row_o  (list_rsp_row_o)
  );

  ti_mem_arbiter #(
    .NumPorts     (NumIst1),
    .RowWidth     (Ist1RowWidth),
    .LineAddrWidth(ti_pkg::LineAddrWidth)
  ) u_ist1_lines (
    .clk_i,
    .rst_ni,
    .req_valid_i(ist1_req_valid_i),
    .req_ready_o(ist1_req_ready_o),
    .req_row_i  (ist1_req_row_i),
    .req_line_i (ist1_req_line_i),
    .mem_valid_o(kind_valid[2]),
    .mem_ready_i(kind_ready[2]),
    .mem_id_o   (ist1_id),
    .mem_line_o (kind_req[2].line),
    .rsp_valid_i(rsp_valid && rsp_kind == KindIst1),
    .rsp_id_i   (rsp_id[Ist1IdWidth-1:0]),
    .rsp_valid_o(ist1_rsp_valid_o),
    .rsp_row_o  (ist1_rsp_row_o)
  );

  ti_arbiter #(
    .payload_t(line_req_t),
    .NumIn    (3)
  ) u_port (
    .clk_i,
    .rst_ni,
    .in_valid_i (kind_valid),
    .in_ready_o (kind_ready),
    .in_data_i  (kind_req),
    .out_valid_o(port_valid),
    .out_ready_i(port_ready),
    .out_data_o (port_req)
  );

  ti_axi_read #(
    .IdWidth  (AxiIdWidth),
    .AddrWidth(ti_pkg::AddrWidth),
    .LineBytes(ti_pkg::LineBytes)
  ) u_axi (
    .clk_i,
    .rst_ni,
    .req_valid_i(port_valid),
    .req_ready_o(port_ready),
    .req_id_i   (port_req.id),
    .req_line_i (port_req.line),
    .rsp_valid_o(rsp_valid),
    .rsp_id_o   (rsp_id),
    .rsp_data_o (rsp_data_o),
    .rsp_error_o(rsp_error_o),
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

endmodule : ti_memory
