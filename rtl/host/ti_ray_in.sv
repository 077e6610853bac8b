// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Rays of one stream from words of an AXI4-Stream, and the account of their packets.
///
/// A ray is a beat of 32 bytes, the row of `rays.npy`: origin, tmin, direction, tmax, a word each, lowest first, with
/// a value of the number format in its low bits.  Rays are numbered from 0 in each packet, which TLAST ends.  Behind
/// a TLAST none is taken until the last hit of the packet has passed `ti_hit_out`, so hits of two packets never mix.
///
/// Latency 1 cycle, a ray a cycle.  TREADY comes from registers and `run_i`; it does not look at TVALID.
module ti_ray_in (
  input  logic clk_i,
  input  logic rst_ni,
  input  logic run_i,    // rays are taken
  output logic empty_o,  // none waits here
  output logic take_o,   // a ray is taken

  input  logic         s_axis_tvalid,
  output logic         s_axis_tready,
  input  logic [255:0] s_axis_tdata,
  input  logic         s_axis_tlast,

  output logic         ray_valid_o,
  input  logic         ray_ready_i,
  output ti_pkg::ray_t ray_data_o,   // `any_hit` is 0

  input  logic hit_i,  // a hit of this stream passes
  output logic last_o  // the next one is the last of its packet
);

  localparam int unsigned FpWidth = ti_num_pkg::FpWidth;

  logic room, take, closed_q;
  logic [31:0] number_q;  // of the next ray
  logic [31:0] inside_q;  // rays without a hit
  ti_pkg::ray_t ray;

  always_comb begin
    ray        = '0;
    ray.ray_id = number_q;
    for (int unsigned axis = 0; axis < 3; axis++) begin
      ray.o[axis] = s_axis_tdata[32*axis+:FpWidth];
      ray.d[axis] = s_axis_tdata[32*(axis+4)+:FpWidth];
    end
    ray.tmin = s_axis_tdata[32*3+:FpWidth];
    ray.tmax = s_axis_tdata[32*7+:FpWidth];
  end

  assign s_axis_tready = run_i && room && !closed_q;
  assign take          = s_axis_tvalid && s_axis_tready;
  assign take_o        = take;
  assign empty_o       = !ray_valid_o;
  assign last_o        = closed_q && inside_q == 32'd1;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      number_q <= '0;
      inside_q <= '0;
      closed_q <= 1'b0;
    end else begin
      if (take) number_q <= s_axis_tlast ? '0 : number_q + 1'b1;
      if (take != hit_i) inside_q <= take ? inside_q + 1'b1 : inside_q - 1'b1;
      if (take && s_axis_tlast) closed_q <= 1'b1;
      else if (hit_i && last_o) closed_q <= 1'b0;
    end
  end

  ti_fifo #(
    .payload_t(ti_pkg::ray_t),
    .Depth    (2)
  ) u_rays (
    .clk_i,
    .rst_ni,
    .in_valid_i (take),
    .in_ready_o (room),
    .in_data_i  (ray),
    .out_valid_o(ray_valid_o),
    .out_ready_i(ray_ready_i),
    .out_data_o (ray_data_o)
  );

  `TI_ASSERT(HitOnlyOfARay, hit_i -> inside_q != '0)
  `TI_ASSERT(ClosedWhileInside, closed_q -> inside_q != '0)
  `TI_COVER(WaitsForItsPacket, s_axis_tvalid && closed_q)
  `TI_ASSERT_KNOWN(ReadyKnown, s_axis_tready)

endmodule : ti_ray_in
