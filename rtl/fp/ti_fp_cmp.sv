// SPDX-License-Identifier: Apache-2.0

/// Floating-point comparison of a with b.
///
/// Combinational.  IEEE 754 values are compared: -0 equals +0, subnormals and infinities have their
/// places; when either operand is NaN, `unordered_o` is 1 and the other outputs are 0.  With `Flush`
/// subnormals are zeros.
module ti_fp_cmp #(
  /// Exponent bits, 3 to 8.
  parameter int unsigned ExpBits = 8,
  /// Stored fraction bits, 2 to 23.
  parameter int unsigned FracBits = 23,
  /// Whether subnormals are zeros.
  parameter bit Flush = ti_fp_pkg::Flush,
  localparam int unsigned Width = 1 + ExpBits + FracBits
) (
  input logic [Width-1:0] a_i,
  input logic [Width-1:0] b_i,

  output logic lt_o,        // a < b
  output logic eq_o,        // a == b
  output logic le_o,        // a <= b
  output logic unordered_o  // a or b is NaN
);

  localparam int unsigned MagBits = ExpBits + FracBits;
  localparam logic [MagBits-1:0] Infinity = {{ExpBits{1'b1}}, {FracBits{1'b0}}};

  if (ExpBits < 3 || ExpBits > 8) begin : gen_check_exp_bits
    $error("ti_fp_cmp: ExpBits must be 3 to 8.");
  end
  if (FracBits < 2 || FracBits > 23) begin : gen_check_frac_bits
    $error("ti_fp_cmp: FracBits must be 2 to 23.");
  end

  logic sign_a, sign_b, both_zero, less;
  logic [MagBits-1:0] mag_a, mag_b;  // 0 for what is zero

  assign sign_a = a_i[Width-1];
  assign sign_b = b_i[Width-1];
  assign mag_a = a_i[MagBits-1:0] & {MagBits{!Flush || a_i[FracBits+:ExpBits] != '0}};
  assign mag_b = b_i[MagBits-1:0] & {MagBits{!Flush || b_i[FracBits+:ExpBits] != '0}};
  assign both_zero = mag_a == '0 && mag_b == '0;

  always_comb begin
    less = mag_a < mag_b;
    if (sign_a != sign_b) begin
      less = sign_a;
    end else if (sign_a) begin
      less = mag_b < mag_a;
    end
  end

  assign unordered_o = mag_a > Infinity || mag_b > Infinity;
  assign eq_o = !unordered_o && ((sign_a == sign_b && mag_a == mag_b) || both_zero);
  assign lt_o = !unordered_o && !both_zero && less;
  assign le_o = lt_o || eq_o;

endmodule : ti_fp_cmp
