// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_fp_class` says of any operand what it stands for: zero, a number, a normal one, or NaN.
module ti_fp_class_formal #(
  parameter int unsigned ExpBits = 3,
  parameter int unsigned FracBits = 2,
  parameter bit Flush = 1'b0,
  localparam int unsigned Width = 1 + ExpBits + FracBits
) (
  input logic             clk_i,
  input logic             rst_ni,
  input logic [Width-1:0] x_i,
  input logic             zero_o,
  input logic             finite_o,
  input logic             normal_o,
  input logic             nan_o
);
  // Magnitudes ascend with their bit patterns: zero, subnormals, normal numbers, infinity, NaNs.
  localparam int unsigned LeastNormal = 1 << FracBits;
  localparam int unsigned Infinity = ((1 << ExpBits) - 1) << FracBits;

  logic [31:0] magnitude;
  assign magnitude = 32'(x_i[Width-2:0]);

  `TI_ASSERT(ZeroIfZero, zero_o == (magnitude == 0 || (Flush && magnitude < LeastNormal)))
  `TI_ASSERT(FiniteBelowInfinity, finite_o == (magnitude < Infinity))
  `TI_ASSERT(NormalFromTheLeastOn, normal_o == (LeastNormal <= magnitude && magnitude < Infinity))
  `TI_ASSERT(NaNAboveInfinity, nan_o == (magnitude > Infinity))
  `TI_COVER(MinusZero, zero_o && x_i[Width-1] && magnitude == 0)
  `TI_COVER(Subnormal, magnitude == LeastNormal - 1)
  `TI_COVER(Infinite, magnitude == Infinity)
  `TI_COVER(NaN, nan_o)
endmodule : ti_fp_class_formal

module ti_fp_class_top #(
  parameter int unsigned ExpBits = 3,
  parameter int unsigned FracBits = 2,
  parameter bit Flush = 1'b0,
  localparam int unsigned Width = 1 + ExpBits + FracBits
) (
  input  logic             clk_i,
  input  logic [Width-1:0] x_i,
  output logic             zero_o,
  output logic             finite_o,
  output logic             normal_o,
  output logic             nan_o
);
  ti_fp_class #(
    .ExpBits (ExpBits),
    .FracBits(FracBits),
    .Flush   (Flush)
  ) u_unit (
    .*
  );
  ti_fp_class_formal #(
    .ExpBits (ExpBits),
    .FracBits(FracBits),
    .Flush   (Flush)
  ) u_formal (
    .rst_ni(1'b1),
    .*
  );
endmodule : ti_fp_class_top
