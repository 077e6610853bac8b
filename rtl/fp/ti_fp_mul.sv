// SPDX-License-Identifier: Apache-2.0

`include "ti_reset.svh"

/// Floating-point a * b.
///
/// Latency `Stages`, one result a cycle, never stalls: `valid_o` is `valid_i` that many cycles
/// later.  All paths start and end in registers except the inputs.  A stage works only for a valid
/// pair.  With 4 stages the operands stand in registers in front of the multiplier, which leaves
/// time for what the caller has in front; with 5 the product is made in two halves, added in the
/// next stage; with 6 the product moves in two stages, with 7 its last place has one of its own, and
/// with 8 each half is made of two quarters.
///
/// IEEE 754: one rounding to nearest even; subnormals kept on both sides; overflow gives infinity;
/// a NaN operand or 0 * infinity gives the one quiet NaN (sign 0, fraction 10...0); the sign of
/// every other result, zeros included, is the exclusive or of the signs.  Method: full product of
/// the significands as they stand; beside it the leading zeros of the smaller one, as far as the
/// exponent allows; one shift (left by them, or right into the subnormals), round.
/// With `TowardZero` nothing is added when rounding, and overflow gives the largest number.  With
/// `Flush` a subnormal operand is zero of its sign, and a result is rounded as if exponents had no
/// end, then zero of its sign where its exponent is below 1: no zeros are counted, and one place to
/// the left is all that is shifted.
module ti_fp_mul #(
  /// Exponent bits, 3 to 8.
  parameter int unsigned ExpBits = 8,
  /// Stored fraction bits, 2 to 23.
  parameter int unsigned FracBits = 23,
  /// Register stages, 3 to 8.
  parameter int unsigned Stages = ti_fp_pkg::MulLatency,
  /// Whether results are rounded toward zero; to nearest even when not.
  parameter bit TowardZero = ti_fp_pkg::TowardZero,
  /// Whether subnormals are zeros, as operands and as results.
  parameter bit Flush = ti_fp_pkg::Flush,
  localparam int unsigned Width = 1 + ExpBits + FracBits
) (
  input logic clk_i,
  input logic rst_ni,

  input logic             valid_i,
  input logic [Width-1:0] a_i,
  input logic [Width-1:0] b_i,

  output logic             valid_o,
  output logic [Width-1:0] result_o
);

  // A step of latency 0 is done in the stage of the next one.
  localparam int unsigned UnpackLatency = (Stages >= 4) ? 1 : 0;
  localparam int unsigned QuartersLatency = (Stages >= 8) ? 1 : 0;
  localparam int unsigned HalvesLatency = (Stages >= 5) ? 1 : 0;
  localparam int unsigned ProductLatency = 1;
  localparam int unsigned ScaleLatency = (Stages >= 6) ? 1 : 0;
  localparam int unsigned ShiftLatency = (Stages >= 7) ? 1 : 0;
  localparam int unsigned TopLatency = 1;
  localparam int unsigned RoundLatency = 1;

  // The stage of each step; that of unpacking is 0.
  localparam int unsigned QuartersStage = UnpackLatency;
  localparam int unsigned HalvesStage = QuartersStage + QuartersLatency;
  localparam int unsigned ProductStage = HalvesStage + HalvesLatency;
  localparam int unsigned ScaleStage = ProductStage + ProductLatency;
  localparam int unsigned ShiftStage = ScaleStage + ScaleLatency;
  localparam int unsigned TopStage = ShiftStage + ShiftLatency;
  localparam int unsigned RoundStage = TopStage + TopLatency;
  localparam int unsigned Latency = RoundStage + RoundLatency;

  localparam int unsigned MagBits = ExpBits + FracBits;
  localparam int unsigned SigBits = FracBits + 1;
  localparam int unsigned LowBits = SigBits / 2;
  localparam int unsigned HighBits = SigBits - LowBits;
  localparam int unsigned ProdBits = 2 * SigBits;
  // Enough for the signed sum of two exponents of up to 8 bits less the bias.
  localparam int unsigned SumExpBits = 10;
  localparam int signed Bias = (1 << (ExpBits - 1)) - 1;
  localparam int unsigned ExpMax = (1 << ExpBits) - 1;
  // A shift to the right by SigBits + 1 leaves nothing but the sticky bit.
  localparam int unsigned ShiftBits = $clog2(SigBits + 2);
  // Leading zeros are counted in groups of four places.
  localparam int unsigned NumGroups = (SigBits + 3) / 4;
  localparam int unsigned GroupBits = (NumGroups > 1) ? $clog2(NumGroups) : 1;

  if (ExpBits < 3 || ExpBits > 8) begin : gen_check_exp_bits
    $error("ti_fp_mul: ExpBits must be 3 to 8.");
  end
  if (FracBits < 2 || FracBits > 23) begin : gen_check_frac_bits
    $error("ti_fp_mul: FracBits must be 2 to 23.");
  end
  if (Latency != Stages) begin : gen_check_stages
    $error("ti_fp_mul: Stages must be 3 to 8.");
  end

  typedef struct packed {
    logic sign;
    logic to_nan;
    logic to_inf;
    logic to_max;   // overflow toward zero
    logic to_zero;  // flushed
  } side_t;

  logic [Latency-1:0] valid_q;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      valid_q <= '0;
    end else begin
      valid_q <= {valid_q[Latency-2:0], valid_i};
    end
  end

  // Registers behind each step; those of a step of latency 0 are not used.
  logic [SigBits-1:0] unpack_a_q;
  logic [SigBits-1:0] unpack_b_q;
  logic [SigBits-1:0] unpack_left_q;
  logic unpack_counts_q;
  logic [SumExpBits-1:0] unpack_exp_q;  // of the product's top bit, two's complement
  side_t unpack_side_q;

  logic [SigBits-1:0] quarters_a_q;
  logic [SigBits-1:0] quarters_b_q;
  logic [2*LowBits-1:0] quarters_low_q;
  logic [SigBits-1:0] quarters_cross_q[2];
  logic [2*HighBits-1:0] quarters_high_q;
  logic [SigBits-1:0] quarters_left_q;
  logic quarters_counts_q;
  logic [SumExpBits-1:0] quarters_exp_q;
  side_t quarters_side_q;

  logic [SigBits+LowBits-1:0] halves_low_q;
  logic [SigBits+HighBits-1:0] halves_high_q;
  logic [SigBits-1:0] halves_left_q;
  logic [GroupBits-1:0] halves_group_q;
  logic halves_counts_q;
  logic [SumExpBits-1:0] halves_exp_q;
  side_t halves_side_q;

  logic [ProdBits-1:0] product_q;
  logic [ShiftBits-1:0] product_places_q;
  logic product_right_q;
  logic [SumExpBits-1:0] product_exp_q;
  side_t product_side_q;

  logic [ProdBits-1:0] scale_product_q;
  logic [1:0] scale_places_q;
  logic scale_right_q;
  logic [SumExpBits-1:0] scale_exp_q;
  side_t scale_side_q;

  logic [ProdBits-1:0] shift_product_q;
  logic shift_stays_q;
  logic [SumExpBits-1:0] shift_exp_q, shift_less_q;
  side_t shift_side_q;

  logic [MagBits-1:0] top_mag_q;
  logic top_guard_q, top_sticky_q;
  side_t top_side_q;

  // The last stage first: registers are read before they are written, and a simulator keeps no copy.
  always_ff @(posedge clk_i) begin
    automatic logic [Latency-1:0] valid;
    automatic side_t side;
    automatic logic [ExpBits-1:0] exp_a, exp_b;
    automatic logic [FracBits-1:0] frac_a, frac_b;
    automatic logic max_a, max_b, zero_a, zero_b;
    automatic logic [SigBits-1:0] sig_a, sig_b, limit, left;
    automatic logic [LowBits-1:0] low_a, low_b;
    automatic logic [HighBits-1:0] high_a, high_b;
    automatic logic [SigBits+LowBits-1:0] low;
    automatic logic [SigBits+HighBits-1:0] high;
    automatic logic [4*NumGroups-1:0] groups;
    automatic logic [GroupBits-1:0] group;
    automatic logic [2:0] first;
    automatic logic [SumExpBits-1:0] exponent, less, distance;
    automatic logic [ShiftBits-1:0] places;
    automatic logic [ ProdBits-1:0] product;
    automatic logic [  MagBits-1:0] mag;
    automatic logic counts, right, stays, lost, top, moves, up, over;

    valid = {valid_q[Latency-2:0], valid_i};
    if (valid != '0) begin
      for (int k = int'(Latency) - 1; k >= 0; k--) begin
        // Unpack: significands with their leading bit; exponent 0 has the scale of exponent 1.  One
        // significand may have leading zeros when the product moves left.
        if (k == 0 && valid[k]) begin
          exp_a = a_i[FracBits+:ExpBits];
          exp_b = b_i[FracBits+:ExpBits];
          frac_a = a_i[FracBits-1:0];
          frac_b = b_i[FracBits-1:0];
          max_a = &exp_a;
          max_b = &exp_b;
          zero_a = exp_a == '0 && (Flush || frac_a == '0);
          zero_b = exp_b == '0 && (Flush || frac_b == '0);
          sig_a = {Flush || exp_a != '0, frac_a};
          sig_b = {Flush || exp_b != '0, frac_b};
          counts = !Flush && !(sig_a[SigBits-1] && sig_b[SigBits-1]);
          left = sig_a[SigBits-1] ? sig_b : sig_a;
          side.sign = a_i[Width-1] ^ b_i[Width-1];
          side.to_inf = max_a || max_b;
          side.to_nan = (max_a && frac_a != '0) || (max_b && frac_b != '0)
              || (max_a && zero_b) || (max_b && zero_a);
          side.to_max = 1'b0;
          side.to_zero = Flush && (zero_a || zero_b);
          exp_a[0] = exp_a[0] || (!Flush && exp_a == '0);
          exp_b[0] = exp_b[0] || (!Flush && exp_b == '0);
          exponent = SumExpBits'(exp_a) + SumExpBits'(exp_b) - SumExpBits'(Bias - 1);
          unpack_a_q <= sig_a;
          unpack_b_q <= sig_b;
          unpack_left_q <= left;
          unpack_counts_q <= counts;
          unpack_exp_q <= exponent;
          unpack_side_q <= side;
        end

        // Quarters of the product.  Beside them a one at the place that would become exponent 1, where
        // the count ends.
        if (k == int'(QuartersStage) && valid[k]) begin
          if (UnpackLatency != 0) begin
            sig_a = unpack_a_q;
            sig_b = unpack_b_q;
            left = unpack_left_q;
            counts = unpack_counts_q;
            side = unpack_side_q;
            exponent = unpack_exp_q;
          end
          distance = exponent - SumExpBits'(1);
          limit = {1'b1, {(SigBits - 1) {1'b0}}} >> distance;
          left = left | limit;
          if (QuartersLatency != 0) begin
            {high_a, low_a} = sig_a;
            {high_b, low_b} = sig_b;
            quarters_low_q <= (2 * LowBits)'(low_a) * (2 * LowBits)'(low_b);
            quarters_cross_q[0] <= SigBits'(high_a) * SigBits'(low_b);
            quarters_cross_q[1] <= SigBits'(low_a) * SigBits'(high_b);
            quarters_high_q <= (2 * HighBits)'(high_a) * (2 * HighBits)'(high_b);
          end
          quarters_a_q <= sig_a;
          quarters_b_q <= sig_b;
          quarters_left_q <= left;
          quarters_counts_q <= counts;
          quarters_exp_q <= exponent;
          quarters_side_q <= side;
        end

        // Halves: by the lower and by the higher bits of b.  Count: the first group of places with a one.
        if (k == int'(HalvesStage) && valid[k]) begin
          if (QuartersLatency != 0) begin
            sig_a = quarters_a_q;
            sig_b = quarters_b_q;
            left = quarters_left_q;
            counts = quarters_counts_q;
            side = quarters_side_q;
            exponent = quarters_exp_q;
            low = (SigBits + LowBits)'(quarters_low_q)
                + {SigBits'(quarters_cross_q[0]), {LowBits{1'b0}}};
            high = {quarters_high_q, {LowBits{1'b0}}} + (SigBits + HighBits)'(quarters_cross_q[1]);
          end else begin
            low  = (SigBits + LowBits)'(sig_a) * (SigBits + LowBits)'(sig_b[LowBits-1:0]);
            high = (SigBits + HighBits)'(sig_a) * (SigBits + HighBits)'(sig_b[SigBits-1:LowBits]);
          end
          groups = (4 * NumGroups)'(left) << (4 * NumGroups - SigBits);
          group  = GroupBits'(NumGroups - 1);
          for (int i = int'(NumGroups) - 2; i >= 0; i--) begin
            if (groups[4*(int'(NumGroups)-1-i)+:4] != '0) group = GroupBits'(i);
          end
          halves_low_q <= low;
          halves_high_q <= high;
          halves_left_q <= left;
          halves_group_q <= group;
          halves_counts_q <= counts;
          halves_exp_q <= exponent;
          halves_side_q <= side;
        end

        // Product: in one piece unless its halves stand in registers.  Beside it the places by which it
        // moves: left by the count, or right to exponent 1, by all ones where nothing is left of it.
        if (k == int'(ProductStage) && valid[k]) begin
          if (HalvesLatency != 0) begin
            left = halves_left_q;
            group = halves_group_q;
            counts = halves_counts_q;
            exponent = halves_exp_q;
            side = halves_side_q;
            product = ProdBits'(halves_low_q) + {halves_high_q, {LowBits{1'b0}}};
          end else begin
            product = ProdBits'(sig_a) * ProdBits'(sig_b);
          end
          right = !Flush && (exponent[SumExpBits-1] || exponent == '0);
          distance = SumExpBits'(1) - exponent;
          groups = (4 * NumGroups)'(left) << (4 * NumGroups - SigBits);
          groups = groups << {group, 2'b00};
          first = groups[4*NumGroups-1-:3];
          places = ShiftBits'({
            group, !first[2] && !first[1], !first[2] && (first[1] || !first[0])
          }) & {ShiftBits{counts}};
          exponent = right ? '0 : exponent - SumExpBits'(places);
          if (right) begin
            places = ShiftBits'(distance) | {ShiftBits{(distance >> ShiftBits) != '0}};
          end
          product_q <= product;
          product_places_q <= places;
          product_right_q <= right;
          product_exp_q <= exponent;
          product_side_q <= side;
        end

        // Scale: by a multiple of 4 places; what leaves on the right is kept in the lowest bit.
        if (k == int'(ScaleStage) && valid[k]) begin
          product = product_q;
          places = product_places_q;
          right = product_right_q;
          exponent = product_exp_q;
          side = product_side_q;
          if (ScaleLatency != 0 && !Flush) begin
            places[1:0] = 2'b00;
            lost = (product & ~({ProdBits{1'b1}} << places)) != '0;
            product = right ? (product >> places) | ProdBits'(lost) : product << places;
            places = ShiftBits'(product_places_q[1:0]);
          end
          scale_product_q <= product;
          scale_places_q <= places[1:0];
          scale_right_q <= right;
          scale_exp_q <= exponent;
          scale_side_q <= side;
        end

        // Shift: by the rest.  At exponent 1, where subnormals are kept, it is the last.
        if (k == int'(ShiftStage) && valid[k]) begin
          if (ScaleLatency != 0) begin
            product = scale_product_q;
            places = ShiftBits'(scale_places_q);
            right = scale_right_q;
            exponent = scale_exp_q;
            side = scale_side_q;
          end
          if (!Flush) begin
            lost = (product & ~({ProdBits{1'b1}} << places)) != '0;
            product = right ? (product >> places) | ProdBits'(lost) : product << places;
          end
          stays = !Flush && (right || exponent == SumExpBits'(1));
          less  = exponent - SumExpBits'(1);
          shift_product_q <= product;
          shift_stays_q <= stays;
          shift_exp_q <= exponent;
          shift_less_q <= less;
          shift_side_q <= side;
        end

        // Top: once more to the left where the top bit is still 0.
        if (k == int'(TopStage) && valid[k]) begin
          if (ShiftLatency != 0) begin
            product = shift_product_q;
            stays = shift_stays_q;
            exponent = shift_exp_q;
            less = shift_less_q;
            side = shift_side_q;
          end
          top = product[ProdBits-1];
          moves = !top && !stays;
          product = product << moves;
          exponent = moves ? less : exponent;
          exponent = exponent & {SumExpBits{Flush || product[ProdBits-1]}};
          side.to_zero = side.to_zero || (Flush && exponent[SumExpBits-1]);
          top_mag_q <= {exponent[ExpBits-1:0], product[ProdBits-2-:FracBits]};
          top_guard_q <= product[ProdBits-2-FracBits];
          top_sticky_q <= |product[ProdBits-3-FracBits:0];
          over = 32'(exponent) >= ExpMax && !exponent[SumExpBits-1];
          side.to_inf = side.to_inf || (!TowardZero && over);
          side.to_max = TowardZero && over;
          top_side_q <= side;
        end

        // Round: a carry out of the fraction is the right exponent, up to infinity.
        if (k == int'(RoundStage) && valid[k]) begin
          up  = !TowardZero && top_guard_q && (top_sticky_q || top_mag_q[0]);
          mag = top_mag_q + MagBits'(up);
          if (top_side_q.to_nan) begin
            result_o <= {1'b0, {ExpBits{1'b1}}, 1'b1, {(FracBits - 1) {1'b0}}};
          end else if (top_side_q.to_inf) begin
            result_o <= {top_side_q.sign, {ExpBits{1'b1}}, {FracBits{1'b0}}};
          end else if (TowardZero && top_side_q.to_max) begin
            result_o <= {top_side_q.sign, {(ExpBits - 1) {1'b1}}, 1'b0, {FracBits{1'b1}}};
          end else if (Flush && (top_side_q.to_zero || mag[FracBits+:ExpBits] == '0)) begin
            result_o <= {top_side_q.sign, {MagBits{1'b0}}};
          end else begin
            result_o <= {top_side_q.sign, mag};
          end
        end
      end
    end
  end

  assign valid_o = valid_q[Latency-1];

endmodule : ti_fp_mul
