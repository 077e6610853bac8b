// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The reader's side of a `ti_cdc_fifo`: its pointer, and the register of the beat at the output.
module ti_cdc_read #(
  /// Entries, a power of two.
  parameter  int unsigned Depth        = 8,
  /// Flops of the synchroniser.
  parameter  int unsigned SyncStages   = 2,
  localparam int unsigned PointerWidth = $clog2(Depth) + 1
) (
  input logic clk_i,
  input logic rst_ni,

  output logic out_valid_o,
  input  logic out_ready_i,

  output logic                    pop_o,        // the entry goes to the output register
  output logic [PointerWidth-2:0] index_o,      // of that entry
  output logic [PointerWidth-1:0] read_gray_o,  // a register
  input  logic [PointerWidth-1:0] write_gray_i  // of the writer's clock
);

  logic [PointerWidth-1:0] read_q, read_next, gray_q, write_gray;

  ti_sync #(
    .Width (PointerWidth),
    .Stages(SyncStages)
  ) u_write (
    .clk_i,
    .rst_ni,
    .in_i (write_gray_i),
    .out_o(write_gray)
  );

  assign pop_o       = gray_q != write_gray && (!out_valid_o || out_ready_i);
  assign index_o     = read_q[PointerWidth-2:0];
  assign read_next   = read_q + 1'b1;
  assign read_gray_o = gray_q;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      out_valid_o <= 1'b0;
      read_q      <= '0;
      gray_q      <= '0;
    end else begin
      out_valid_o <= pop_o || (out_valid_o && !out_ready_i);
      if (pop_o) begin
        read_q <= read_next;
        gray_q <= read_next ^ (read_next >> 1);
      end
    end
  end

  if (Depth < 2 || (Depth & (Depth - 1)) != 0) begin : gen_check_depth
    $error("ti_cdc_read: Depth must be a power of two from 2");
  end

  `TI_ASSERT_NEXT(OneBitAtATime, 1'b1, $onehot0(gray_q ^ $past(gray_q)))
  `TI_ASSERT_NEXT(OutStaysUntilTaken, out_valid_o && !out_ready_i, out_valid_o)
  `TI_ASSERT(TakenBeforeReplaced, out_valid_o && !out_ready_i -> !pop_o)
  `TI_ASSERT_KNOWN(OutValidKnown, out_valid_o)

endmodule : ti_cdc_read
