// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// The line ports of the units of one kind, or of the banks of its L2, onto one stream of requests; answers back to
/// who asked.
///
/// 1 cycle for a request, one a cycle; none for an answer.
module ti_lines #(
  /// Units or banks, 1 or more.
  parameter int unsigned NumUnits    = 1,
  /// Number of the first one among the clients of the memory port.
  parameter int unsigned FirstClient = 0
) (
  input logic clk_i,
  input logic rst_ni,

  // From and to the units.
  input  logic                  [NumUnits-1:0] line_req_valid_i,
  output logic                  [NumUnits-1:0] line_req_ready_o,
  input  ti_mem_pkg::line_req_t                line_req_data_i [NumUnits],

  output logic                  [NumUnits-1:0] line_rsp_valid_o,
  input  logic                  [NumUnits-1:0] line_rsp_ready_i,
  output ti_mem_pkg::line_rsp_t                line_rsp_data_o [NumUnits],

  // To and from memory.
  output logic                  req_valid_o,
  input  logic                  req_ready_i,
  output ti_mem_pkg::port_req_t req_data_o,

  input  logic                  rsp_valid_i,
  output logic                  rsp_ready_o,
  input  ti_mem_pkg::port_rsp_t rsp_data_i
);

  ti_mem_pkg::port_req_t requests[NumUnits];
  logic [NumUnits-1:0] lost, mine;

  for (genvar u = 0; u < NumUnits; u++) begin : gen_unit
    assign requests[u] = '{
            client: ti_mem_pkg::client_t'(FirstClient + u),
            req: line_req_data_i[u]
        };
    assign mine[u] = rsp_data_i.client == ti_mem_pkg::client_t'(FirstClient + u);
    assign line_rsp_valid_o[u] = rsp_valid_i && mine[u];
    assign line_rsp_data_o[u] = rsp_data_i.rsp;
  end
  assign rsp_ready_o = (mine & ~line_rsp_ready_i) == '0;

  ti_arbiter #(
    .payload_t(ti_mem_pkg::port_req_t),
    .NumIn    (NumUnits)
  ) u_arbiter (
    .clk_i,
    .rst_ni,
    .in_valid_i (line_req_valid_i),
    .in_ready_o (line_req_ready_o),
    .in_lost_o  (lost),
    .in_data_i  (requests),
    .out_valid_o(req_valid_o),
    .out_ready_i(req_ready_i),
    .out_data_o (req_data_o)
  );

  logic unused_lost;
  assign unused_lost = |lost;

  if (NumUnits < 1 || FirstClient + NumUnits > ti_mem_pkg::NumClients) begin : gen_check_ports
    $error("ti_lines: NumUnits must be 1 or more, and the last one a client of the memory port");
  end

  `TI_ASSERT(AnswersOneUnit, rsp_valid_i -> $onehot(mine))
  `TI_ASSERT_KNOWN(LineReqReadyKnown, line_req_ready_o)
  `TI_ASSERT_KNOWN(LineRspValidKnown, line_rsp_valid_o)
  `TI_ASSERT_KNOWN(ReqValidKnown, req_valid_o)
  // It looks at whose answer it is.
  `TI_ASSERT_KNOWN_IF(RspReadyKnown, rsp_valid_i, rsp_ready_o)

endmodule : ti_lines
