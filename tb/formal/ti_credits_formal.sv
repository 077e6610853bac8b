// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_credits` never gives out more than `Num`, and says at once when the last one is out or all are back.
module ti_credits_formal #(
  parameter int unsigned Num = 2
) (
  input logic clk_i,
  input logic rst_ni,
  input logic take_i,
  input logic give_i,
  input logic any_o,
  input logic all_o
);
  `TI_STARTS_IN_RESET

  localparam int unsigned CountWidth = $clog2(Num + 1);
  logic [CountWidth-1:0] out_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) out_q <= '0;
    else out_q <= out_q + CountWidth'(take_i) - CountWidth'(give_i);
  end

  `TI_ASSERT(NeverMore, out_q <= CountWidth'(Num))
  `TI_ASSERT(AnyWhileSomeAreLeft, any_o == (out_q < CountWidth'(Num)))
  `TI_ASSERT(AllWhileNoneIsOut, all_o == (out_q == '0))
  `TI_COVER(AllAreOut, out_q == CountWidth'(Num))
endmodule : ti_credits_formal

bind ti_credits ti_credits_formal #(.Num(Num)) u_formal (.*);
