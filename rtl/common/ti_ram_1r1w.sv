// SPDX-License-Identifier: Apache-2.0

/// Memory with one registered read port and one write port; the place to swap in a block RAM or macro.
///
/// Latency 1 cycle.  `read_data_o` keeps its value while `read_en_i` is low.  A read of the address that is
/// written in the same cycle returns anything, and callers never use such a read: in simulation it is the
/// inverse of the old word.
module ti_ram_1r1w #(
  parameter type word_t = logic,
  /// Words, 1 or more.
  parameter int unsigned Depth = 2,
  localparam int unsigned AddrWidth = (Depth > 1) ? $clog2(Depth) : 1
) (
  input logic clk_i,

  input  logic                  read_en_i,
  input  logic  [AddrWidth-1:0] read_addr_i,
  output word_t                 read_data_o,

  input logic                  write_en_i,
  input logic  [AddrWidth-1:0] write_addr_i,
  input word_t                 write_data_i
);

  word_t mem_q[Depth];

  always_ff @(posedge clk_i) begin
    if (read_en_i) read_data_o <= mem_q[read_addr_i];
    if (write_en_i) mem_q[write_addr_i] <= write_data_i;
`ifndef SYNTHESIS
    if (read_en_i && write_en_i && read_addr_i == write_addr_i) begin
      read_data_o <= ~mem_q[read_addr_i];
    end
`endif
  end

  if (Depth < 1) begin : gen_check_depth
    $error("ti_ram_1r1w: Depth must be 1 or more");
  end

endmodule : ti_ram_1r1w
