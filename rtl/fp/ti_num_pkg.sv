// SPDX-License-Identifier: Apache-2.0

/// The number format of the configuration: one sign bit, `ExpBits` of exponent, `FracBits` of fraction.
package ti_num_pkg;

  localparam int unsigned ExpBits = ti_config_pkg::ExpBits;
  localparam int unsigned FracBits = ti_config_pkg::FracBits;
  localparam int unsigned FpWidth = 1 + ExpBits + FracBits;
  localparam int unsigned Bias = (1 << (ExpBits - 1)) - 1;

  typedef logic [FpWidth-1:0] fp_t;
  typedef fp_t [2:0] vec3_t;  // [0] = x, [1] = y, [2] = z

  localparam fp_t Inf = fp_t'({1'b0, {ExpBits{1'b1}}, {FracBits{1'b0}}});

endpackage : ti_num_pkg
