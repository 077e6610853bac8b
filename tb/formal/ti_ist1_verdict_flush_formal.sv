// SPDX-License-Identifier: Apache-2.0

`include "ti_ist1_verdict_formal.sv"

/// What `ti_ist1_verdict` promises, where subnormals are zeros.
module ti_ist1_verdict_flush_formal (
  input logic        clk_i,
  input logic        rst_ni,
  input logic        pass_b_i,
  input ti_pkg::fp_t x3_i,
  input ti_pkg::fp_t given_i,
  input ti_pkg::fp_t limit_i,
  input logic        keep_o
);
  localparam int unsigned W = ti_num_pkg::FpWidth;
  localparam int unsigned M = ti_num_pkg::FracBits;
  // A dett that counts as 0.
  `TI_COVER(SubnormalIsZero, !pass_b_i && keep_o && x3_i[W-2:M] == '0 && x3_i[M-1:0] != '0)
endmodule : ti_ist1_verdict_flush_formal

module ti_ist1_verdict_flush_top (
  input  logic        clk_i,
  input  logic        rst_ni,
  input  logic        pass_b_i,
  input  ti_pkg::fp_t x1_i,
  input  ti_pkg::fp_t x2_i,
  input  ti_pkg::fp_t x3_i,
  input  ti_pkg::fp_t given_i,
  input  ti_pkg::fp_t limit_i,
  input  ti_pkg::fp_t nearest_i,
  output logic        keep_o
);
  ti_ist1_verdict #(.CmpStages(0)) u_unit (.*);
  ti_ist1_verdict_flush_formal u_mode (.*);
endmodule : ti_ist1_verdict_flush_top
