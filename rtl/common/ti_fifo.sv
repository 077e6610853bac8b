// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// A first-word-fall-through queue.
///
/// A beat taken in one cycle can leave in the next; one beat a cycle both ways (one in two cycles with
/// Depth 1).  `in_ready_o` and `out_valid_o` come from registers, so no path runs through: with Depth 2 this is
/// what cuts a stream at the border of a unit.  `out_data_o` is an asynchronous read of a `ti_regfile`.
module ti_fifo #(
  parameter type payload_t = logic,
  /// Entries, 1 or more.
  parameter int unsigned Depth = 2,
  localparam int unsigned PointerWidth = (Depth > 1) ? $clog2(Depth) : 1,
  localparam int unsigned CountWidth = $clog2(Depth + 1)
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic     in_valid_i,
  output logic     in_ready_o,
  input  payload_t in_data_i,

  output logic     out_valid_o,
  input  logic     out_ready_i,
  output payload_t out_data_o
);

  logic [PointerWidth-1:0] head_q, tail_q, head_next, tail_next;
  logic [CountWidth-1:0] count_q;
  logic push, pop;

  assign in_ready_o  = count_q < CountWidth'(Depth);
  assign out_valid_o = count_q != '0;
  assign push        = in_valid_i && in_ready_o;
  assign pop         = out_valid_o && out_ready_i;

  assign head_next   = (head_q == PointerWidth'(Depth - 1)) ? '0 : head_q + 1'b1;
  assign tail_next   = (tail_q == PointerWidth'(Depth - 1)) ? '0 : tail_q + 1'b1;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      head_q  <= '0;
      tail_q  <= '0;
      count_q <= '0;
    end else begin
      if (push) tail_q <= tail_next;
      if (pop) head_q <= head_next;
      if (push != pop) count_q <= push ? count_q + 1'b1 : count_q - 1'b1;
    end
  end

  ti_regfile #(
    .Depth (Depth),
    .word_t(payload_t)
  ) u_words (
    .clk_i,
    .read_addr_i (head_q),
    .read_data_o (out_data_o),
    .write_en_i  (push),
    .write_addr_i(tail_q),
    .write_data_i(in_data_i)
  );

  if (Depth < 1) begin : gen_check_depth
    $error("ti_fifo: Depth must be 1 or more");
  end

  `TI_ASSERT(OutHeldUntilTaken, out_valid_o && !out_ready_i |=> out_valid_o && $stable(out_data_o))
  `TI_ASSERT(NeverOverfull, count_q <= CountWidth'(Depth))
  `TI_ASSERT_KNOWN(InReadyKnown, in_ready_o)
  `TI_ASSERT_KNOWN(OutValidKnown, out_valid_o)

endmodule : ti_fifo
