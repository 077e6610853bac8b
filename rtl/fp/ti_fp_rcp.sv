// SPDX-License-Identifier: Apache-2.0

`include "ti_reset.svh"

/// Floating-point 1 / a: correctly rounded by division, or by Newton steps from a table of seeds.
///
/// Latency `ti_fp_pkg::rcp_latency` of its parameters, one result a cycle, never stalls.  All paths
/// start and end in registers except the input.  A stage works only for a valid operand.  With 3 end
/// stages the leading zeros of the operand are counted in a stage of their own, which leaves time for
/// what the caller has in front; with 4 the quotient is shifted in one stage and rounded in the next;
/// with 5 the operand is shifted in two.
///
/// By division (`TableBits` 0) the error is at most half a unit in the last place in every format:
/// restoring long division, one digit of `BitsPerStage` bits by comparing with all its multiples of
/// the divisor at once, remainder as sticky bit, one rounding to nearest even.  By Newton steps
/// (`ti_fp_newton`) it is at most `ti_fp_pkg::rcp_half_ulps` halves of one; the inverse of a power of
/// two is exact.
///
/// IEEE 754: subnormals kept on both sides; 1/0 is infinity and 1/infinity is zero, with the
/// operand's sign; a subnormal operand whose inverse is out of range gives infinity; 1/NaN is the one
/// quiet NaN (sign 0, fraction 10...0).
/// With `TowardZero` the quotient is cut off, and an inverse out of range gives the largest number.
/// With `Flush` a subnormal operand is zero of its sign, and a result is rounded as if exponents had
/// no end, then zero of its sign where its exponent is below 1: no zeros are counted and nothing is
/// shifted, in stages that are there all the same.
module ti_fp_rcp #(
  /// Exponent bits, 3 to 8.
  parameter int unsigned ExpBits = 8,
  /// Stored fraction bits, 2 to 23.
  parameter int unsigned FracBits = 23,
  /// Quotient bits found in one stage, 1 to 3.
  parameter int unsigned BitsPerStage = ti_fp_pkg::RcpBitsPerStage,
  /// Stages in front of and behind the quotient, 2 to 5.
  parameter int unsigned EndStages = ti_fp_pkg::RcpEndStages,
  /// Bits of the index into the seeds of `ti_fp_newton`, at most `FracBits`; 0: division.
  parameter int unsigned TableBits = ti_fp_pkg::RcpTableBits,
  /// Newton steps from a seed, 0 to 2.
  parameter int unsigned NewtonSteps = ti_fp_pkg::RcpNewtonSteps,
  /// Stages of each of the two products of a step, 1 or 2.
  parameter int unsigned ProductStages = ti_fp_pkg::RcpProductStages,
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

  output logic             valid_o,
  output logic [Width-1:0] result_o
);

  localparam int unsigned SigBits = FracBits + 1;
  // With the significand m in [1, 2), 1/m has its top bit at weight 1 or 1/2: below the integer bit
  // come FracBits + 1 significand bits and the guard bit, rounded up to whole stages.  A step of
  // latency 0 is done in the stage of the next one.
  localparam int unsigned CountLatency = (EndStages >= 3) ? 1 : 0;
  localparam int unsigned ScaleLatency = (EndStages >= 5) ? 1 : 0;
  localparam int unsigned ShiftLatency = 1;
  localparam int unsigned DigitLatency = (FracBits + 1 + BitsPerStage) / BitsPerStage;
  localparam int unsigned NewtonLatency = 1 + 2 * NewtonSteps * ProductStages;
  localparam int unsigned MiddleLatency = (TableBits == 0) ? DigitLatency : NewtonLatency;
  localparam int unsigned PlaceLatency = (EndStages >= 4) ? 1 : 0;
  localparam int unsigned RoundLatency = 1;

  // The stage of each step; that of counting is 0.
  localparam int unsigned ScaleStage = CountLatency;
  localparam int unsigned ShiftStage = ScaleStage + ScaleLatency;
  localparam int unsigned MiddleStage = ShiftStage + ShiftLatency;
  localparam int unsigned PlaceStage = MiddleStage + MiddleLatency;
  localparam int unsigned RoundStage = PlaceStage + PlaceLatency;
  localparam int unsigned Latency = RoundStage + RoundLatency;
  // The valid bit in front of a stage other than 0.
  localparam int unsigned ScaleEnable = (ScaleStage > 0) ? ScaleStage - 1 : 0;
  localparam int unsigned ShiftEnable = (ShiftStage > 0) ? ShiftStage - 1 : 0;

  localparam int unsigned MagBits = ExpBits + FracBits;
  // Below the integer bit.
  localparam int unsigned DigitBits = DigitLatency * BitsPerStage;
  localparam int unsigned QuotBits = 1 + ((TableBits == 0) ? DigitBits : FracBits + 3);
  localparam int unsigned Radix = 1 << BitsPerStage;
  localparam int unsigned TrialBits = SigBits + BitsPerStage + 1;
  // Leading zeros are counted in groups of four places.
  localparam int unsigned NumGroups = (SigBits + 3) / 4;
  localparam int unsigned GroupBits = (NumGroups > 1) ? $clog2(NumGroups) : 1;
  // Enough for the signed exponent of 1/a, subnormal operands included.
  localparam int unsigned WideExpBits = 10;
  localparam int signed Bias = (1 << (ExpBits - 1)) - 1;
  localparam int signed ExpMax = (1 << ExpBits) - 1;

  if (ExpBits < 3 || ExpBits > 8) begin : gen_check_exp_bits
    $error("ti_fp_rcp: ExpBits must be 3 to 8.");
  end
  if (FracBits < 2 || FracBits > 23) begin : gen_check_frac_bits
    $error("ti_fp_rcp: FracBits must be 2 to 23.");
  end
  if (BitsPerStage < 1 || BitsPerStage > 3) begin : gen_check_bits_per_stage
    $error("ti_fp_rcp: BitsPerStage must be 1 to 3.");
  end
  if (EndStages < 2 || EndStages > 5) begin : gen_check_end_stages
    $error("ti_fp_rcp: EndStages must be 2 to 5.");
  end
  if (Latency != ti_fp_pkg::rcp_latency(
          FracBits, BitsPerStage, EndStages, TableBits, NewtonSteps, ProductStages
      )) begin : gen_check_sum
    $error("ti_fp_rcp: Latency is not that of ti_fp_pkg.");
  end

  typedef struct packed {
    logic sign;
    logic to_nan;
    logic to_inf;  // the operand is zero
    logic to_zero;  // the operand is infinite, or the result flushed
    logic to_max;  // overflow toward zero
    logic signed [WideExpBits-1:0] exponent;  // of the result
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
  logic [SigBits-1:0] count_sig_q;
  logic [GroupBits-1:0] count_group_q;
  logic count_one_q;
  side_t count_side_q;

  logic [SigBits-1:0] scale_sig_q;
  logic scale_one_q;
  side_t scale_side_q;

  logic [SigBits-1:0] shift_sig_q;
  logic shift_one_q;

  // In front of middle stage i; the last one is behind them.
  side_t side_q[MiddleLatency+1];

  // What the middle stages find: the inverse with its integer bit, and whether there is more of it.
  logic [QuotBits-1:0] quotient;
  logic inexact;

  logic [MagBits-1:0] place_mag_q;
  logic place_guard_q, place_sticky_q;
  side_t place_side_q;

  // In front of the middle; the last stage first, so that registers are read before they are written.
  always_ff @(posedge clk_i) begin
    automatic side_t side;
    automatic logic [ExpBits-1:0] exp_a;
    automatic logic [FracBits-1:0] frac_a;
    automatic logic [SigBits-1:0] sig;
    automatic logic [4*NumGroups-1:0] groups;
    automatic logic [GroupBits-1:0] group;
    automatic logic [2:0] first;
    automatic logic [1:0] count;
    automatic logic one;

    for (int k = int'(MiddleStage) - 1; k >= 0; k--) begin
      // Count: the first group of places with a one.  Exponent 0 has the scale of exponent 1.  The
      // integer bit of the quotient is 1 only for a power of two.
      if (k == 0 && valid_i) begin
        exp_a  = a_i[FracBits+:ExpBits];
        frac_a = a_i[FracBits-1:0];
        sig    = {Flush || exp_a != '0, frac_a};
        one    = (sig & (sig - SigBits'(1))) == '0;
        groups = (4 * NumGroups)'(sig) << (4 * NumGroups - SigBits);
        group  = '0;
        if (!Flush) begin
          group = GroupBits'(NumGroups - 1);
          for (int i = int'(NumGroups) - 2; i >= 0; i--) begin
            if (groups[4*(int'(NumGroups)-1-i)+:4] != '0) group = GroupBits'(i);
          end
        end
        side = '{
            sign: a_i[Width-1],
            to_nan: (&exp_a) && frac_a != '0,
            to_inf: exp_a == '0 && (Flush || frac_a == '0),
            to_zero: (&exp_a) && frac_a == '0,
            to_max: 1'b0,
            exponent: WideExpBits'(2 * Bias - 1) - WideExpBits'(exp_a | ExpBits'(exp_a == '0))
        };
        count_sig_q   <= sig;
        count_group_q <= group;
        count_one_q   <= one;
        count_side_q  <= side;
      end

      // Scale: the group moves to the front.
      if (k == int'(ScaleStage) && ((ScaleStage == 0) ? valid_i : valid_q[ScaleEnable])) begin
        if (CountLatency != 0) begin
          sig   = count_sig_q;
          group = count_group_q;
          one   = count_one_q;
          side  = count_side_q;
        end
        sig = sig << {group, 2'b00};
        side.exponent = side.exponent + WideExpBits'({group, 2'b00});
        scale_sig_q  <= sig;
        scale_one_q  <= one;
        scale_side_q <= side;
      end

      // Shift by the zeros in front of the group's first one: the significand m has none then (anything
      // for zero).
      if (k == int'(ShiftStage) && ((ShiftStage == 0) ? valid_i : valid_q[ShiftEnable])) begin
        if (ScaleLatency != 0) begin
          sig  = scale_sig_q;
          one  = scale_one_q;
          side = scale_side_q;
        end
        groups = (4 * NumGroups)'(sig) << (4 * NumGroups - SigBits);
        first = groups[4*NumGroups-1-:3];
        count = {!first[2] && !first[1], !first[2] && (first[1] || !first[0])};
        sig = sig << count;
        side.exponent = side.exponent + WideExpBits'(count) + WideExpBits'(one);
        shift_sig_q <= sig;
        shift_one_q <= one;
        side_q[0]   <= side;
      end
    end
  end

  for (genvar i = 0; i < MiddleLatency; i++) begin : gen_side
    always_ff @(posedge clk_i) if (valid_q[MiddleStage+i-1]) side_q[i+1] <= side_q[i];
  end

  if (TableBits == 0) begin : gen_division
    // Behind digit stage i; the odd multiples of the divisor go along.
    logic [  SigBits-1:0] remainder_q[DigitLatency];
    logic [ QuotBits-1:0] quotient_q [DigitLatency];
    logic [TrialBits-1:0] multiples_q[DigitLatency] [Radix];

    // Always 0 <= remainder < divisor.
    for (genvar i = 0; i < DigitLatency; i++) begin : gen_digit
      localparam int unsigned Before = (i == 0) ? 0 : i - 1;
      always_ff @(posedge clk_i) begin
        automatic logic [BitsPerStage-1:0] digit;
        automatic logic [SigBits-1:0] remainder, left;
        automatic logic [QuotBits-BitsPerStage-1:0] upper;
        automatic logic [TrialBits-1:0] trial;
        automatic logic [TrialBits-1:0] multiples[Radix];

        if (valid_q[MiddleStage+i-1]) begin
          remainder = (i == 0) ? {!shift_one_q, {FracBits{1'b0}}} : remainder_q[Before];
          upper = (i == 0) ? (QuotBits - BitsPerStage)'(shift_one_q)
              : quotient_q[Before][QuotBits-BitsPerStage-1:0];
          digit = '0;
          left = remainder << BitsPerStage;
          multiples[0] = '0;
          for (int unsigned k = 1; k < Radix; k++) begin
            if (k % 2 == 0) multiples[k] = multiples[k/2] << 1;
            else if (i != 0) multiples[k] = multiples_q[Before][k];
            else if (k == 7)
              multiples[k] = (TrialBits'(shift_sig_q) << 3) - TrialBits'(shift_sig_q);
            else multiples[k] = multiples[k-1] + TrialBits'(shift_sig_q);
            if (k % 2 != 0) multiples_q[i][k] <= multiples[k];
            trial = TrialBits'({remainder, {BitsPerStage{1'b0}}}) - multiples[k];
            if (!trial[TrialBits-1]) begin
              digit = BitsPerStage'(k);
              left  = trial[SigBits-1:0];
            end
          end
          quotient_q[i]  <= {upper, digit};
          remainder_q[i] <= left;
        end
      end
    end

    assign quotient = quotient_q[DigitLatency-1];
    assign inexact  = remainder_q[DigitLatency-1] != '0;
  end else begin : gen_newton
    ti_fp_newton #(
      .FracBits     (FracBits),
      .TableBits    (TableBits),
      .Steps        (NewtonSteps),
      .ProductStages(ProductStages),
      .TowardZero   (TowardZero)
    ) u_newton (
      .clk_i,
      .valid_i  (valid_q[MiddleStage-1+:MiddleLatency]),
      .sig_i    (shift_sig_q),
      .exact_i  (shift_one_q),
      .inverse_o(quotient)
    );
    assign inexact = 1'b0;
  end

  // Behind the middle.
  always_ff @(posedge clk_i) begin
    automatic side_t side;
    automatic logic signed [WideExpBits-1:0] exponent;
    automatic logic [QuotBits+1:0] placed;
    automatic logic [MagBits-1:0] mag;
    automatic logic guard, sticky, over;

    for (int k = int'(Latency) - 1; k >= int'(PlaceStage); k--) begin
      // Place: the exponent is at least -1, so a subnormal result is one or two places away.  One
      // that may be flushed is rounded where it is.
      if (k == int'(PlaceStage) && valid_q[PlaceStage-1]) begin
        side = side_q[MiddleLatency];
        exponent = side.exponent;
        placed = {quotient[QuotBits-1] ? quotient : quotient << 1, 2'b00};
        if (!Flush && exponent == 0) placed = placed >> 1;
        if (!Flush && exponent < 0) placed = placed >> 2;
        over = !Flush && 32'(exponent) >= ExpMax;
        side.to_inf = side.to_inf || (!TowardZero && over);
        side.to_max = TowardZero && over;
        side.to_zero = side.to_zero || (Flush && exponent < 0);
        mag = {
          placed[QuotBits+1] ? exponent[ExpBits-1:0] : ExpBits'(0), placed[QuotBits-:FracBits]
        };
        guard = placed[QuotBits-FracBits];
        sticky = (|placed[QuotBits-FracBits-1:0]) || inexact;
        place_mag_q <= mag;
        place_guard_q <= guard;
        place_sticky_q <= sticky;
        place_side_q <= side;
      end

      // Round and pack.
      if (k == int'(RoundStage) && valid_q[RoundStage-1]) begin
        if (PlaceLatency != 0) begin
          mag = place_mag_q;
          guard = place_guard_q;
          sticky = place_sticky_q;
          side = place_side_q;
        end
        mag = mag + MagBits'(!TowardZero && guard && (sticky || mag[0]));
        if (side.to_nan) begin
          result_o <= {1'b0, {ExpBits{1'b1}}, 1'b1, {(FracBits - 1) {1'b0}}};
        end else if (side.to_zero) begin
          result_o <= {side.sign, {MagBits{1'b0}}};
        end else if (side.to_inf) begin
          result_o <= {side.sign, {ExpBits{1'b1}}, {FracBits{1'b0}}};
        end else if (TowardZero && side.to_max) begin
          result_o <= {side.sign, {(ExpBits - 1) {1'b1}}, 1'b0, {FracBits{1'b1}}};
        end else if (Flush && mag[FracBits+:ExpBits] == '0) begin
          result_o <= {side.sign, {MagBits{1'b0}}};
        end else begin
          result_o <= {side.sign, mag};
        end
      end
    end
  end

  assign valid_o = valid_q[Latency-1];

endmodule : ti_fp_rcp
