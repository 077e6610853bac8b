// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// Each result of `ti_fp_rcp` by division comes `EndStages` + ceil((`FracBits` + 2) / `BitsPerStage`) cycles after its
/// operand and is the exact inverse, rounded once to nearest even or toward zero; NaN, infinities, signed zeros,
/// overflow and flushed subnormals are as `docs/fp.md` says.
module ti_fp_rcp_formal #(
  parameter int unsigned ExpBits = 3,
  parameter int unsigned FracBits = 2,
  parameter int unsigned BitsPerStage = 2,
  parameter int unsigned EndStages = 2,
  parameter bit TowardZero = 1'b0,
  parameter bit Flush = 1'b0,
  localparam int unsigned Width = 1 + ExpBits + FracBits,
  localparam int unsigned Stages = EndStages + (FracBits + 1 + BitsPerStage) / BitsPerStage
) (
  input logic             clk_i,
  input logic             rst_ni,
  input logic             valid_i,
  input logic [Width-1:0] a_i,
  input logic             valid_o,
  input logic [Width-1:0] result_o
);
  `TI_STARTS_IN_RESET

  `include "rounding.svh"

  // What went in `Stages` cycles ago.
  logic [Stages-1:0] valid_q;
  logic [Stages-1:0][Width-1:0] a_q;
  always_ff @(posedge clk_i) begin
    valid_q <= rst_ni ? {valid_q[Stages-2:0], valid_i} : '0;
    a_q <= {a_q[Stages-2:0], a_i};
  end

  logic sign, is_number;
  mag_t a, result;
  always_comb begin
    sign = a_q[Stages-1][Width-1];
    a = a_q[Stages-1][MagBits-1:0];
    if (Flush && a < LeastNormal) a = '0;
    is_number = a != '0 && a < Infinity;
    result = result_o[MagBits-1:0];
  end

  `TI_ASSERT(ValidWhenItsTimeIsUp, valid_o == valid_q[Stages-1])
  `TI_ASSERT(OneQuietNaN, valid_o && a > Infinity -> result_o == QuietNaN)
  `TI_ASSERT(InfinityOfZero, valid_o && a == '0 -> result_o == {sign, Infinity})
  `TI_ASSERT(ZeroOfInfinity, valid_o && a == Infinity -> result_o == {sign, mag_t'(0)})
  `TI_ASSERT(SignOfTheOperand, valid_o && is_number -> result_o[Width-1] == sign)
  `TI_ASSERT(RoundedOnce, valid_o && is_number -> inverse_rounds_to(a, result))

  // An inverse below the least normal number; one that is exact, and one that is not; a subnormal operand whose
  // inverse is out of range, or infinite.
  logic is_small, is_exact, is_subnormal;
  assign is_small = One < value(a) * (value(LeastNormal) << FineBits);
  assign is_subnormal = a_q[Stages-1][FracBits+:ExpBits] == '0 && a_q[Stages-1][FracBits-1:0] != '0;
  assign is_exact = One == value(a) * (value(result) << FineBits);
  `TI_COVER(BelowTheNormalOnes, valid_o && is_number && is_small)
  `TI_COVER(Exact, valid_o && is_number && is_exact)
  `TI_COVER(Inexact, valid_o && is_number && !is_exact && result > LeastNormal && result < Largest)
  `TI_COVER(OfASubnormal, valid_o && is_subnormal && result >= Largest)
  `TI_COVER(AfterAPause, valid_o && is_number && !valid_q[0] && !$past(valid_o))
endmodule : ti_fp_rcp_formal

bind ti_fp_rcp ti_fp_rcp_formal #(
  .ExpBits     (ExpBits),
  .FracBits    (FracBits),
  .BitsPerStage(BitsPerStage),
  .EndStages   (EndStages),
  .TowardZero  (TowardZero),
  .Flush       (Flush)
) u_formal (.*);
