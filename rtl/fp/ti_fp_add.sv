// SPDX-License-Identifier: Apache-2.0

`include "ti_reset.svh"

/// Floating-point a + b, or a - b where `negate_b_i` is 1.
///
/// Latency `Stages`, one result a cycle, never stalls: `valid_o` is `valid_i` that many cycles
/// later.  All paths start and end in registers except the inputs.  A stage works only for a valid
/// operand pair.  With 5 stages the comparison of the inputs has a stage of its own, which leaves
/// time for what the caller has in front; with 6 aligning is parted from adding, with 7 counting
/// from shifting.
///
/// IEEE 754: one rounding to nearest even; subnormals kept on both sides; overflow gives infinity;
/// a NaN operand or infinity - infinity gives the one quiet NaN (sign 0, fraction 10...0);
/// x + -x is +0, -0 + -0 is -0.  Method: order by magnitude, align with guard, round and sticky
/// bits, add, count the leading zeros as far as the exponent allows, shift left by them, round.
/// With `TowardZero` nothing is added when rounding, and overflow gives the largest number.  With
/// `Flush` a subnormal operand is zero of its sign and so is a subnormal result, which is exact
/// before it is flushed: all leading zeros are counted, and more than the exponent make a zero.
module ti_fp_add #(
  /// Exponent bits, 3 to 8.
  parameter int unsigned ExpBits = 8,
  /// Stored fraction bits, 2 to 23.
  parameter int unsigned FracBits = 23,
  /// Register stages, 4 to 7.
  parameter int unsigned Stages = ti_fp_pkg::AddLatency,
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
  input logic             negate_b_i,

  output logic             valid_o,
  output logic [Width-1:0] result_o
);

  // A step of latency 0 is done in the stage of the next one.
  localparam int unsigned OrderLatency = (Stages >= 5) ? 1 : 0;
  localparam int unsigned DistanceLatency = 1;
  localparam int unsigned AlignLatency = (Stages >= 6) ? 1 : 0;
  localparam int unsigned SumLatency = 1;
  localparam int unsigned CountLatency = (Stages >= 7) ? 1 : 0;
  localparam int unsigned ShiftLatency = 1;
  localparam int unsigned RoundLatency = 1;

  // The stage of each step; that of ordering is 0.
  localparam int unsigned DistanceStage = OrderLatency;
  localparam int unsigned AlignStage = DistanceStage + DistanceLatency;
  localparam int unsigned SumStage = AlignStage + AlignLatency;
  localparam int unsigned CountStage = SumStage + SumLatency;
  localparam int unsigned ShiftStage = CountStage + CountLatency;
  localparam int unsigned RoundStage = ShiftStage + ShiftLatency;
  localparam int unsigned Latency = RoundStage + RoundLatency;

  localparam int unsigned MagBits = ExpBits + FracBits;
  // Significand with its leading bit, then guard, round and sticky; the sum has a carry on top.
  localparam int unsigned SigBits = FracBits + 1;
  localparam int unsigned AlignedBits = SigBits + 3;
  localparam int unsigned SumBits = AlignedBits + 1;
  // A shift by SigBits + 2 leaves nothing but the sticky bit.
  localparam int unsigned DistanceMax = SigBits + 2;
  localparam int unsigned DistanceBits = $clog2(DistanceMax + 1);
  localparam int unsigned CountBits = $clog2(SumBits);

  if (ExpBits < 3 || ExpBits > 8) begin : gen_check_exp_bits
    $error("ti_fp_add: ExpBits must be 3 to 8.");
  end
  if (FracBits < 2 || FracBits > 23) begin : gen_check_frac_bits
    $error("ti_fp_add: FracBits must be 2 to 23.");
  end
  if (Latency != Stages) begin : gen_check_stages
    $error("ti_fp_add: Stages must be 4 to 7.");
  end

  typedef struct packed {
    logic sign;
    logic to_nan;
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
  logic [MagBits-1:0] order_major_q;  // the larger magnitude
  logic [MagBits-1:0] order_minor_q;
  logic order_subtract_q;
  side_t order_side_q;

  logic [MagBits-1:0] distance_major_q;
  logic [SigBits-1:0] distance_minor_q;
  logic [DistanceBits-1:0] distance_q;
  logic distance_subtract_q;
  side_t distance_side_q;

  logic [MagBits-1:0] align_major_q;
  logic [AlignedBits-1:0] align_minor_q;
  logic align_subtract_q;
  side_t align_side_q;

  logic [SumBits-1:0] sum_q;
  logic [ExpBits-1:0] sum_exp_q;
  side_t sum_side_q;

  logic [CountBits-1:0] count_q;
  logic [SumBits-1:0] count_sum_q;
  logic [ExpBits-1:0] count_exp_q;
  side_t count_side_q;

  logic [MagBits-1:0] shift_mag_q;
  logic shift_guard_q, shift_sticky_q, shift_inf_q;
  side_t shift_side_q;

  // The last stage first: registers are read before they are written, and a simulator keeps no copy.
  always_ff @(posedge clk_i) begin
    automatic logic [Latency-1:0] valid;
    automatic side_t side;
    automatic logic [MagBits-1:0] mag_a, mag_b, major, minor;
    automatic logic sign_a, sign_b, subtract, swap;
    automatic logic [ExpBits-1:0] exp_major, exp_minor, exponent, wide_distance;
    automatic logic [SigBits-1:0] sig_minor;
    automatic logic [DistanceBits-1:0] distance;
    automatic logic [SigBits+DistanceMax-1:0] wide;
    automatic logic [AlignedBits-1:0] aligned;
    automatic logic [SumBits-1:0] base, addend, sum, left;
    automatic logic [CountBits-1:0] count;
    automatic logic zero, up, normal;

    valid = {valid_q[Latency-2:0], valid_i};
    if (valid != '0) begin
      for (int k = int'(Latency) - 1; k >= 0; k--) begin
        // Order: larger magnitude first.
        if (k == 0 && valid[k]) begin
          mag_a = a_i[MagBits-1:0] & {MagBits{!Flush || a_i[FracBits+:ExpBits] != '0}};
          mag_b = b_i[MagBits-1:0] & {MagBits{!Flush || b_i[FracBits+:ExpBits] != '0}};
          sign_a = a_i[Width-1];
          sign_b = b_i[Width-1] ^ negate_b_i;
          subtract = sign_a ^ sign_b;
          swap = mag_a < mag_b;
          major = swap ? mag_b : mag_a;
          minor = swap ? mag_a : mag_b;
          exp_major = major[FracBits+:ExpBits];
          exp_minor = minor[FracBits+:ExpBits];
          side.sign = (swap ? sign_b : sign_a) && !(subtract && mag_a == mag_b);
          side.to_nan = (&exp_major) && ((|major[FracBits-1:0]) || (subtract && (&exp_minor)));
          order_major_q <= major;
          order_minor_q <= minor;
          order_subtract_q <= subtract;
          order_side_q <= side;
        end

        // Distance: places by which the smaller significand moves right; exponents 0 and 1 have the
        // same scale.
        if (k == int'(DistanceStage) && valid[k]) begin
          if (OrderLatency != 0) begin
            major = order_major_q;
            minor = order_minor_q;
            subtract = order_subtract_q;
            side = order_side_q;
          end
          exp_major = major[FracBits+:ExpBits];
          exp_minor = minor[FracBits+:ExpBits];
          wide_distance = exp_major - exp_minor
              - ExpBits'(!Flush && exp_minor == '0 && exp_major != '0);
          distance_q <= 32'(wide_distance) > DistanceMax ? DistanceBits'(DistanceMax)
              : DistanceBits'(wide_distance);
          distance_major_q <= major;
          distance_minor_q <= {exp_minor != '0, minor[FracBits-1:0]};
          distance_subtract_q <= subtract;
          distance_side_q <= side;
        end

        // Align: bits that leave on the right stay as the sticky bit.
        if (k == int'(AlignStage) && valid[k]) begin
          sig_minor = distance_minor_q;
          distance = distance_q;
          major = distance_major_q;
          subtract = distance_subtract_q;
          side = distance_side_q;
          wide = {sig_minor, {DistanceMax{1'b0}}} >> distance;
          aligned = {wide[SigBits+DistanceMax-1:SigBits], |wide[SigBits-1:0]};
          align_major_q <= major;
          align_minor_q <= aligned;
          align_subtract_q <= subtract;
          align_side_q <= side;
        end

        // Sum of the significands, three more places on the right, a carry on the left.
        if (k == int'(SumStage) && valid[k]) begin
          if (AlignLatency != 0) begin
            major = align_major_q;
            aligned = align_minor_q;
            subtract = align_subtract_q;
            side = align_side_q;
          end
          base   = {1'b0, major[FracBits+:ExpBits] != '0, major[FracBits-1:0], 3'b000};
          addend = {1'b0, aligned};
          sum_q <= subtract ? base - addend : base + addend;
          sum_exp_q <= major[FracBits+:ExpBits];
          sum_side_q <= side;
        end

        // Count: leading zeros of the sum.  A one at the place that would become exponent 1 ends the
        // count there, where subnormals are kept.
        if (k == int'(CountStage) && valid[k]) begin
          sum = sum_q;
          exponent = sum_exp_q | ExpBits'(!Flush && sum_exp_q == '0);
          side = sum_side_q;
          left = {1'b1, {(SumBits - 1) {1'b0}}} >> CountBits'(exponent);
          left = sum | (left & {SumBits{!Flush && 32'(exponent) < SumBits}});
          count = '0;
          // Steps without a branch, which a simulator would guess wrong.
          for (int i = int'(CountBits) - 1; i >= 0; i--) begin
            zero  = (left >> (SumBits - (1 << i))) == '0;
            count = count | (CountBits'(zero) << i);
            left  = left << (CountBits'(zero) << i);
          end
          count_q <= count;
          count_sum_q <= sum;
          count_exp_q <= exponent;
          count_side_q <= side;
        end

        // Shift: the carry bit has the exponent above that of the larger operand.
        if (k == int'(ShiftStage) && valid[k]) begin
          if (CountLatency != 0) begin
            count = count_q;
            sum = count_sum_q;
            exponent = count_exp_q;
            side = count_side_q;
          end
          left = sum << count;
          normal = left[SumBits-1] && !(Flush && 32'(count) > 32'(exponent));
          exp_major = normal ? exponent + ExpBits'(1) - ExpBits'(count) : '0;
          shift_mag_q <= {exp_major, left[SumBits-2-:FracBits] & {FracBits{!Flush || normal}}};
          shift_guard_q <= left[SumBits-2-FracBits];
          shift_sticky_q <= |left[SumBits-3-FracBits:0];
          shift_inf_q <= (&exponent) || (!TowardZero && (&exp_major));
          shift_side_q <= side;
        end

        // Round: a carry out of the fraction is the right exponent, up to infinity.  Without it the
        // exponent of infinity is beyond the largest number.
        if (k == int'(RoundStage) && valid[k]) begin
          up = !TowardZero && shift_guard_q && (shift_sticky_q || shift_mag_q[0]);
          if (shift_side_q.to_nan) begin
            result_o <= {1'b0, {ExpBits{1'b1}}, 1'b1, {(FracBits - 1) {1'b0}}};
          end else if (shift_inf_q) begin
            result_o <= {shift_side_q.sign, {ExpBits{1'b1}}, {FracBits{1'b0}}};
          end else if (TowardZero && (&shift_mag_q[FracBits+:ExpBits])) begin
            result_o <= {shift_side_q.sign, {(ExpBits - 1) {1'b1}}, 1'b0, {FracBits{1'b1}}};
          end else begin
            result_o <= {shift_side_q.sign, shift_mag_q + MagBits'(up)};
          end
        end
      end
    end
  end

  assign valid_o = valid_q[Latency-1];

endmodule : ti_fp_add
