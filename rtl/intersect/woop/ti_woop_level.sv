// SPDX-License-Identifier: Apache-2.0

`include "ti_reset.svh"

/// Brings the weights of a Woop test to one size: all times the power of two that puts the largest into [2, 4).
///
/// So neither their sum, its reciprocal nor their products with ways leave the range of the format, however small or
/// large the triangle is, and a mean of ways of the least number keeps its sign.  What is then below the least normal
/// number is cut to a subnormal, or to zero of its sign where the format flushes them; three zeros, and a triple with
/// an infinity, stay as they are.  Latency `Latency` cycles, one triple a cycle, never stalls.
module ti_woop_level #(
  localparam int unsigned Latency = 1
) (
  input logic clk_i,
  input logic rst_ni,

  input logic          valid_i,
  input ti_pkg::vec3_t weight_i, // no NaN

  output logic          valid_o,
  output ti_pkg::vec3_t level_o
);

  localparam int unsigned W = ti_num_pkg::FpWidth;
  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;
  localparam int Bias = (1 << (E - 1)) - 1;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) valid_o <= 1'b0;
    else valid_o <= valid_i;
  end

  always_ff @(posedge clk_i) begin
    automatic logic [2:0][M:0] sig;  // with its leading bit
    automatic int exponent[3];  // of that bit; those of subnormals are below 1
    automatic int largest, place;
    automatic logic infinite, found;

    if (valid_i) begin
      largest  = 0;
      found    = 1'b0;
      infinite = 1'b0;
      for (int k = 0; k < 3; k++) begin
        exponent[k] = int'(weight_i[k][M+:E]);
        sig[k] = {exponent[k] != 0, weight_i[k][M-1:0]};
        infinite = infinite || weight_i[k][M+:E] == '1;
        if (exponent[k] == 0) begin
          exponent[k] = 1;
          for (int step = 16; step > 0; step /= 2) begin
            if (step <= int'(M) && (sig[k] >> (int'(M) + 1 - step)) == '0) begin
              sig[k] = sig[k] << step;
              exponent[k] -= step;
            end
          end
        end
        if (sig[k][M] && (!found || exponent[k] > largest)) begin
          largest = exponent[k];
          found   = 1'b1;
        end
      end
      for (int k = 0; k < 3; k++) begin
        place = exponent[k] - largest + Bias + 1;  // the new exponent
        level_o[k] <= weight_i[k];
        if (!infinite && sig[k][M]) begin
          if (place >= 1) begin
            level_o[k][W-2:0] <= {E'(place), sig[k][M-1:0]};
          end else begin
            level_o[k][W-2:0] <= ti_fp_pkg::Flush ? '0 : (W - 1)'(sig[k] >> (1 - place));
          end
        end
      end
    end
  end

endmodule : ti_woop_level
