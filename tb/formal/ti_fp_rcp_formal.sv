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

  localparam int unsigned MagBits = ExpBits + FracBits;
  typedef logic [MagBits-1:0] mag_t;
  localparam mag_t LeastNormal = mag_t'(1) << FracBits;
  localparam mag_t Infinity = {{ExpBits{1'b1}}, {FracBits{1'b0}}};
  localparam mag_t Largest = TowardZero ? Infinity - 1'b1 : Infinity;  // of numbers but zero
  localparam logic [Width-1:0] QuietNaN = {
    2'b01, {(ExpBits - 1) {1'b1}}, 1'b1, {(FracBits - 1) {1'b0}}
  };

  // A number is a whole number of least subnormals, of which 2^OneBits are 1.0; infinity is the power of two above the
  // largest.  Numbers of which one rounds are compared in units so fine that all edges of rounding are whole.
  localparam int unsigned ValueBits = FracBits + (1 << ExpBits) - 1;
  localparam int unsigned OneBits = FracBits + (1 << (ExpBits - 1)) - 2;
  localparam int unsigned FineBits = FracBits + 2;
  localparam int unsigned ExactBits = 2 * ValueBits + FineBits;
  typedef logic [ExactBits-1:0] exact_t;
  localparam exact_t One = exact_t'(1) << (2 * OneBits + FineBits);

  function automatic exact_t value(mag_t x);
    logic [ExpBits-1:0] exponent;
    exponent = x[FracBits+:ExpBits];
    if (exponent == '0) return exact_t'(x[FracBits-1:0]);
    return exact_t'({1'b1, x[FracBits-1:0]}) << (exponent - 1'b1);
  endfunction

  // Where rounding begins to give x: half way from the number below it, toward zero at x.  When subnormals are flushed
  // the number below the least normal one is that of endless exponents.
  function automatic exact_t edge_of(mag_t x);
    if (TowardZero) return value(x) << FineBits;
    if (Flush && x == LeastNormal) return (value(x) << FineBits) - value(x);
    return (value(x - 1'b1) + value(x)) << (FineBits - 1);
  endfunction
  // The inverse of a is one over it: whether it is at or above an edge says their product.
  function automatic logic reaches(mag_t a, mag_t x);
    exact_t product;
    product = value(a) * edge_of(x);
    return One > product || (One == product && (TowardZero || !x[0]));
  endfunction
  function automatic logic inverse_rounds_to(mag_t a, mag_t x);
    mag_t next;
    next = (Flush && x == '0) ? LeastNormal : x + 1'b1;
    if (x > Largest || (Flush && x != '0 && x < LeastNormal)) return 1'b0;
    return (x == '0 || reaches(a, x)) && (x == Largest || !reaches(a, next));
  endfunction

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
