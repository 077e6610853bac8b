// SPDX-License-Identifier: Apache-2.0

/// What kind of number `x_i` is, combinational.  With `Flush` subnormals are zeros.
module ti_fp_class #(
  /// Exponent bits, 3 to 8.
  parameter int unsigned ExpBits = 8,
  /// Stored fraction bits, 2 to 23.
  parameter int unsigned FracBits = 23,
  /// Whether subnormals are zeros.
  parameter bit Flush = ti_fp_pkg::Flush,
  localparam int unsigned Width = 1 + ExpBits + FracBits
) (
  input  logic [Width-1:0] x_i,
  output logic             zero_o,    // +0 or -0, or flushed to it
  output logic             finite_o,  // neither infinite nor NaN
  output logic             normal_o,  // finite, neither zero nor subnormal
  output logic             nan_o
);

  assign zero_o   = Flush ? x_i[FracBits+:ExpBits] == '0 : x_i[Width-2:0] == '0;
  assign finite_o = !(&x_i[FracBits+:ExpBits]);
  assign normal_o = finite_o && x_i[FracBits+:ExpBits] != '0;
  assign nan_o    = !finite_o && x_i[FracBits-1:0] != '0;

  if (ExpBits < 3 || ExpBits > 8) begin : gen_check_exp_bits
    $error("ti_fp_class: ExpBits must be 3 to 8.");
  end
  if (FracBits < 2 || FracBits > 23) begin : gen_check_frac_bits
    $error("ti_fp_class: FracBits must be 2 to 23.");
  end

endmodule : ti_fp_class
