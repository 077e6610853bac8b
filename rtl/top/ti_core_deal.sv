// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Deals rays to cores, `Tile` rays in a row to each, so that rays that lie together share its caches.
///
/// A tile goes to the next core, round robin, that has room for a whole one, and waits where none has; so a slow core
/// holds nobody up while another has room, and none is passed over twice.  Each core has a queue of two tiles.
/// Latency 2 cycles, one ray a cycle.
module ti_core_deal #(
  parameter int unsigned NumCores = 1,
  /// Rays of a tile, 1 or more.
  parameter int unsigned Tile = 16
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic         ray_valid_i,
  output logic         ray_ready_o,
  input  ti_pkg::ray_t ray_data_i,

  output logic         [NumCores-1:0] core_valid_o,
  input  logic         [NumCores-1:0] core_ready_i,
  output ti_pkg::ray_t                core_data_o [NumCores]
);

  localparam int unsigned CoreWidth = (NumCores > 1) ? $clog2(NumCores) : 1;
  localparam int unsigned DealtWidth = (Tile > 1) ? $clog2(Tile) : 1;
  localparam int unsigned Depth = 2 * Tile;
  localparam int unsigned CountWidth = $clog2(Depth + 1);

  // The ray to deal.
  logic waits, deal;
  ti_pkg::ray_t ray;
  ti_fifo #(
    .payload_t(ti_pkg::ray_t),
    .Depth    (2)
  ) u_in (
    .clk_i,
    .rst_ni,
    .in_valid_i (ray_valid_i),
    .in_ready_o (ray_ready_o),
    .in_data_i  (ray_data_i),
    .out_valid_o(waits),
    .out_ready_i(deal),
    .out_data_o (ray)
  );

  // Whose tile it is: `core_q` once a tile has begun, else the next with room.
  logic open_q, any, last;
  logic [CoreWidth-1:0] core_q, from_q, next_core, core;
  logic [DealtWidth-1:0] dealt_q;
  logic [NumCores-1:0] roomy_q, push, queue_ready;

  ti_round_robin #(
    .Num(NumCores)
  ) u_next (
    .request_i(roomy_q),
    .from_i   (from_q),
    .any_o    (any),
    .index_o  (next_core)
  );

  assign core = open_q ? core_q : next_core;
  assign deal = waits && (open_q || any);
  assign last = dealt_q == DealtWidth'(Tile - 1);
  assign push = deal ? NumCores'(1) << core : '0;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      open_q  <= 1'b0;
      dealt_q <= '0;
      from_q  <= '0;
    end else if (deal) begin
      open_q  <= !last;
      dealt_q <= last ? '0 : dealt_q + 1'b1;
      if (!open_q) from_q <= (core == CoreWidth'(NumCores - 1)) ? '0 : core + 1'b1;
    end
  end
  always_ff @(posedge clk_i) if (deal) core_q <= core;

  for (genvar c = 0; c < NumCores; c++) begin : gen_core
    logic [CountWidth-1:0] held_q;
    logic leaves;
    assign leaves = core_valid_o[c] && core_ready_i[c];

    // Roomy: a whole tile finds place beside what is held.
    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) begin
        held_q     <= '0;
        roomy_q[c] <= 1'b1;
      end else if (push[c] && !leaves) begin
        held_q     <= held_q + 1'b1;
        roomy_q[c] <= held_q < CountWidth'(Depth - Tile);
      end else if (leaves && !push[c]) begin
        held_q     <= held_q - 1'b1;
        roomy_q[c] <= held_q <= CountWidth'(Depth - Tile + 1);
      end
    end
    `TI_ASSERT(RoomyForATile, roomy_q[c] == (held_q <= CountWidth'(Depth - Tile)))

    ti_fifo #(
      .payload_t(ti_pkg::ray_t),
      .Depth    (Depth)
    ) u_queue (
      .clk_i,
      .rst_ni,
      .in_valid_i (push[c]),
      .in_ready_o (queue_ready[c]),
      .in_data_i  (ray),
      .out_valid_o(core_valid_o[c]),
      .out_ready_i(core_ready_i[c]),
      .out_data_o (core_data_o[c])
    );
    `TI_ASSERT(QueueHasRoom, push[c] -> queue_ready[c])
  end

  logic unused_ready;
  assign unused_ready = |queue_ready;

  if (Tile < 1) begin : gen_check_tile
    $error("ti_core_deal: Tile must be 1 or more");
  end

endmodule : ti_core_deal
