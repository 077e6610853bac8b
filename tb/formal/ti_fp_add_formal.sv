// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// Each result of `ti_fp_add` comes `Stages` cycles after its pair and is the exact sum or difference, rounded once to
/// nearest even or toward zero; NaN, infinities, signed zeros, overflow and flushed subnormals are as in `docs/fp.md`.
module ti_fp_add_formal #(
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
  input logic             negate_b_i,
  input logic             valid_o,
  input logic [Width-1:0] result_o
);
  `TI_STARTS_IN_RESET

  `include "rounding.svh"

  // What went in `Stages` cycles ago.
  logic [Stages-1:0] valid_q;
  logic [Stages-1:0][Width-1:0] a_q, b_q;
  logic [Stages-1:0] negate_q;
  always_ff @(posedge clk_i) begin
    valid_q <= rst_ni ? {valid_q[Stages-2:0], valid_i} : '0;
    a_q <= {a_q[Stages-2:0], a_i};
    b_q <= {b_q[Stages-2:0], b_i};
    negate_q <= {negate_q[Stages-2:0], negate_b_i};
  end

  logic sign_a, sign_b;
  mag_t a, b, result;
  exact_t exact;
  logic sign, is_nan, is_infinite, is_finite;
  always_comb begin
    sign_a = a_q[Stages-1][Width-1];
    sign_b = b_q[Stages-1][Width-1] ^ negate_q[Stages-1];
    a = a_q[Stages-1][MagBits-1:0];
    b = b_q[Stages-1][MagBits-1:0];
    if (Flush && a < LeastNormal) a = '0;
    if (Flush && b < LeastNormal) b = '0;
    is_nan = a > Infinity || b > Infinity || (a == Infinity && b == Infinity && sign_a != sign_b);
    is_infinite = !is_nan && (a == Infinity || b == Infinity);
    is_finite = !is_nan && !is_infinite;
    exact = (sign_a ? -value(a) : value(a)) + (sign_b ? -value(b) : value(b));
    sign = exact == '0 ? sign_a && sign_b : exact[ExactBits-1];
    exact = (sign ? -exact : exact) << FineBits;
    result = result_o[MagBits-1:0];
  end

  `TI_ASSERT(ValidWhenItsTimeIsUp, valid_o == valid_q[Stages-1])
  `TI_ASSERT(OneQuietNaN, valid_o && is_nan -> result_o == QuietNaN)
  `TI_ASSERT(InfiniteOperand,
             valid_o && is_infinite -> result_o == {a == Infinity ? sign_a : sign_b, Infinity})
  `TI_ASSERT(SignOfTheSum, valid_o && is_finite -> result_o[Width-1] == sign)
  `TI_ASSERT(RoundedOnce, valid_o && is_finite -> rounds_to(exact, 0, result))

  // A sum below the least normal number; one out of range; one half way between two numbers; normal numbers whose
  // difference is nothing but their last places; and those whose difference is zero.
  logic is_small, is_large, is_tie, is_normal;
  assign is_small = exact < (value(LeastNormal) << FineBits);
  assign is_large = exact >= (value(Infinity) << FineBits);
  assign is_tie = exact == middle(result) || exact == middle(result + 1'b1);
  assign is_normal = a >= LeastNormal && b >= LeastNormal;
  `TI_COVER(BelowTheNormalOnes, valid_o && is_finite && is_small && exact != '0)
  `TI_COVER(Overflow, valid_o && is_finite && is_large)
  `TI_COVER(Tie, valid_o && is_finite && is_tie && result < Infinity - 1'b1)
  `TI_COVER(Cancellation, valid_o && is_finite && is_normal && a == b + 1'b1 && sign_a != sign_b)
  `TI_COVER(Nothing, valid_o && is_finite && is_normal && exact == '0 && negate_q[Stages-1])
  `TI_COVER(AfterAPause, valid_o && is_finite && !valid_q[0] && !$past(valid_o))
endmodule : ti_fp_add_formal

bind ti_fp_add ti_fp_add_formal #(
  .ExpBits   (ExpBits),
  .FracBits  (FracBits),
  .Stages    (Stages),
  .TowardZero(TowardZero),
  .Flush     (Flush)
) u_formal (.*);
