// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// Combinational choice of one request, the next at or above `from_i`, wrapping.
module ti_round_robin #(
  /// Requests, 1 or more.
  parameter int unsigned Num = 2,
  localparam int unsigned IndexWidth = (Num > 1) ? $clog2(Num) : 1
) (
  input  logic [       Num-1:0] request_i,
  input  logic [IndexWidth-1:0] from_i,
  output logic                  any_o,
  output logic [IndexWidth-1:0] index_o
);

  logic [Num-1:0] upper, pick, lowest;

  assign any_o  = |request_i;
  assign upper  = request_i & ~((Num'(1) << from_i) - Num'(1));
  assign pick   = (|upper) ? upper : request_i;
  assign lowest = pick & (~pick + Num'(1));

  // Index of a one-hot word: bit b of the index is the OR of the positions that have it.
  function automatic logic [Num-1:0] position_mask(input int unsigned b);
    for (int unsigned i = 0; i < Num; i++) position_mask[i] = i[b];
  endfunction

  for (genvar b = 0; b < IndexWidth; b++) begin : gen_bit
    localparam logic [Num-1:0] Positions = position_mask(b);
    assign index_o[b] = |(lowest & Positions);
  end

  if (Num < 1) begin : gen_check_num
    $error("ti_round_robin: Num must be 1 or more");
  end

endmodule : ti_round_robin
