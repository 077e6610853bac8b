// SPDX-License-Identifier: Apache-2.0

/// A `ti_axi_read` with identities of 16 bits, its two streams with one payload each, for its tests.
module ti_axi_read_top #(
  parameter int unsigned MaxReads = 16,
  parameter int unsigned Timeout = 0,
  localparam int unsigned IdWidth = 16,
  localparam int unsigned LineAddrWidth = ti_mem_pkg::LineAddrWidth,
  localparam int unsigned AxiIdWidth = $clog2(MaxReads)
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic                             req_valid_i,
  output logic                             req_ready_o,
  input  logic [IdWidth+LineAddrWidth-1:0] req_data_i,   // {id, line}

  output logic                                      rsp_valid_o,
  input  logic                                      rsp_ready_i,
  output logic [IdWidth+1+ti_mem_pkg::LineBits-1:0] rsp_data_o,   // {id, error, data}

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

  logic [IdWidth-1:0] rsp_id;
  ti_mem_pkg::line_t rsp_data;
  logic rsp_error;
  assign rsp_data_o = {rsp_id, rsp_error, rsp_data};

  ti_axi_read #(
    .id_t    (logic [IdWidth-1:0]),
    .MaxReads(MaxReads),
    .Timeout (Timeout)
  ) u_read (
    .clk_i,
    .rst_ni,
    .req_valid_i,
    .req_ready_o,
    .req_id_i   (req_data_i[LineAddrWidth+:IdWidth]),
    .req_line_i (req_data_i[LineAddrWidth-1:0]),
    .rsp_valid_o,
    .rsp_ready_i,
    .rsp_id_o   (rsp_id),
    .rsp_data_o (rsp_data),
    .rsp_error_o(rsp_error),
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

endmodule : ti_axi_read_top
