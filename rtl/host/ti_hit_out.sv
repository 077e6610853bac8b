// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// Hits of one stream as words of an AXI4-Stream.
///
/// A hit is a beat of 32 bytes: number of the ray in its packet, primitive (all ones: none), t, u, v, status, steps, 0,
/// lowest first.  The last one of a packet, which `ti_ray_in` knows, has TLAST.  Latency 1 cycle, a hit a cycle;
/// all outputs come from registers.
module ti_hit_out (
  input logic clk_i,
  input logic rst_ni,

  input  logic         hit_valid_i,
  output logic         hit_ready_o,
  input  ti_pkg::hit_t hit_data_i,
  input  logic         last_i,       // it is the last one of its packet

  output logic         m_axis_tvalid,
  input  logic         m_axis_tready,
  output logic [255:0] m_axis_tdata,
  output logic         m_axis_tlast
);

  logic [7:0][31:0] words;

  always_comb begin
    words    = '0;
    words[0] = hit_data_i.ray_id;
    words[1] = hit_data_i.prim;
    words[2] = 32'(hit_data_i.t);
    words[3] = 32'(hit_data_i.u);
    words[4] = 32'(hit_data_i.v);
    words[5] = 32'(hit_data_i.status);
    words[6] = 32'(hit_data_i.steps);
  end

  // A miss is known by its primitive.
  logic unused_hit;
  assign unused_hit = hit_data_i.hit;

  ti_fifo #(
    .payload_t(logic [256:0]),
    .Depth    (2)
  ) u_hits (
    .clk_i,
    .rst_ni,
    .in_valid_i (hit_valid_i),
    .in_ready_o (hit_ready_o),
    .in_data_i  ({last_i, words}),
    .out_valid_o(m_axis_tvalid),
    .out_ready_i(m_axis_tready),
    .out_data_o ({m_axis_tlast, m_axis_tdata})
  );

  `TI_ASSERT_NEXT(OutHeldUntilTaken, m_axis_tvalid && !m_axis_tready, m_axis_tvalid && $stable
                  ({m_axis_tlast, m_axis_tdata}))
  `TI_ASSERT_KNOWN(ValidKnown, m_axis_tvalid)

endmodule : ti_hit_out
