// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The writer's side of a `ti_cdc_fifo`: its pointer, and whether there is room.
module ti_cdc_write #(
  /// Entries, a power of two.
  parameter  int unsigned Depth        = 8,
  /// Flops of the synchroniser.
  parameter  int unsigned SyncStages   = 2,
  localparam int unsigned PointerWidth = $clog2(Depth) + 1
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic in_valid_i,
  output logic in_ready_o,

  output logic                    push_o,
  output logic [PointerWidth-2:0] index_o,       // of the entry that a push writes
  output logic [PointerWidth-1:0] write_gray_o,  // a register
  input  logic [PointerWidth-1:0] read_gray_i    // of the reader's clock
);

  logic [PointerWidth-1:0] write_q, write_next, gray_q, read_gray;

  ti_sync #(
    .Width (PointerWidth),
    .Stages(SyncStages)
  ) u_read (
    .clk_i,
    .rst_ni,
    .in_i (read_gray_i),
    .out_o(read_gray)
  );

  // Full: the writer is a round ahead, which in Gray code turns the two highest bits.
  assign in_ready_o   = gray_q != (read_gray ^ (PointerWidth'(3) << (PointerWidth - 2)));
  assign push_o       = in_valid_i && in_ready_o;
  assign index_o      = write_q[PointerWidth-2:0];
  assign write_next   = write_q + 1'b1;
  assign write_gray_o = gray_q;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      write_q <= '0;
      gray_q  <= '0;
    end else if (push_o) begin
      write_q <= write_next;
      gray_q  <= write_next ^ (write_next >> 1);
    end
  end

  if (Depth < 2 || (Depth & (Depth - 1)) != 0) begin : gen_check_depth
    $error("ti_cdc_write: Depth must be a power of two from 2");
  end

  `TI_ASSERT_NEXT(OneBitAtATime, 1'b1, $onehot0(gray_q ^ $past(gray_q)))
  `TI_ASSERT_KNOWN(InReadyKnown, in_ready_o)

endmodule : ti_cdc_write
