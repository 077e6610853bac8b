// SPDX-License-Identifier: Apache-2.0

`include "ti_reset.svh"

/// Floating-point a + b, or a - b where `negate_b_i` is 1.
///
/// Latency `Stages`, one result a cycle, never stalls: `valid_o` is `valid_i` that many cycles
/// later.  All paths start and end in registers except the inputs.  A stage works only for a valid
/// operand pair.  With 5 stages the inputs are put in order in a stage of their own, which leaves
/// time for what the caller has in front; with 6 aligning is parted from adding, with 7 counting
/// from scaling, with 8 scaling from shifting, with 9 comparing from putting in order, with 10 aligning
/// takes two.
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
  /// Register stages, 4 to 10.
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
  localparam int unsigned CompareLatency = (Stages >= 9) ? 1 : 0;
  localparam int unsigned OrderLatency = (Stages >= 5) ? 1 : 0;
  localparam int unsigned DistanceLatency = 1;
  localparam int unsigned CoarseLatency = (Stages >= 10) ? 1 : 0;
  localparam int unsigned AlignLatency = (Stages >= 6) ? 1 : 0;
  localparam int unsigned SumLatency = 1;
  localparam int unsigned CountLatency = (Stages >= 7) ? 1 : 0;
  localparam int unsigned ScaleLatency = (Stages >= 8) ? 1 : 0;
  localparam int unsigned ShiftLatency = 1;
  localparam int unsigned RoundLatency = 1;

  // The stage of each step; that of comparing is 0.
  localparam int unsigned OrderStage = CompareLatency;
  localparam int unsigned DistanceStage = OrderStage + OrderLatency;
  localparam int unsigned CoarseStage = DistanceStage + DistanceLatency;
  localparam int unsigned AlignStage = CoarseStage + CoarseLatency;
  localparam int unsigned SumStage = AlignStage + AlignLatency;
  localparam int unsigned CountStage = SumStage + SumLatency;
  localparam int unsigned ScaleStage = CountStage + CountLatency;
  localparam int unsigned ShiftStage = ScaleStage + ScaleLatency;
  localparam int unsigned RoundStage = ShiftStage + ShiftLatency;
  localparam int unsigned Latency = RoundStage + RoundLatency;

  localparam int unsigned MagBits = ExpBits + FracBits;
  // Significand with its leading bit, then guard, round and sticky; the sum has a carry on top.
  localparam int unsigned SigBits = FracBits + 1;
  localparam int unsigned AlignedBits = SigBits + 3;
  localparam int unsigned SumBits = AlignedBits + 1;
  // A shift by SigBits + 2 leaves nothing but the sticky bit.
  localparam int unsigned DistanceBits = $clog2(SigBits + 3);
  // Leading zeros are counted in groups of four places, from the carry bit on.
  localparam int unsigned NumGroups = (SumBits + 3) / 4;
  localparam int unsigned GroupBits = $clog2(NumGroups);
  // Of the exponent before it is known to be at least 1, two's complement.
  localparam int unsigned WideExpBits = ExpBits + 2;

  if (ExpBits < 3 || ExpBits > 8) begin : gen_check_exp_bits
    $error("ti_fp_add: ExpBits must be 3 to 8.");
  end
  if (FracBits < 2 || FracBits > 23) begin : gen_check_frac_bits
    $error("ti_fp_add: FracBits must be 2 to 23.");
  end
  if (Latency != Stages) begin : gen_check_stages
    $error("ti_fp_add: Stages must be 4 to 10.");
  end

  typedef struct packed {
    logic sign;
    logic to_nan;
    logic to_inf;
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
  logic [MagBits-1:0] compare_a_q;
  logic [MagBits-1:0] compare_b_q;
  logic compare_sign_a_q, compare_sign_b_q, compare_zero_a_q, compare_zero_b_q, compare_swap_q;

  logic [MagBits-1:0] order_major_q;  // the larger magnitude
  logic [MagBits-1:0] order_minor_q;
  logic order_one_q;
  logic order_subtract_q;
  side_t order_side_q;

  logic [MagBits-1:0] distance_major_q;
  logic [SigBits-1:0] distance_minor_q;
  logic [DistanceBits-1:0] distance_q;
  logic distance_subtract_q;
  side_t distance_side_q;

  logic [MagBits-1:0] coarse_major_q;
  logic [AlignedBits-1:0] coarse_minor_q;
  logic [1:0] coarse_distance_q;
  logic coarse_subtract_q;
  side_t coarse_side_q;

  logic [MagBits-1:0] align_major_q;
  logic [AlignedBits-1:0] align_minor_q;
  logic align_subtract_q;
  side_t align_side_q;

  logic [SumBits-1:0] sum_q;
  logic [SumBits-1:0] sum_limit_q;
  logic [ExpBits-1:0] sum_exp_q;
  side_t sum_side_q;

  logic [GroupBits-1:0] count_group_q;
  logic [SumBits-1:0] count_sum_q;
  logic [SumBits-1:0] count_limit_q;
  logic [ExpBits-1:0] count_exp_q;
  side_t count_side_q;

  logic [2:0] scale_top_q;
  logic [SumBits-1:0] scale_sum_q;
  logic [WideExpBits-1:0] scale_exp_q;
  side_t scale_side_q;

  logic [MagBits-1:0] shift_mag_q;
  logic shift_guard_q, shift_sticky_q;
  side_t shift_side_q;

  // The last stage first: registers are read before they are written, and a simulator keeps no copy.
  always_ff @(posedge clk_i) begin
    automatic logic [Latency-1:0] valid;
    automatic side_t side;
    automatic logic [MagBits-1:0] mag_a, mag_b, major, minor;
    automatic logic sign_a, sign_b, zero_a, zero_b, one, subtract, swap;
    automatic logic [ExpBits-1:0] exp_major, exp_minor, exponent, wide_distance;
    automatic logic [DistanceBits-1:0] distance;
    automatic logic [AlignedBits-1:0] aligned, lost;
    automatic logic [SumBits-1:0] base, addend, sum, left, limit;
    automatic logic [4*NumGroups-1:0] groups;
    automatic logic [GroupBits-1:0] group;
    automatic logic [2:0] top;
    automatic logic [1:0] count;
    automatic logic [WideExpBits-1:0] wide_exp;
    automatic logic normal, up;

    valid = {valid_q[Latency-2:0], valid_i};
    if (valid != '0) begin
      for (int k = int'(Latency) - 1; k >= 0; k--) begin
        // Compare the magnitudes.
        if (k == 0 && valid[k]) begin
          mag_a  = a_i[MagBits-1:0] & {MagBits{!Flush || a_i[FracBits+:ExpBits] != '0}};
          mag_b  = b_i[MagBits-1:0] & {MagBits{!Flush || b_i[FracBits+:ExpBits] != '0}};
          sign_a = a_i[Width-1];
          sign_b = b_i[Width-1] ^ negate_b_i;
          zero_a = a_i[FracBits+:ExpBits] == '0;
          zero_b = b_i[FracBits+:ExpBits] == '0;
          swap   = mag_a < mag_b;
          compare_a_q <= mag_a;
          compare_b_q <= mag_b;
          compare_sign_a_q <= sign_a;
          compare_sign_b_q <= sign_b;
          compare_zero_a_q <= zero_a;
          compare_zero_b_q <= zero_b;
          compare_swap_q <= swap;
        end

        // Order: larger magnitude first.  The sign is that of a difference other than 0.  Exponents 0
        // and 1 have the same scale, so an exponent of 0 beside another counts as 1.
        if (k == int'(OrderStage) && valid[k]) begin
          if (CompareLatency != 0) begin
            mag_a  = compare_a_q;
            mag_b  = compare_b_q;
            sign_a = compare_sign_a_q;
            sign_b = compare_sign_b_q;
            zero_a = compare_zero_a_q;
            zero_b = compare_zero_b_q;
            swap   = compare_swap_q;
          end
          subtract = sign_a ^ sign_b;
          major = swap ? mag_b : mag_a;
          minor = swap ? mag_a : mag_b;
          one = !Flush && (swap ? zero_a && !zero_b : zero_b && !zero_a);
          side.sign = swap ? sign_b : sign_a;
          side.to_nan = 1'b0;
          side.to_inf = 1'b0;
          order_major_q <= major;
          order_minor_q <= minor;
          order_one_q <= one;
          order_subtract_q <= subtract;
          order_side_q <= side;
        end

        // Distance: places by which the smaller significand moves right, all ones where that is more.
        if (k == int'(DistanceStage) && valid[k]) begin
          if (OrderLatency != 0) begin
            major = order_major_q;
            minor = order_minor_q;
            one = order_one_q;
            subtract = order_subtract_q;
            side = order_side_q;
          end
          exp_major = major[FracBits+:ExpBits];
          exp_minor = minor[FracBits+:ExpBits];
          side.sign = side.sign && !(subtract && major == minor);
          side.to_nan = (&exp_major) && ((|major[FracBits-1:0]) || (subtract && (&exp_minor)));
          wide_distance = exp_major - exp_minor - ExpBits'(one);
          distance_q <= DistanceBits'(wide_distance)
              | {DistanceBits{(wide_distance >> DistanceBits) != '0}};
          distance_major_q <= major;
          distance_minor_q <= {exp_minor != '0, minor[FracBits-1:0]};
          distance_subtract_q <= subtract;
          distance_side_q <= side;
        end

        // Align by a multiple of 4 places: bits that leave on the right stay as the sticky bit.
        if (k == int'(CoarseStage) && valid[k]) begin
          distance = distance_q;
          major = distance_major_q;
          subtract = distance_subtract_q;
          side = distance_side_q;
          aligned = {distance_minor_q, 3'b000};
          if (CoarseLatency != 0) begin
            distance[1:0] = 2'b00;
            lost = aligned & ~({AlignedBits{1'b1}} << distance);
            aligned = (aligned >> distance) | AlignedBits'(lost != '0);
            distance = DistanceBits'(distance_q[1:0]);
          end
          coarse_major_q <= major;
          coarse_minor_q <= aligned;
          coarse_distance_q <= distance[1:0];
          coarse_subtract_q <= subtract;
          coarse_side_q <= side;
        end

        // Align by the rest.
        if (k == int'(AlignStage) && valid[k]) begin
          if (CoarseLatency != 0) begin
            distance = DistanceBits'(coarse_distance_q);
            major = coarse_major_q;
            aligned = coarse_minor_q;
            subtract = coarse_subtract_q;
            side = coarse_side_q;
          end
          lost = aligned & ~({AlignedBits{1'b1}} << distance);
          aligned = (aligned >> distance) | AlignedBits'(lost != '0);
          align_major_q <= major;
          align_minor_q <= aligned;
          align_subtract_q <= subtract;
          align_side_q <= side;
        end

        // Sum of the significands, three more places on the right, a carry on the left.  Beside it the
        // place that would become exponent 1, beyond which nothing moves where subnormals are kept.
        if (k == int'(SumStage) && valid[k]) begin
          if (AlignLatency != 0) begin
            major = align_major_q;
            aligned = align_minor_q;
            subtract = align_subtract_q;
            side = align_side_q;
          end
          base = {1'b0, major[FracBits+:ExpBits] != '0, major[FracBits-1:0], 3'b000};
          addend = {1'b0, aligned};
          exponent = major[FracBits+:ExpBits] | ExpBits'(!Flush && major[FracBits+:ExpBits] == '0);
          limit = {1'b1, {(SumBits - 1) {1'b0}}} >> exponent;
          sum_q <= subtract ? base - addend : base + addend;
          sum_limit_q <= limit & {SumBits{!Flush}};
          sum_exp_q <= exponent;
          sum_side_q <= side;
        end

        // Count: the first group of places with a one, of the sum or the limit; the last one for none.
        if (k == int'(CountStage) && valid[k]) begin
          sum = sum_q;
          limit = sum_limit_q;
          exponent = sum_exp_q;
          side = sum_side_q;
          groups = (4 * NumGroups)'(sum | limit) << (4 * NumGroups - SumBits);
          group = GroupBits'(NumGroups - 1);
          for (int i = int'(NumGroups) - 2; i >= 0; i--) begin
            if (groups[4*(int'(NumGroups)-1-i)+:4] != '0) group = GroupBits'(i);
          end
          count_group_q <= group;
          count_sum_q   <= sum;
          count_limit_q <= limit;
          count_exp_q   <= exponent;
          count_side_q  <= side;
        end

        // Scale: the group moves to the front.  The carry bit has the exponent above that of the larger
        // operand.
        if (k == int'(ScaleStage) && valid[k]) begin
          if (CountLatency != 0) begin
            group = count_group_q;
            sum = count_sum_q;
            limit = count_limit_q;
            exponent = count_exp_q;
            side = count_side_q;
          end
          side.to_inf = &exponent;
          wide_exp = WideExpBits'(exponent) + WideExpBits'(1) - WideExpBits'({group, 2'b00});
          limit = (sum | limit) << {group, 2'b00};
          sum = sum << {group, 2'b00};
          top = limit[SumBits-1-:3];
          scale_top_q  <= top;
          scale_sum_q  <= sum;
          scale_exp_q  <= wide_exp;
          scale_side_q <= side;
        end

        // Shift: by the zeros in front of the group's first one.
        if (k == int'(ShiftStage) && valid[k]) begin
          if (ScaleLatency != 0) begin
            top = scale_top_q;
            sum = scale_sum_q;
            wide_exp = scale_exp_q;
            side = scale_side_q;
          end
          count = {!top[2] && !top[1], !top[2] && (top[1] || !top[0])};
          left = sum << count;
          wide_exp = wide_exp - WideExpBits'(count);
          normal = left[SumBits-1] && !(Flush && (wide_exp[WideExpBits-1] || wide_exp == '0));
          exponent = wide_exp[ExpBits-1:0];
          side.to_inf = side.to_inf || (!TowardZero && normal && (&exponent));
          shift_mag_q <= {
            exponent & {ExpBits{normal}}, left[SumBits-2-:FracBits] & {FracBits{!Flush || normal}}
          };
          shift_guard_q <= left[SumBits-2-FracBits];
          shift_sticky_q <= |left[SumBits-3-FracBits:0];
          shift_side_q <= side;
        end

        // Round: a carry out of the fraction is the right exponent, up to infinity.  Without it the
        // exponent of infinity is beyond the largest number.
        if (k == int'(RoundStage) && valid[k]) begin
          up = !TowardZero && shift_guard_q && (shift_sticky_q || shift_mag_q[0]);
          if (shift_side_q.to_nan) begin
            result_o <= {1'b0, {ExpBits{1'b1}}, 1'b1, {(FracBits - 1) {1'b0}}};
          end else if (shift_side_q.to_inf) begin
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
