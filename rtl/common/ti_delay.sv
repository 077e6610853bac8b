// SPDX-License-Identifier: Apache-2.0

`include "ti_reset.svh"

/// A payload that leaves `Cycles` cycles after it came, beside a pipeline of fixed latency.
///
/// No stall, no reset: what comes out means something only where the pipeline's valid bit says so.
/// From three cycles on it is a ring in distributed RAM, which costs one word moved a cycle, or with
/// `ti_config_pkg::RingDelays` 0 a chain of registers, which synthesis turns into shift registers.
module ti_delay #(
  parameter type payload_t = logic,
  /// 0 or more.
  parameter int unsigned Cycles = 1
) (
  input logic clk_i,
  input logic rst_ni,
  input payload_t data_i,
  output payload_t data_o
);

  if (Cycles == 0) begin : gen_wire
    logic unused;
    assign unused = clk_i & rst_ni;
    assign data_o = data_i;
  end else if (Cycles <= 2 || ti_config_pkg::RingDelays == 0) begin : gen_shift
    payload_t stage_q[Cycles];
    logic unused;
    assign unused = rst_ni;
    always_ff @(posedge clk_i) begin
      stage_q[0] <= data_i;
      for (int unsigned i = 1; i < Cycles; i++) stage_q[i] <= stage_q[i-1];
    end
    assign data_o = stage_q[Cycles-1];
  end else begin : gen_ring
    localparam int unsigned Depth = Cycles - 1;
    localparam int unsigned PointerWidth = $clog2(Depth);
    payload_t oldest, out_q;
    logic [PointerWidth-1:0] pointer_q;

    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) pointer_q <= '0;
      else pointer_q <= (pointer_q == PointerWidth'(Depth - 1)) ? '0 : pointer_q + 1'b1;
    end

    ti_regfile #(
      .word_t(payload_t),
      .Depth (Depth)
    ) u_ring (
      .clk_i,
      .read_addr_i (pointer_q),
      .read_data_o (oldest),
      .write_en_i  (1'b1),
      .write_addr_i(pointer_q),
      .write_data_i(data_i)
    );
    always_ff @(posedge clk_i) out_q <= oldest;
    assign data_o = out_q;
  end

endmodule : ti_delay
