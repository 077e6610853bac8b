// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// N streams into one, round robin: who was served comes last.
///
/// Latency 1 cycle, one beat a cycle.  The output is a `ti_fifo` of two entries, so the grant does not depend on
/// `out_ready_i` and no ready chain runs through.
module ti_arbiter #(
  parameter type payload_t = logic,
  /// Inputs, 1 or more.
  parameter int unsigned NumIn = 2
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic     [NumIn-1:0] in_valid_i,
  output logic     [NumIn-1:0] in_ready_o,        // the grant: only where valid
  output logic     [NumIn-1:0] in_lost_o,         // valid, and another is served in its place
  input  payload_t             in_data_i [NumIn],

  output logic     out_valid_o,
  input  logic     out_ready_i,
  output payload_t out_data_o
);

  localparam int unsigned IndexWidth = (NumIn > 1) ? $clog2(NumIn) : 1;

  logic any, room;
  logic [IndexWidth-1:0] index, from_q;

  ti_round_robin #(
    .Num(NumIn)
  ) u_choice (
    .request_i(in_valid_i),
    .from_i   (from_q),
    .any_o    (any),
    .index_o  (index)
  );

  assign in_ready_o = (any && room) ? NumIn'(1) << index : '0;
  assign in_lost_o  = room ? in_valid_i & ~in_ready_o : '0;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      from_q <= '0;
    end else if (any && room) begin
      from_q <= (index == IndexWidth'(NumIn - 1)) ? '0 : index + 1'b1;
    end
  end

  ti_fifo #(
    .payload_t(payload_t),
    .Depth    (2)
  ) u_out (
    .clk_i,
    .rst_ni,
    .in_valid_i(any),
    .in_ready_o(room),
    .in_data_i (in_data_i[index]),
    .out_valid_o,
    .out_ready_i,
    .out_data_o
  );

  if (NumIn < 1) begin : gen_check_num_in
    $error("ti_arbiter: NumIn must be 1 or more");
  end

  `TI_ASSERT(GrantOneHot, $onehot0(in_ready_o))
  `TI_ASSERT(GrantOnlyRequests, (in_ready_o & ~in_valid_i) == '0)
  `TI_COVER(RequestLost, |in_lost_o)
  `TI_ASSERT_KNOWN(InReadyKnown, in_ready_o)
  `TI_ASSERT_KNOWN(OutValidKnown, out_valid_o)

endmodule : ti_arbiter
