// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// Each result of `ti_fp_mul` comes `Stages` cycles after its pair and is the exact product, rounded once to nearest
/// even or toward zero; NaN, infinities, signed zeros, overflow and flushed subnormals are as `docs/fp.md` says.
module ti_fp_mul_formal #(
  parameter int unsigned ExpBits = 3,
  parameter int unsigned FracBits = 2,
  parameter int unsigned Stages = 3,
  parameter bit TowardZero = 1'b0,
  parameter bit Flush = 1'b0,
  localparam int unsigned Width = 1 + ExpBits + FracBits
) (
  input logic             clk_i,
  input logic             rst_ni,
  input logic             valid_i,
  input logic [Width-1:0] a_i,
  input logic [Width-1:0] b_i,
  input logic             valid_o,
  input logic [Width-1:0] result_o
);
  `TI_STARTS_IN_RESET

  `include "rounding.svh"

  // What went in `Stages` cycles ago.
  logic [Stages-1:0] valid_q;
  logic [Stages-1:0][Width-1:0] a_q, b_q;
  always_ff @(posedge clk_i) begin
    valid_q <= rst_ni ? {valid_q[Stages-2:0], valid_i} : '0;
    a_q <= {a_q[Stages-2:0], a_i};
    b_q <= {b_q[Stages-2:0], b_i};
  end

  logic sign;
  mag_t a, b, result;
  exact_t exact;
  logic is_nan, is_infinite, is_finite;
  always_comb begin
    sign = a_q[Stages-1][Width-1] ^ b_q[Stages-1][Width-1];
    a = a_q[Stages-1][MagBits-1:0];
    b = b_q[Stages-1][MagBits-1:0];
    if (Flush && a < LeastNormal) a = '0;
    if (Flush && b < LeastNormal) b = '0;
    is_nan = a > Infinity || b > Infinity || (a == '0 && b == Infinity)
        || (a == Infinity && b == '0);
    is_infinite = !is_nan && (a == Infinity || b == Infinity);
    is_finite = !is_nan && !is_infinite;
    exact = (value(a) * value(b)) << FineBits;
    result = result_o[MagBits-1:0];
  end

  `TI_ASSERT(ValidWhenItsTimeIsUp, valid_o == valid_q[Stages-1])
  `TI_ASSERT(OneQuietNaN, valid_o && is_nan -> result_o == QuietNaN)
  `TI_ASSERT(InfiniteOperand, valid_o && is_infinite -> result_o == {sign, Infinity})
  `TI_ASSERT(SignOfTheProduct, valid_o && is_finite -> result_o[Width-1] == sign)
  `TI_ASSERT(RoundedOnce, valid_o && is_finite -> rounds_to(exact, OneBits, result))

  // A product below the least normal number; one out of range; one half way between two numbers.
  logic is_small, is_large, is_tie;
  assign is_small = exact < (value(LeastNormal) << (OneBits + FineBits));
  assign is_large = exact >= (value(Infinity) << (OneBits + FineBits));
  assign is_tie   = exact == middle(result) << OneBits || exact == middle(result + 1'b1) << OneBits;
  `TI_COVER(BelowTheNormalOnes,
            valid_o && is_finite && is_small && exact != '0 && (Flush || result != '0))
  `TI_COVER(Overflow, valid_o && is_finite && is_large)
  `TI_COVER(Tie, valid_o && is_finite && is_tie && result > LeastNormal && result < Infinity - 1'b1)
  `TI_COVER(AfterAPause, valid_o && is_finite && !valid_q[0] && !$past(valid_o))
endmodule : ti_fp_mul_formal

bind ti_fp_mul ti_fp_mul_formal #(
  .ExpBits   (ExpBits),
  .FracBits  (FracBits),
  .Stages    (Stages),
  .TowardZero(TowardZero),
  .Flush     (Flush)
) u_formal (.*);
