// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// Line requests to an AXI4 read port: one burst of one beat a line, the data bus as wide as a line.
///
/// ARID is the identity of the request, and no two requests in flight share it, so answers may come
/// in any order.  Requests pass combinationally; answers are registered (1 cycle) and always taken
/// (`m_axi_rready` is 1).  SLVERR, DECERR and a beat without RLAST come back as an error.
module ti_axi_read #(
  parameter int unsigned IdWidth = 4,
  parameter int unsigned AddrWidth = 32,
  parameter int unsigned LineBytes = 64,
  localparam int unsigned LineAddrWidth = AddrWidth - $clog2(LineBytes)
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic                     req_valid_i,
  output logic                     req_ready_o,
  input  logic [      IdWidth-1:0] req_id_i,
  input  logic [LineAddrWidth-1:0] req_line_i,

  output logic                   rsp_valid_o,
  output logic [    IdWidth-1:0] rsp_id_o,
  output logic [8*LineBytes-1:0] rsp_data_o,
  output logic                   rsp_error_o,

  output logic                   m_axi_arvalid,
  input  logic                   m_axi_arready,
  output logic [    IdWidth-1:0] m_axi_arid,
  output logic [  AddrWidth-1:0] m_axi_araddr,
  output logic [            7:0] m_axi_arlen,
  output logic [            2:0] m_axi_arsize,
  output logic [            1:0] m_axi_arburst,
  input  logic                   m_axi_rvalid,
  output logic                   m_axi_rready,
  input  logic [    IdWidth-1:0] m_axi_rid,
  input  logic [8*LineBytes-1:0] m_axi_rdata,
  input  logic [            1:0] m_axi_rresp,
  input  logic                   m_axi_rlast
);

  assign m_axi_arvalid = req_valid_i;
  assign req_ready_o   = m_axi_arready;
  assign m_axi_arid    = req_id_i;
  assign m_axi_araddr  = {req_line_i, {$clog2(LineBytes) {1'b0}}};
  assign m_axi_arlen   = 8'd0;
  assign m_axi_arsize  = 3'($clog2(LineBytes));
  assign m_axi_arburst = 2'b01;
  assign m_axi_rready  = 1'b1;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) rsp_valid_o <= 1'b0;
    else rsp_valid_o <= m_axi_rvalid;
  end

  always_ff @(posedge clk_i) begin
    if (m_axi_rvalid) begin
      rsp_id_o    <= m_axi_rid;
      rsp_data_o  <= m_axi_rdata;
      rsp_error_o <= m_axi_rresp[1] || !m_axi_rlast;
    end
  end

  if (LineBytes < 8 || LineBytes > 128) begin : gen_check_line_bytes
    $error("ti_axi_read: LineBytes must be 8 to 128, the widths of an AXI4 data bus");
  end

  `TI_ASSERT(ArHeldUntilTaken, m_axi_arvalid && !m_axi_arready |=> m_axi_arvalid && $stable
                               ({m_axi_arid, m_axi_araddr}))

endmodule : ti_axi_read
