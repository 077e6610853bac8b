// SPDX-License-Identifier: Apache-2.0

// What numbers of a format stand for and where they are rounded, in whole numbers.  Included in a module that has
// `ExpBits`, `FracBits`, `Width`, `TowardZero` and `Flush`.

localparam int unsigned MagBits = ExpBits + FracBits;
typedef logic [MagBits-1:0] mag_t;  // a number without its sign
localparam mag_t LeastNormal = mag_t'(1) << FracBits;
localparam mag_t Infinity = {{ExpBits{1'b1}}, {FracBits{1'b0}}};
localparam mag_t Largest = TowardZero ? Infinity - 1'b1 : Infinity;  // result of finite operands
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

function automatic exact_t value(mag_t x);
  logic [ExpBits-1:0] exponent;
  exponent = x[FracBits+:ExpBits];
  if (exponent == '0) return exact_t'(x[FracBits-1:0]);
  return exact_t'({1'b1, x[FracBits-1:0]}) << (exponent - 1'b1);
endfunction

// Half way from the number below x to x.
function automatic exact_t middle(mag_t x);
  return (value(x - 1'b1) + value(x)) << (FineBits - 1);
endfunction
// Where rounding begins to give x: half way, toward zero at x.  When subnormals are flushed the number below the
// least normal one is that of endless exponents.
function automatic exact_t edge_of(mag_t x);
  if (TowardZero) return value(x) << FineBits;
  if (Flush && x == LeastNormal) return (value(x) << FineBits) - value(x);
  return middle(x);
endfunction

// Whether x is a result at all, and the next one above it.
function automatic logic is_result(mag_t x);
  return x <= Largest && !(Flush && x != '0 && x < LeastNormal);
endfunction
function automatic mag_t next_above(mag_t x);
  return (Flush && x == '0) ? LeastNormal : x + 1'b1;
endfunction

// Whether an exact number, in fine units of 2^-`finer` least subnormals, rounds to x.
function automatic logic reaches(exact_t exact, int unsigned finer, mag_t x);
  exact_t edge_of_x;
  edge_of_x = edge_of(x) << finer;
  return exact > edge_of_x || (exact == edge_of_x && (TowardZero || !x[0]));
endfunction
function automatic logic rounds_to(exact_t exact, int unsigned finer, mag_t x);
  return is_result(x) && (x == '0 || reaches(exact, finer, x)) &&
      (x == Largest || !reaches(exact, finer, next_above(x)));
endfunction

// The inverse of a is one over it: whether it is at or above an edge says their product.
localparam exact_t One = exact_t'(1) << (2 * OneBits + FineBits);
function automatic logic inverse_reaches(mag_t a, mag_t x);
  exact_t product;
  product = value(a) * edge_of(x);
  return One > product || (One == product && (TowardZero || !x[0]));
endfunction
function automatic logic inverse_rounds_to(mag_t a, mag_t x);
  return is_result(x) && (x == '0 || inverse_reaches(a, x)) &&
      (x == Largest || !inverse_reaches(a, next_above(x)));
endfunction
