// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// What `ti_delay` gives is what it was given `Cycles` cycles before, as a ring and as a shift register.
module ti_delay_formal #(
  parameter int unsigned Width  = 1,
  parameter int unsigned Cycles = 1
) (
  input logic             clk_i,
  input logic             rst_ni,
  input logic [Width-1:0] data_i,
  input logic [Width-1:0] data_o
);
  `TI_STARTS_IN_RESET

  // Data watched since it came; cycles since.
  localparam int unsigned CountWidth = $clog2(Cycles + 1);
  logic pick, watched_q;
  logic [CountWidth-1:0] age_q;
  logic [Width-1:0] data_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      watched_q <= 1'b0;
    end else if (!watched_q) begin
      watched_q <= pick;
      age_q     <= CountWidth'(1);
      data_q    <= data_i;
    end else begin
      watched_q <= age_q != CountWidth'(Cycles);
      age_q     <= age_q + 1'b1;
    end
  end

  `TI_ASSERT(ComesWhenItsTimeIsUp, watched_q && age_q == CountWidth'(Cycles) -> data_o == data_q)
  `TI_COVER(ComesAtAll, watched_q && age_q == CountWidth'(Cycles))
endmodule : ti_delay_formal

module ti_delay_top #(
  parameter int unsigned Cycles = 1
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic [1:0] data_i,
  output logic [1:0] data_o
);
  ti_delay #(
    .payload_t(logic [1:0]),
    .Cycles   (Cycles)
  ) u_unit (
    .*
  );
endmodule : ti_delay_top

bind ti_delay ti_delay_formal #(
  .Width ($bits(payload_t)),
  .Cycles(Cycles)
) u_formal (.*);
