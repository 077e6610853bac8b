// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_core_deal` gives each ray to one core, once and unchanged, in whole tiles: one core has all rays of a tile, in
/// order, and tiles go to cores in turn but for those without room.  A ray waits only while no core has room for
/// a tile.
module ti_core_deal_formal #(
  parameter int unsigned NumCores = 2,
  parameter int unsigned Tile = 2,
  localparam int unsigned CoreWidth = (NumCores > 1) ? $clog2(NumCores) : 1
) (
  input logic clk_i,
  input logic rst_ni,
  input logic ray_valid_i,
  input logic ray_ready_o,
  input ti_pkg::ray_t ray_data_i,
  input logic [NumCores-1:0] core_valid_o,
  input logic [NumCores-1:0] core_ready_i,
  input ti_pkg::ray_t core_data_o[NumCores],
  // What stands in its registers: the ray to deal among them.
  input ti_pkg::ray_t ray,
  input logic [NumCores-1:0] roomy_q,
  input logic open_q,
  input logic [((Tile > 1) ? $clog2(Tile) : 1)-1:0] dealt_q,
  input logic [NumCores-1:0] push  // what is dealt in this cycle, and to whom
);
  `TI_STARTS_IN_RESET

  localparam int unsigned Room = 2 * Tile;
  typedef logic [$clog2(Room + 2)-1:0] count_t;

  // Rays in front of the deal, dealt to each core and not taken by it, and of the tile that is being dealt.
  logic take, deal;
  logic [1:0] waiting_q;
  logic [NumCores-1:0] gives;
  count_t [NumCores-1:0] held_q;
  count_t of_tile_q;
  logic [NumCores-1:0] tile_q;  // whose tile it is
  assign take  = ray_valid_i && ray_ready_o;
  assign deal  = push != '0;
  assign gives = core_valid_o & core_ready_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      waiting_q <= '0;
      of_tile_q <= '0;
    end else begin
      waiting_q <= waiting_q + 2'(take) - 2'(deal);
      if (deal) of_tile_q <= (32'(of_tile_q) == Tile - 1) ? '0 : of_tile_q + 1'b1;
    end
    if (deal) tile_q <= push;
  end
  logic [NumCores-1:0] roomy;
  for (genvar c = 0; c < NumCores; c++) begin : gen_core
    always_ff @(posedge clk_i) begin
      if (!rst_ni) held_q[c] <= '0;
      else held_q[c] <= held_q[c] + count_t'(push[c]) - count_t'(gives[c]);
    end
    assign roomy[c] = 32'(held_q[c]) + Tile <= Room;
    `TI_ASSERT(HoldsTwoTiles, 32'(held_q[c]) <= Room)
    `TI_ASSERT(GivesWhileOneIsHeld, core_valid_o[c] == (held_q[c] != '0))
  end

  // One ray that is watched in front of the deal, whichever, and one behind it, which was dealt to `core_q`.
  logic pick_in, pick_out, in_q, out_q, its_deal, its_turn;
  logic [1:0] in_ahead_q;
  count_t out_ahead_q;
  logic [CoreWidth-1:0] core_q;
  ti_pkg::ray_t in_ray_q, out_ray_q;
  function automatic logic [CoreWidth-1:0] index_of(logic [NumCores-1:0] one_hot);
    index_of = '0;
    for (int unsigned c = 0; c < NumCores; c++) if (one_hot[c]) index_of = CoreWidth'(c);
  endfunction
  assign its_deal = in_q && in_ahead_q == '0 && deal;
  assign its_turn = out_q && out_ahead_q == '0;
  always_ff @(posedge clk_i) begin
    if (!in_q) begin
      in_ray_q   <= ray_data_i;
      in_ahead_q <= waiting_q - 2'(deal);
    end else if (deal) begin
      in_ahead_q <= in_ahead_q - 1'b1;
    end
    if (!out_q) begin
      out_ray_q   <= ray;
      core_q      <= index_of(push);
      out_ahead_q <= held_q[index_of(push)] - count_t'(gives[index_of(push)]);
    end else if (gives[core_q]) begin
      out_ahead_q <= out_ahead_q - 1'b1;
    end
    if (!rst_ni) begin
      in_q  <= 1'b0;
      out_q <= 1'b0;
    end else begin
      in_q  <= in_q ? !its_deal : take && pick_in;
      out_q <= out_q ? !(its_turn && gives[core_q]) : deal && pick_out;
    end
  end

  // Tiles of others that began since one of this core, whichever, while it had room for one.
  logic [CoreWidth-1:0] who;
  `TI_SYMBOL(who)
  WhoExists :
  assume property (@(posedge clk_i) (32'(who) < NumCores));
  logic begins;
  logic [$clog2(NumCores + 1)-1:0] others_q;
  assign begins = deal && of_tile_q == '0;
  always_ff @(posedge clk_i) begin
    if (!rst_ni || !roomy[who] || (begins && push[who])) others_q <= '0;
    else if (begins) others_q <= others_q + 1'b1;
  end

  `TI_ASSERT(DealsToOne, $onehot0(push))
  `TI_ASSERT(TakesWhileThereIsRoom, ray_ready_o == (waiting_q != 2'd2))
  `TI_ASSERT(TileOfOneCore, deal && of_tile_q != '0 -> push == tile_q)
  `TI_ASSERT(BeginsWithRoomForAll, begins -> (push & ~roomy) == '0)
  `TI_ASSERT(NoneIsPassedOverTwice, 32'(others_q) < NumCores)
  `TI_ASSERT(DealsWhileItCan, deal == (waiting_q != '0 && (of_tile_q != '0 || roomy != '0)))
  `TI_ASSERT(WatchedWaits, in_q -> in_ahead_q < waiting_q)
  `TI_ASSERT(WatchedIsDealtUnchanged, its_deal -> ray == in_ray_q)
  `TI_ASSERT(WatchedIsHeld, out_q -> out_ahead_q < held_q[core_q])
  `TI_ASSERT(WatchedComesUnchanged,
             its_turn -> core_valid_o[core_q] && core_data_o[core_q] == out_ray_q)
  `TI_ASSERT(RoomyIsKnown, roomy_q == roomy)
  `TI_ASSERT(PlaceInTheTileIsKnown, 32'(dealt_q) == 32'(of_tile_q) && open_q == (of_tile_q != '0))
  `TI_ASSERT(FitsOnceBegun, of_tile_q != '0 -> 32'(held_q[index_of(tile_q
             )]) + Tile - 32'(of_tile_q) <= Room)
  `TI_ASSERT(OneTile, of_tile_q != '0 -> $onehot(tile_q))

  `TI_COVER(AllAreFull, roomy == '0 && waiting_q == 2'd2 && of_tile_q == '0)
  `TI_COVER(WatchedIsSecondOfItsTile, its_deal && 32'(of_tile_q) == 1 && NumCores > 1 && !push[0])
endmodule : ti_core_deal_formal

// Rays are moved and not looked at: two bits, repeated, stand for one.
module ti_core_deal_top #(
  parameter int unsigned NumCores = 2,
  parameter int unsigned Tile = 2
) (
  input  logic                clk_i,
  input  logic                rst_ni,
  input  logic                ray_valid_i,
  output logic                ray_ready_o,
  input  logic [         1:0] data_i,
  output logic [NumCores-1:0] core_valid_o,
  input  logic [NumCores-1:0] core_ready_i
);
  ti_core_deal #(
    .NumCores(NumCores),
    .Tile    (Tile)
  ) u_unit (
    .ray_data_i ($bits(ti_pkg::ray_t)'({($bits(ti_pkg::ray_t) + 1) / 2{data_i}})),
    .core_data_o(),
    .*
  );
endmodule : ti_core_deal_top

bind ti_core_deal ti_core_deal_formal #(
  .NumCores(NumCores),
  .Tile    (Tile)
) u_formal (.*);
