// SPDX-License-Identifier: Apache-2.0

/// A `ti_cdc_fifo` of words of 16 bits, for its tests.
module ti_cdc_top #(
  parameter int unsigned Depth = 8,
  parameter int unsigned SyncStages = 2
) (
  input  logic        in_clk_i,
  input  logic        in_rst_ni,
  input  logic        in_valid_i,
  output logic        in_ready_o,
  input  logic [15:0] in_data_i,

  input  logic        out_clk_i,
  input  logic        out_rst_ni,
  output logic        out_valid_o,
  input  logic        out_ready_i,
  output logic [15:0] out_data_o
);

  ti_cdc_fifo #(
    .payload_t (logic [15:0]),
    .Depth     (Depth),
    .SyncStages(SyncStages)
  ) u_fifo (
    .in_clk_i,
    .in_rst_ni,
    .in_valid_i,
    .in_ready_o,
    .in_data_i,
    .out_clk_i,
    .out_rst_ni,
    .out_valid_o,
    .out_ready_i,
    .out_data_o
  );

endmodule : ti_cdc_top
