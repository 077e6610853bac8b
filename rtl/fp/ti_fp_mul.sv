// SPDX-License-Identifier: Apache-2.0

`include "ti_reset.svh"

/// Floating-point a * b.
///
/// Latency `Stages`, one result a cycle, never stalls: `valid_o` is `valid_i` that many cycles
/// later.  All paths start and end in registers except the inputs.  A stage works only for a valid
/// pair.  With 4 stages the operands stand in registers in front of the multiplier, which leaves
/// time for what the caller has in front; with 5 the product is made in two halves, added in the
/// next stage.
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
  /// Register stages, 3 to 5.
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
  localparam int unsigned HalvesLatency = (Stages >= 5) ? 1 : 0;
  localparam int unsigned ProductLatency = 1;
  localparam int unsigned ShiftLatency = 1;
  localparam int unsigned RoundLatency = 1;

  // The stage of each step; that of unpacking is 0.
  localparam int unsigned HalvesStage = UnpackLatency;
  localparam int unsigned ProductStage = HalvesStage + HalvesLatency;
  localparam int unsigned ShiftStage = ProductStage + ProductLatency;
  localparam int unsigned RoundStage = ShiftStage + ShiftLatency;
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
  localparam int unsigned ShiftMax = SigBits + 1;
  localparam int unsigned ShiftBits = $clog2(ShiftMax + 1);
  localparam int unsigned CountBits = $clog2(SigBits);

  if (ExpBits < 3 || ExpBits > 8) begin : gen_check_exp_bits
    $error("ti_fp_mul: ExpBits must be 3 to 8.");
  end
  if (FracBits < 2 || FracBits > 23) begin : gen_check_frac_bits
    $error("ti_fp_mul: FracBits must be 2 to 23.");
  end
  if (Latency != Stages) begin : gen_check_stages
    $error("ti_fp_mul: Stages must be 3 to 5.");
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
  logic [SumExpBits-1:0] unpack_exp_q;  // of the product's top bit, two's complement
  side_t unpack_side_q;

  logic [SigBits+LowBits-1:0] halves_low_q;
  logic [SigBits+HighBits-1:0] halves_high_q;
  logic [CountBits-1:0] halves_count_q;
  logic [SumExpBits-1:0] halves_exp_q;
  side_t halves_side_q;

  logic [ProdBits-1:0] product_q;
  logic [CountBits-1:0] product_count_q;
  logic [SumExpBits-1:0] product_exp_q;
  side_t product_side_q;

  logic [MagBits-1:0] shift_mag_q;
  logic shift_guard_q, shift_sticky_q;
  side_t shift_side_q;

  // The last stage first: registers are read before they are written, and a simulator keeps no copy.
  always_ff @(posedge clk_i) begin
    automatic logic [Latency-1:0] valid;
    automatic side_t side;
    automatic logic [ExpBits-1:0] exp_a, exp_b;
    automatic logic [FracBits-1:0] frac_a, frac_b;
    automatic logic max_a, max_b, zero_a, zero_b;
    automatic logic [SigBits-1:0] sig_a, sig_b, left;
    automatic logic [SigBits+LowBits-1:0] low;
    automatic logic [SigBits+HighBits-1:0] high;
    automatic logic [CountBits-1:0] count;
    automatic logic [SumExpBits-1:0] exponent;
    automatic logic [SumExpBits-1:0] distance;
    automatic logic [ShiftBits-1:0] shift;
    automatic logic [ProdBits-1:0] product;
    automatic logic [MagBits-1:0] mag;
    automatic logic zero, top, moves, up, over;

    valid = {valid_q[Latency-2:0], valid_i};
    if (valid != '0) begin
      for (int k = int'(Latency) - 1; k >= 0; k--) begin
        // Unpack: significands with their leading bit; exponent 0 has the scale of exponent 1.
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
          side.sign = a_i[Width-1] ^ b_i[Width-1];
          side.to_inf = max_a || max_b;
          side.to_nan = (max_a && frac_a != '0) || (max_b && frac_b != '0)
              || (max_a && zero_b) || (max_b && zero_a);
          side.to_max = 1'b0;
          side.to_zero = Flush && (zero_a || zero_b);
          exponent = SumExpBits'(exp_a) + SumExpBits'(exp_b) + SumExpBits'(!Flush && exp_a == '0)
              + SumExpBits'(!Flush && exp_b == '0) - SumExpBits'(Bias - 1);
          unpack_a_q <= sig_a;
          unpack_b_q <= sig_b;
          unpack_exp_q <= exponent;
          unpack_side_q <= side;
        end

        // Halves of the product.  Count: leading zeros of the one significand that may have some when
        // the product moves left.  A one at the place that would become exponent 1 ends the count.
        if (k == int'(HalvesStage) && valid[k]) begin
          if (UnpackLatency != 0) begin
            sig_a = unpack_a_q;
            sig_b = unpack_b_q;
            side = unpack_side_q;
            exponent = unpack_exp_q;
          end
          low   = (SigBits + LowBits)'(sig_a) * (SigBits + LowBits)'(sig_b[LowBits-1:0]);
          high  = (SigBits + HighBits)'(sig_a) * (SigBits + HighBits)'(sig_b[SigBits-1:LowBits]);
          count = '0;
          if (!Flush && !(sig_a[SigBits-1] && sig_b[SigBits-1])) begin
            distance = exponent - SumExpBits'(1);
            left = {1'b1, {(SigBits - 1) {1'b0}}} >> CountBits'(distance);
            left = left & {SigBits{32'(distance) < SigBits}};
            left = left | (sig_a[SigBits-1] ? sig_b : sig_a);
            for (int i = int'(CountBits) - 1; i >= 0; i--) begin
              zero  = (left >> (SigBits - (1 << i))) == '0;
              count = count | (CountBits'(zero) << i);
              left  = left << (CountBits'(zero) << i);
            end
          end
          halves_low_q   <= low;
          halves_high_q  <= high;
          halves_count_q <= count;
          halves_exp_q   <= exponent;
          halves_side_q  <= side;
        end

        // Product: in one piece unless its halves stand in registers.
        if (k == int'(ProductStage) && valid[k]) begin
          if (HalvesLatency != 0) begin
            product_q <= ProdBits'(halves_low_q) + {halves_high_q, {LowBits{1'b0}}};
            product_count_q <= halves_count_q;
            product_exp_q <= halves_exp_q;
            product_side_q <= halves_side_q;
          end else begin
            product_q <= ProdBits'(sig_a) * ProdBits'(sig_b);
            product_count_q <= count;
            product_exp_q <= exponent;
            product_side_q <= side;
          end
        end

        // Shift: left by the count and once more where the top bit is still 0 and the exponent allows;
        // or right to exponent 1, what leaves being kept in the lowest bit.
        if (k == int'(ShiftStage) && valid[k]) begin
          side = product_side_q;
          exponent = product_exp_q;
          if (Flush) begin
            top = product_q[ProdBits-1];
            product = product_q << !top;
            exponent = exponent - SumExpBits'(!top);
            side.to_zero = side.to_zero || exponent[SumExpBits-1];
          end else if (!exponent[SumExpBits-1] && exponent != '0) begin
            product = product_q << product_count_q;
            exponent = exponent - SumExpBits'(product_count_q);
            top = product[ProdBits-1];
            moves = !top && exponent != SumExpBits'(1);
            product = product << moves;
            exponent = (top || product[ProdBits-1]) ? exponent - SumExpBits'(moves) : '0;
          end else begin
            distance = SumExpBits'(1) - exponent;
            shift = 32'(distance) > ShiftMax ? ShiftBits'(ShiftMax) : ShiftBits'(distance);
            zero = (product_q[ShiftMax-1:0] & ~({ShiftMax{1'b1}} << shift)) == '0;
            product = (product_q >> shift) | ProdBits'(!zero);
            exponent = '0;
          end
          shift_mag_q <= {exponent[ExpBits-1:0], product[ProdBits-2-:FracBits]};
          shift_guard_q <= product[ProdBits-2-FracBits];
          shift_sticky_q <= |product[ProdBits-3-FracBits:0];
          over = 32'(exponent) >= ExpMax && !exponent[SumExpBits-1];
          side.to_inf = side.to_inf || (!TowardZero && over);
          side.to_max = TowardZero && over;
          shift_side_q <= side;
        end

        // Round: a carry out of the fraction is the right exponent, up to infinity.
        if (k == int'(RoundStage) && valid[k]) begin
          up  = !TowardZero && shift_guard_q && (shift_sticky_q || shift_mag_q[0]);
          mag = shift_mag_q + MagBits'(up);
          if (shift_side_q.to_nan) begin
            result_o <= {1'b0, {ExpBits{1'b1}}, 1'b1, {(FracBits - 1) {1'b0}}};
          end else if (shift_side_q.to_inf) begin
            result_o <= {shift_side_q.sign, {ExpBits{1'b1}}, {FracBits{1'b0}}};
          end else if (TowardZero && shift_side_q.to_max) begin
            result_o <= {shift_side_q.sign, {(ExpBits - 1) {1'b1}}, 1'b0, {FracBits{1'b1}}};
          end else if (Flush && (shift_side_q.to_zero || mag[FracBits+:ExpBits] == '0)) begin
            result_o <= {shift_side_q.sign, {MagBits{1'b0}}};
          end else begin
            result_o <= {shift_side_q.sign, mag};
          end
        end
      end
    end
  end

  assign valid_o = valid_q[Latency-1];

endmodule : ti_fp_mul
