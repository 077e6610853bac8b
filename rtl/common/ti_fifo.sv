// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// A first-word-fall-through queue with registers at all outputs.
///
/// A beat taken in one cycle can leave in the next; one beat a cycle both ways (one in two cycles with
/// Depth 1).  The beat at the output stands in a register, the others in a `ti_regfile` behind it; `in_ready_o` is
/// a register too.  So no path runs through: with Depth 2 this is what cuts a stream at the border of a unit.
module ti_fifo #(
  parameter type payload_t = logic,
  /// Entries, 1 or more.
  parameter int unsigned Depth = 2
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

  logic valid_q, full_q, push, load;
  payload_t data_q;

  assign in_ready_o  = !full_q;
  assign out_valid_o = valid_q;
  assign out_data_o  = data_q;
  assign push        = in_valid_i && in_ready_o;
  assign load        = !valid_q || out_ready_i;  // the register takes what comes next

  if (Depth < 2) begin : gen_one
    assign full_q = valid_q;

    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) valid_q <= 1'b0;
      else if (load) valid_q <= push;
    end
    always_ff @(posedge clk_i) if (load) data_q <= in_data_i;
  end else begin : gen_more
    localparam int unsigned Behind = Depth - 1;
    localparam int unsigned PointerWidth = (Behind > 1) ? $clog2(Behind) : 1;
    localparam int unsigned CountWidth = $clog2(Depth);

    // Beats behind the register; `waits_q` when there is one, `full_q` when there are all.  A beat that goes into the
    // register is written too, where the next one will be: no memory waits for `out_ready_i`.
    logic [PointerWidth-1:0] head_q, tail_q;
    logic [CountWidth-1:0] behind_q;
    logic waits_q, write, read;
    payload_t oldest;

    assign write = push && (waits_q || !load);
    assign read  = load && waits_q;

    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) begin
        valid_q  <= 1'b0;
        waits_q  <= 1'b0;
        full_q   <= 1'b0;
        head_q   <= '0;
        tail_q   <= '0;
        behind_q <= '0;
      end else begin
        if (load) valid_q <= waits_q || push;
        if (write) tail_q <= (tail_q == PointerWidth'(Behind - 1)) ? '0 : tail_q + 1'b1;
        if (read) head_q <= (head_q == PointerWidth'(Behind - 1)) ? '0 : head_q + 1'b1;
        if (write && !read) begin
          behind_q <= behind_q + 1'b1;
          waits_q  <= 1'b1;
          full_q   <= behind_q == CountWidth'(Behind - 1);
        end else if (read && !write) begin
          behind_q <= behind_q - 1'b1;
          waits_q  <= behind_q != CountWidth'(1);
          full_q   <= 1'b0;
        end
      end
    end
    always_ff @(posedge clk_i) if (load) data_q <= waits_q ? oldest : in_data_i;

    ti_regfile #(
      .Depth (Behind),
      .word_t(payload_t)
    ) u_words (
      .clk_i,
      .read_addr_i (head_q),
      .read_data_o (oldest),
      .write_en_i  (push),
      .write_addr_i(tail_q),
      .write_data_i(in_data_i)
    );

    `TI_ASSERT(CountsWhatWaits, waits_q == (behind_q != '0))
    `TI_ASSERT(FullWithAll, full_q == (behind_q == CountWidth'(Behind)))
    `TI_ASSERT(WaitsBehindTheRegister, waits_q -> valid_q)
  end

  if (Depth < 1) begin : gen_check_depth
    $error("ti_fifo: Depth must be 1 or more");
  end

  `TI_ASSERT_NEXT(OutHeldUntilTaken, out_valid_o && !out_ready_i, out_valid_o && $stable(out_data_o
                                                                                            ))
  `TI_ASSERT_KNOWN(InReadyKnown, in_ready_o)
  `TI_ASSERT_KNOWN(OutValidKnown, out_valid_o)

endmodule : ti_fifo
