// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_ray_in` gives each beat of the stream on as one ray, in order, its words unchanged and numbered from 0 in its
/// packet.  It takes none without `run_i`, nor behind a TLAST until that packet has had as many hits as it had rays; of
/// those the last one, and no other, is said to be the last.
module ti_ray_in_formal (
  input logic                 clk_i,
  input logic                 rst_ni,
  input logic                 run_i,
  input logic                 empty_o,
  input logic                 take_o,
  input logic                 s_axis_tvalid,
  input logic                 s_axis_tready,
  input logic         [255:0] s_axis_tdata,
  input logic                 s_axis_tlast,
  input logic                 ray_valid_o,
  input logic                 ray_ready_i,
  input ti_pkg::ray_t         ray_data_o,
  input logic                 hit_i,
  input logic                 last_o
);
  `TI_STARTS_IN_RESET

  localparam int unsigned W = ti_num_pkg::FpWidth;

  // The packet: rays since the last TLAST, rays that have no hit yet, and whether its TLAST has come.
  logic take, closed_q;
  logic [31:0] rays_q, open_q;
  assign take = s_axis_tvalid && s_axis_tready;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      rays_q   <= '0;
      open_q   <= '0;
      closed_q <= 1'b0;
    end else begin
      if (take) rays_q <= s_axis_tlast ? '0 : rays_q + 1'b1;
      if (take && !hit_i) open_q <= open_q + 1'b1;
      if (hit_i && !take) open_q <= open_q - 1'b1;
      if (take && s_axis_tlast) closed_q <= 1'b1;
      else if (hit_i && open_q == 32'd1) closed_q <= 1'b0;
    end
  end

  // `ti_engine` gives a hit for a ray; it has fewer slots than 32 bits count.
  `TI_ASSUME(HitOfARay, hit_i -> open_q != '0)
  `TI_ASSUME(CountedIn32Bits, open_q != '1)

  logic second_q;  // a packet is over
  always_ff @(posedge clk_i) begin
    if (!rst_ni) second_q <= 1'b0;
    else if (hit_i && last_o) second_q <= 1'b1;
  end

  localparam int unsigned CountWidth = 2;
  typedef struct packed {
    logic [31:0]      number;
    logic [7:0][31:0] words;
  } word_t;
  word_t pushed;
  logic push, pop;
  assign push   = take;
  assign pop    = ray_valid_o && ray_ready_i;
  assign pushed = '{number: rays_q, words: s_axis_tdata};
  `include "watched.svh"

  `TI_ASSERT(TakesWhileItMay, s_axis_tready == (run_i && !closed_q && inside_q != 2'd2))
  `TI_ASSERT(SaysWhatItTakes, take_o == take && empty_o == (inside_q == '0))
  `TI_ASSERT(GivesWhileOneIsInside, ray_valid_o == (inside_q != '0))
  `TI_ASSERT(NumberedInItsPacket, its_turn -> ray_data_o.ray_id == word_q.number)
  `TI_ASSERT(NoAnyHitRay, ray_valid_o -> !ray_data_o.any_hit)
  for (genvar axis = 0; axis < 3; axis++) begin : gen_axis
    `TI_ASSERT(OriginFirst, its_turn -> ray_data_o.o[axis] == W'(word_q.words[axis]))
    `TI_ASSERT(DirectionBehindTmin, its_turn -> ray_data_o.d[axis] == W'(word_q.words[4+axis]))
  end
  `TI_ASSERT(TminFourth, its_turn -> ray_data_o.tmin == W'(word_q.words[3]))
  `TI_ASSERT(TmaxEighth, its_turn -> ray_data_o.tmax == W'(word_q.words[7]))
  `TI_ASSERT_NEXT(RayHeldUntilTaken, ray_valid_o && !ray_ready_i, ray_valid_o && $stable(ray_data_o
                                                                                            ))

  `TI_ASSERT(LastHitOfThePacket, last_o == (closed_q && open_q == 32'd1))
  `TI_ASSERT(ClosedUntilTheLastHit, closed_q -> open_q != '0)

  `TI_COVER(SecondRayOfTheSecondPacket, its_turn && word_q.number == 32'd1 && second_q)
  `TI_COVER(LastOfSeveral, hit_i && last_o && $past(hit_i && !last_o))
  `TI_COVER(WaitsWithRoom, s_axis_tvalid && run_i && inside_q == '0 && closed_q)
endmodule : ti_ray_in_formal

bind ti_ray_in ti_ray_in_formal u_formal (.*);
