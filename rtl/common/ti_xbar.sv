// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// N streams to M streams, each beat to the output that its `dest` names; round robin at each output.
///
/// Latency 1 cycle, one beat a cycle an output.  Beats of one input to one output keep their order.
/// The caller guarantees `dest < NumOut`.
module ti_xbar #(
  parameter type payload_t = logic,
  /// Inputs and outputs, 1 or more each.
  parameter int unsigned NumIn = 2,
  parameter int unsigned NumOut = 2,
  localparam int unsigned DestWidth = (NumOut > 1) ? $clog2(NumOut) : 1
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic     [NumIn-1:0]                in_valid_i,
  output logic     [NumIn-1:0]                in_ready_o,         // the grant: only where valid
  output logic     [NumIn-1:0]                in_lost_o,          // another is served in its place
  input  payload_t                            in_data_i [NumIn],
  input  logic     [NumIn-1:0][DestWidth-1:0] in_dest_i,

  output logic     [NumOut-1:0] out_valid_o,
  input  logic     [NumOut-1:0] out_ready_i,
  output payload_t              out_data_o [NumOut]
);

  logic [NumOut-1:0][NumIn-1:0] request, grant, lost;

  always_comb begin
    request = '0;
    for (int unsigned i = 0; i < NumIn; i++) begin
      if (in_valid_i[i]) request[in_dest_i[i]][i] = 1'b1;
    end
  end

  always_comb begin
    in_ready_o = '0;
    in_lost_o  = '0;
    for (int unsigned o = 0; o < NumOut; o++) begin
      in_ready_o |= grant[o];
      in_lost_o |= lost[o];
    end
  end

  for (genvar o = 0; o < NumOut; o++) begin : gen_output
    ti_arbiter #(
      .payload_t(payload_t),
      .NumIn    (NumIn)
    ) u_arbiter (
      .clk_i,
      .rst_ni,
      .in_valid_i (request[o]),
      .in_ready_o (grant[o]),
      .in_lost_o  (lost[o]),
      .in_data_i,
      .out_valid_o(out_valid_o[o]),
      .out_ready_i(out_ready_i[o]),
      .out_data_o (out_data_o[o])
    );
  end

  if (NumIn < 1) begin : gen_check_num_in
    $error("ti_xbar: NumIn must be 1 or more");
  end

  if (NumOut < 1) begin : gen_check_num_out
    $error("ti_xbar: NumOut must be 1 or more");
  end

  for (genvar i = 0; i < NumIn; i++) begin : gen_check
    `TI_ASSERT(DestExists, in_valid_i[i] -> 32'(in_dest_i[i]) < NumOut)
    `TI_ASSERT(TakenOnlyWhenValid, in_ready_o[i] -> in_valid_i[i])
    `TI_ASSERT(TakenByItsOutput, in_ready_o[i] -> grant[in_dest_i[i]][i])
  end

  `TI_ASSERT_KNOWN(InReadyKnown, in_ready_o)
  `TI_ASSERT_KNOWN(OutValidKnown, out_valid_o)

endmodule : ti_xbar
