// SPDX-License-Identifier: Apache-2.0

/// Bits of another clock, or of none, brought to `clk_i` by a row of flops.
///
/// Latency `Stages` cycles, or one more.  Bits that must be seen together change one at a time (Gray code).  The
/// flops are cleared at once, whatever `ti_config_pkg::SyncReset` says, so with `in_i` tied to 1 this makes a reset
/// that is asserted at once and released with `clk_i`.
///
/// The attributes tell the tools of AMD and Intel what these flops are; they stand here and nowhere else.
module ti_sync #(
  /// Bits, 1 or more.
  parameter int unsigned Width  = 1,
  /// Flops in a row, 2 or more.
  parameter int unsigned Stages = 2
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic [Width-1:0] in_i,
  output logic [Width-1:0] out_o
);

  (* ASYNC_REG = "TRUE", altera_attribute = "-name SYNCHRONIZER_IDENTIFICATION FORCED" *)
  logic [Stages-1:0][Width-1:0] stage_q;

  logic [Width-1:0] seen;
`ifdef TI_SYNC_JITTER
  // For tests of crossings: at its first edge the last change of `in_i` is seen or not, bit by bit.
  logic [Width-1:0] old, last, in_q, random_q;
  always @(in_i) begin
    old  = last;
    last = in_i;
  end
  always_ff @(posedge clk_i) begin
    in_q     <= in_i;
    random_q <= Width'($urandom());
  end
  assign seen = (in_i != in_q) ? (in_i & random_q) | (old & ~random_q) : in_i;
`else
  assign seen = in_i;
`endif

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) stage_q <= '0;
    else stage_q <= {stage_q[Stages-2:0], seen};
  end
  assign out_o = stage_q[Stages-1];

  if (Width < 1) begin : gen_check_width
    $error("ti_sync: Width must be 1 or more");
  end
  if (Stages < 2) begin : gen_check_stages
    $error("ti_sync: Stages must be 2 or more");
  end

endmodule : ti_sync
