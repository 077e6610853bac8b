// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// An arrived line on its way into the L1 of a `ti_ra`, `WordBytes` a cycle, the lowest first.
///
/// The answer stands at the port until its last word is stored, `LineBytes / WordBytes` cycles in all; `fill_o` is up in the
/// cycle of that.  Whether the answer is awaited counts when its first word is there: one that nobody waits for is taken
/// in as many cycles, and nothing of it is stored.
module ti_ra_fill #(
  parameter int unsigned LineBytes = 64,
  /// Divides LineBytes into a power of two.
  parameter int unsigned WordBytes = 8,
  localparam int unsigned Words = LineBytes / ((WordBytes > 0) ? WordBytes : 1),
  localparam int unsigned IndexWidth = (Words > 1) ? $clog2(Words) : 1
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic                   line_valid_i,
  output logic                   line_ready_o,
  input  logic [8*LineBytes-1:0] line_i,
  input  logic                   awaited_i,     // a row waits for it

  output logic                   write_o,
  output logic [ IndexWidth-1:0] index_o,
  output logic [8*WordBytes-1:0] word_o,
  output logic                   fill_o    // the last word of one that is awaited
);

  if (Words < 2) begin : gen_line
    logic unused;
    assign unused       = clk_i & rst_ni;
    assign index_o      = '0;
    assign line_ready_o = 1'b1;
    assign write_o      = line_valid_i && awaited_i;
  end else begin : gen_words
    logic [IndexWidth-1:0] index_q;
    logic first, awaited_q;
    assign first        = index_q == '0;
    assign index_o      = index_q;
    assign line_ready_o = index_q == IndexWidth'(Words - 1);
    assign write_o      = line_valid_i && (first ? awaited_i : awaited_q);

    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) index_q <= '0;
      else if (line_valid_i) index_q <= index_q + 1'b1;
    end
    always_ff @(posedge clk_i) if (line_valid_i && first) awaited_q <= awaited_i;

    `TI_ASSERT_NEXT(StandsUntilStored, line_valid_i && !line_ready_o, line_valid_i && $stable(line_i
                    ))
  end

  assign word_o = line_i[32'(index_o)*8*WordBytes+:8*WordBytes];
  assign fill_o = write_o && line_ready_o;

  `TI_COVER(StrayAnswer, line_valid_i && !awaited_i)

  if (Words * WordBytes != LineBytes || (Words & (Words - 1)) != 0) begin : gen_check_word_bytes
    $error("ti_ra_fill: WordBytes must divide LineBytes into a power of two");
  end

endmodule : ti_ra_fill
