// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Credits for the places of a queue behind a pipeline that cannot stall.
///
/// A beat takes a credit as it goes in and gives it back as it leaves the queue; it can be taken again in the next cycle.
/// Both outputs are registers, so neither who takes nor who gives is seen through it.
module ti_credits #(
  /// Credits, 1 or more.
  parameter int unsigned Num = 2
) (
  input  logic clk_i,
  input  logic rst_ni,
  input  logic take_i,  // only while `any_o`
  input  logic give_i,  // only while not `all_o`
  output logic any_o,
  output logic all_o    // nothing is inside
);

  localparam int unsigned CountWidth = $clog2(Num + 1);
  logic [CountWidth-1:0] left_q;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      left_q <= CountWidth'(Num);
      any_o  <= 1'b1;
      all_o  <= 1'b1;
    end else if (take_i && !give_i) begin
      left_q <= left_q - 1'b1;
      any_o  <= left_q != CountWidth'(1);
      all_o  <= 1'b0;
    end else if (give_i && !take_i) begin
      left_q <= left_q + 1'b1;
      any_o  <= 1'b1;
      all_o  <= left_q == CountWidth'(Num - 1);
    end
  end

  if (Num < 1) begin : gen_check_num
    $error("ti_credits: Num must be 1 or more");
  end

  `TI_ASSERT(TakesWhatIsThere, take_i -> any_o)
  `TI_ASSERT(GivesWhatWasTaken, give_i -> !all_o)
  `TI_ASSERT(OutputsCount, any_o == (left_q != '0) && all_o == (left_q == CountWidth'(Num)))

endmodule : ti_credits
