// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_fp_cmp` says of any two operands what is true of the numbers that they stand for, each a whole number of least
/// subnormals; with a NaN it says that there is no order and nothing else.
module ti_fp_cmp_formal #(
  parameter int unsigned ExpBits = 3,
  parameter int unsigned FracBits = 2,
  parameter bit Flush = 1'b0,
  localparam int unsigned Width = 1 + ExpBits + FracBits
) (
  input logic             clk_i,
  input logic             rst_ni,
  input logic [Width-1:0] a_i,
  input logic [Width-1:0] b_i,
  input logic             lt_o,
  input logic             eq_o,
  input logic             le_o,
  input logic             unordered_o
);
  // Infinity is the power of two above the largest number.
  localparam int unsigned ValueBits = FracBits + (1 << ExpBits) - 1;

  function automatic logic signed [ValueBits:0] value(logic [Width-1:0] x);
    logic [  ExpBits-1:0] exponent;
    logic [ValueBits-1:0] size;
    exponent = x[FracBits+:ExpBits];
    size = ValueBits'(x[FracBits-1:0]);
    if (exponent != '0) size = ValueBits'({1'b1, x[FracBits-1:0]}) << (exponent - 1'b1);
    else if (Flush) size = '0;
    return x[Width-1] ? -$signed({1'b0, size}) : $signed({1'b0, size});
  endfunction

  function automatic logic is_nan(logic [Width-1:0] x);
    return (&x[FracBits+:ExpBits]) && x[FracBits-1:0] != '0;
  endfunction

  logic signed [ValueBits:0] a, b;
  logic nan;
  assign a   = value(a_i);
  assign b   = value(b_i);
  assign nan = is_nan(a_i) || is_nan(b_i);

  `TI_ASSERT(LessIfLess, lt_o == (!nan && a < b))
  `TI_ASSERT(EqualIfEqual, eq_o == (!nan && a == b))
  `TI_ASSERT(AtMostIfAtMost, le_o == (!nan && a <= b))
  `TI_ASSERT(UnorderedIfNaN, unordered_o == nan)
  `TI_COVER(ZerosOfTwoSigns, eq_o && a_i != b_i && a == '0)
  `TI_COVER(Subnormal,
            a_i[Width-2:0] != '0 && a_i[FracBits+:ExpBits] == '0 && (Flush ? eq_o : lt_o))
  `TI_COVER(Infinities, lt_o && (&a_i[FracBits+:ExpBits]) && (&b_i[FracBits+:ExpBits]))
  `TI_COVER(BothNaN, is_nan(a_i) && a_i == b_i)
endmodule : ti_fp_cmp_formal

module ti_fp_cmp_top #(
  parameter int unsigned ExpBits = 3,
  parameter int unsigned FracBits = 2,
  parameter bit Flush = 1'b0,
  localparam int unsigned Width = 1 + ExpBits + FracBits
) (
  input  logic             clk_i,
  input  logic [Width-1:0] a_i,
  input  logic [Width-1:0] b_i,
  output logic             lt_o,
  output logic             eq_o,
  output logic             le_o,
  output logic             unordered_o
);
  ti_fp_cmp #(
    .ExpBits (ExpBits),
    .FracBits(FracBits),
    .Flush   (Flush)
  ) u_unit (
    .*
  );
  ti_fp_cmp_formal #(
    .ExpBits (ExpBits),
    .FracBits(FracBits),
    .Flush   (Flush)
  ) u_formal (
    .rst_ni(1'b1),
    .*
  );
endmodule : ti_fp_cmp_top
