// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The constants of a ray for Woop's triangle test (Woop, Benthin, Wald 2013).
///
/// z is the axis of the largest |d|, the lowest at a tie, x = z + 1, y = z + 2 mod 3: sx = d[x] * inv[z],
/// sy = d[y] * inv[z], sz = inv[z].  One ray a cycle, `Latency` cycles, no stall.  2 MUL.
module ti_rd_shear #(
  localparam int unsigned ChooseLatency = 1,
  localparam int unsigned Latency = ChooseLatency + ti_fp_pkg::MulLatency
) (
  input logic clk_i,
  input logic rst_ni,

  input logic          valid_i,
  input ti_pkg::vec3_t d_i,
  input ti_pkg::vec3_t inv_i,    // 1 / d

  output logic                valid_o,
  output logic          [1:0] z_o,
  output ti_pkg::vec3_t       shear_o   // sx, sy, sz
);

  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;
  localparam int unsigned W = ti_num_pkg::FpWidth;
  typedef ti_pkg::fp_t fp_t;

  logic y_larger, z_larger, choose_q;
  logic [1:0] z, z_q;
  fp_t dx_q, dy_q, inv_q;
  assign y_larger = d_i[1][W-2:0] > d_i[0][W-2:0];
  assign z_larger = d_i[2][W-2:0] > d_i[y_larger?1 : 0][W-2:0];
  assign z = z_larger ? 2'd2 : {1'b0, y_larger};

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) choose_q <= 1'b0;
    else choose_q <= valid_i;
  end
  always_ff @(posedge clk_i) begin
    if (valid_i) begin
      z_q   <= z;
      inv_q <= inv_i[z];
      unique case (z)
        2'd0: {dy_q, dx_q} <= {d_i[2], d_i[1]};
        2'd1: {dy_q, dx_q} <= {d_i[0], d_i[2]};
        default: {dy_q, dx_q} <= {d_i[1], d_i[0]};
      endcase
    end
  end

  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_sx (
    .clk_i,
    .rst_ni,
    .valid_i(choose_q),
    .a_i(dx_q),
    .b_i(inv_q),
    .valid_o(valid_o),
    .result_o(shear_o[0])
  );
  ti_fp_mul #(
    .ExpBits (E),
    .FracBits(M)
  ) u_sy (
    .clk_i,
    .rst_ni,
    .valid_i(choose_q),
    .a_i(dy_q),
    .b_i(inv_q),
    .valid_o(),
    .result_o(shear_o[1])
  );
  ti_delay #(
    .payload_t(logic [W+1:0]),
    .Cycles   (ti_fp_pkg::MulLatency)
  ) u_along (
    .clk_i,
    .rst_ni,
    .data_i({z_q, inv_q}),
    .data_o({z_o, shear_o[2]})
  );

  `TI_ASSERT_KNOWN(ValidKnown, valid_o)

endmodule : ti_rd_shear
