// SPDX-License-Identifier: Apache-2.0

/// A queue from one clock to another, by pointers in Gray code (Cummings, SNUG 2002).
///
/// One beat a cycle of the slower clock, when `Depth` covers the way of the pointers there and back:
/// 2 * SyncStages + 4.  A beat comes out 1 cycle of the writer and SyncStages + 1 to SyncStages + 2 of the reader
/// after it was taken.  `in_ready_o` and the outputs come from registers of their own clock.
///
/// What crosses: the two pointers, which end in `ti_sync`, and the entries, which end in `out_data_o` and have been
/// still for SyncStages cycles when they are read.  Constraints bound both by a period of the faster clock.
///
/// Both resets are asserted together; each is released in step with its clock, in any order.
module ti_cdc_fifo #(
  parameter  type         payload_t    = logic,
  /// Entries, a power of two from 2.
  parameter  int unsigned Depth        = 8,
  /// Flops of each synchroniser, 2 or more.
  parameter  int unsigned SyncStages   = 2,
  localparam int unsigned PointerWidth = $clog2(Depth) + 1
) (
  input  logic     in_clk_i,
  input  logic     in_rst_ni,
  input  logic     in_valid_i,
  output logic     in_ready_o,
  input  payload_t in_data_i,

  input  logic     out_clk_i,
  input  logic     out_rst_ni,
  output logic     out_valid_o,
  input  logic     out_ready_i,
  output payload_t out_data_o
);

  logic push, pop;
  logic [PointerWidth-2:0] write_index, read_index;
  logic [PointerWidth-1:0] write_gray, read_gray;
  payload_t mem_q[Depth];

  ti_cdc_write #(
    .Depth     (Depth),
    .SyncStages(SyncStages)
  ) u_write (
    .clk_i       (in_clk_i),
    .rst_ni      (in_rst_ni),
    .in_valid_i,
    .in_ready_o,
    .push_o      (push),
    .index_o     (write_index),
    .write_gray_o(write_gray),
    .read_gray_i (read_gray)
  );

  ti_cdc_read #(
    .Depth     (Depth),
    .SyncStages(SyncStages)
  ) u_read (
    .clk_i       (out_clk_i),
    .rst_ni      (out_rst_ni),
    .out_valid_o,
    .out_ready_i,
    .pop_o       (pop),
    .index_o     (read_index),
    .read_gray_o (read_gray),
    .write_gray_i(write_gray)
  );

  always_ff @(posedge in_clk_i) if (push) mem_q[write_index] <= in_data_i;
  always_ff @(posedge out_clk_i) if (pop) out_data_o <= mem_q[read_index];

  if (Depth < 2 || (Depth & (Depth - 1)) != 0) begin : gen_check_depth
    $error("ti_cdc_fifo: Depth must be a power of two from 2");
  end

endmodule : ti_cdc_fifo
