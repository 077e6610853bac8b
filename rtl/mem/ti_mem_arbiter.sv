// SPDX-License-Identifier: Apache-2.0

/// Line requests of several L1s of one kind into one stream, answers back to who asked.
///
/// The identity of a request is {port, row}.  1 cycle for a request, none for an answer.  This is where
/// the L2 of the kind will stand: it has the same ports.
module ti_mem_arbiter #(
  parameter int unsigned NumPorts = 2,
  parameter int unsigned RowWidth = 1,
  parameter int unsigned LineAddrWidth = 26,
  localparam int unsigned PortWidth = (NumPorts > 1) ? $clog2(NumPorts) : 1,
  localparam int unsigned IdWidth = PortWidth + RowWidth
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic [NumPorts-1:0]                    req_valid_i,
  output logic [NumPorts-1:0]                    req_ready_o,
  input  logic [NumPorts-1:0][     RowWidth-1:0] req_row_i,
  input  logic [NumPorts-1:0][LineAddrWidth-1:0] req_line_i,

  output logic                     mem_valid_o,
  input  logic                     mem_ready_i,
  output logic [      IdWidth-1:0] mem_id_o,
  output logic [LineAddrWidth-1:0] mem_line_o,

  input logic               rsp_valid_i,
  input logic [IdWidth-1:0] rsp_id_i,

  output logic [NumPorts-1:0] rsp_valid_o,
  output logic [RowWidth-1:0] rsp_row_o
);

  typedef struct packed {
    logic [PortWidth-1:0]     port;
    logic [RowWidth-1:0]      row;
    logic [LineAddrWidth-1:0] line;
  } request_t;

  request_t [NumPorts-1:0] requests;
  request_t request;

  for (genvar p = 0; p < NumPorts; p++) begin : gen_port
    assign requests[p] = '{port: PortWidth'(p), row: req_row_i[p], line: req_line_i[p]};
    assign rsp_valid_o[p] = rsp_valid_i && rsp_id_i[IdWidth-1:RowWidth] == PortWidth'(p);
  end

  ti_arbiter #(
    .payload_t(request_t),
    .NumIn    (NumPorts)
  ) u_arbiter (
    .clk_i,
    .rst_ni,
    .in_valid_i (req_valid_i),
    .in_ready_o (req_ready_o),
    .in_data_i  (requests),
    .out_valid_o(mem_valid_o),
    .out_ready_i(mem_ready_i),
    .out_data_o (request)
  );

  assign mem_id_o   = {request.port, request.row};
  assign mem_line_o = request.line;
  assign rsp_row_o  = rsp_id_i[RowWidth-1:0];

endmodule : ti_mem_arbiter
