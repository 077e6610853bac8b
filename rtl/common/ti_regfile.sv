// SPDX-License-Identifier: Apache-2.0

/// Memory with one asynchronous read and one write port: distributed RAM of an FPGA, a register file of an ASIC.
///
/// `read_data_o` is the word at `read_addr_i`, in the same cycle; a word that is written can be read from the next
/// cycle on.  For queues, lists and what is looked up by slot; what is read at several places at once, or needs a
/// reset, stays registers.
module ti_regfile #(
  parameter type word_t = logic,
  /// Words, 1 or more.
  parameter int unsigned Depth = 2,
  /// With fewer bits, or one word, it is registers: the least that is worth a distributed RAM.
  parameter int unsigned RamBits = 8,
  localparam int unsigned AddrWidth = (Depth > 1) ? $clog2(Depth) : 1
) (
  input logic clk_i,

  input  logic  [AddrWidth-1:0] read_addr_i,
  output word_t                 read_data_o,

  input logic                  write_en_i,
  input logic  [AddrWidth-1:0] write_addr_i,
  input word_t                 write_data_i
);

  // Xilinx, Gowin and Yosys; Intel, where Lattice's `syn_ramstyle` would be the same attribute.
  if (Depth > 1 && Depth * $bits(word_t) >= RamBits) begin : gen_ram
    (* ram_style = "distributed", ramstyle = "MLAB" *) word_t mem_q[Depth];
    always_ff @(posedge clk_i) if (write_en_i) mem_q[write_addr_i] <= write_data_i;
    assign read_data_o = mem_q[read_addr_i];
  end else begin : gen_registers
    (* ram_style = "registers", ramstyle = "logic" *) word_t mem_q[Depth];
    always_ff @(posedge clk_i) if (write_en_i) mem_q[write_addr_i] <= write_data_i;
    assign read_data_o = mem_q[read_addr_i];
  end

  if (Depth < 1 || RamBits < 1) begin : gen_check
    $error("ti_regfile: Depth and RamBits must be 1 or more");
  end

endmodule : ti_regfile
