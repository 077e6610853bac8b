// SPDX-License-Identifier: Apache-2.0

`include "ti_ist1_verdict_formal.sv"

/// What `ti_ist1_verdict` promises, where operations round toward zero.
module ti_ist1_verdict_zero_formal (
  input logic        clk_i,
  input logic        rst_ni,
  input logic        pass_b_i,
  input ti_pkg::fp_t x3_i,
  input ti_pkg::fp_t given_i,
  input ti_pkg::fp_t limit_i,
  input logic        keep_o
);
  // A tfar at which a t that is too large ends.
  `TI_COVER(KeepsAtTheLargestNumber,
            !pass_b_i && keep_o && given_i == ti_num_pkg::Inf - 1'b1 && x3_i > limit_i)
endmodule : ti_ist1_verdict_zero_formal

module ti_ist1_verdict_zero_top (
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
  ti_ist1_verdict_zero_formal u_mode (.*);
endmodule : ti_ist1_verdict_zero_top
