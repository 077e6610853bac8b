// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_round_robin` chooses the first request at or above `from_i`, wrapping to 0 behind the last.
module ti_round_robin_formal #(
  parameter int unsigned Num = 2,
  localparam int unsigned IndexWidth = (Num > 1) ? $clog2(Num) : 1
) (
  input logic                  clk_i,
  input logic                  rst_ni,
  input logic [       Num-1:0] request_i,
  input logic [IndexWidth-1:0] from_i,
  input logic                  any_o,
  input logic [IndexWidth-1:0] index_o
);
  `TI_STARTS_IN_RESET

  // `ti_arbiter` and `ti_trv_visits` go from the last one on to 0.
  `TI_ASSUME(FromExists, 32'(from_i) < Num)

  // Requests that a way upwards from `from_i` passes before it comes to `i`.
  function automatic logic [31:0] way(logic [31:0] i);
    return (i >= 32'(from_i)) ? i - 32'(from_i) : i + Num - 32'(from_i);
  endfunction

  `TI_ASSERT(AnyWhenThereIsOne, any_o == (request_i != '0))
  `TI_ASSERT(ChoosesARequest, any_o -> 32'(index_o) < Num && request_i[index_o])
  for (genvar i = 0; i < Num; i++) begin : gen_request
    `TI_ASSERT(NoneComesBefore, request_i[i] -> way(32'(index_o)) <= way(i))
  end
  `TI_COVER(Wraps, any_o && (Num == 1 || index_o < from_i))
endmodule : ti_round_robin_formal

module ti_round_robin_top #(
  parameter int unsigned Num = 2,
  localparam int unsigned IndexWidth = (Num > 1) ? $clog2(Num) : 1
) (
  input  logic                  clk_i,
  input  logic                  rst_ni,
  input  logic [       Num-1:0] request_i,
  input  logic [IndexWidth-1:0] from_i,
  output logic                  any_o,
  output logic [IndexWidth-1:0] index_o
);
  ti_round_robin #(.Num(Num)) u_unit (.*);
  ti_round_robin_formal #(.Num(Num)) u_formal (.*);
endmodule : ti_round_robin_top
