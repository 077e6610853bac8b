// SPDX-License-Identifier: Apache-2.0

/// Floating-point 1 / a, correctly rounded.
///
/// Latency `ti_fp_pkg::rcp_latency(FracBits, BitsPerStage)`, one result a cycle, never stalls.  All
/// paths start and end in registers except the input.  A stage works only for a valid operand.
///
/// Error at most half a unit in the last place in every format: restoring long division, one
/// quotient bit by each compare and subtract, remainder as sticky bit, one rounding to nearest
/// even.  IEEE 754: subnormals kept on both sides; 1/0 is infinity and 1/infinity is zero, with the
/// operand's sign; a subnormal operand whose inverse is out of range gives infinity; 1/NaN is the
/// one quiet NaN (sign 0, fraction 10...0).
module ti_fp_rcp #(
  /// Exponent bits, 3 to 8.
  parameter int unsigned ExpBits = 8,
  /// Stored fraction bits, 2 to 23.
  parameter int unsigned FracBits = 23,
  /// Quotient bits found in one stage, at least 1.
  parameter int unsigned BitsPerStage = ti_fp_pkg::RcpBitsPerStage,
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
  // come FracBits + 1 significand bits and the guard bit, rounded up to whole stages.
  localparam int unsigned UnpackLatency = 1;
  localparam int unsigned DigitLatency = (FracBits + 1 + BitsPerStage) / BitsPerStage;
  localparam int unsigned RoundLatency = 1;
  localparam int unsigned Latency = UnpackLatency + DigitLatency + RoundLatency;

  localparam int unsigned MagBits = ExpBits + FracBits;
  localparam int unsigned QuotBits = 1 + DigitLatency * BitsPerStage;
  localparam int unsigned NormSteps = $clog2(SigBits);
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
  if (BitsPerStage < 1) begin : gen_check_bits_per_stage
    $error("ti_fp_rcp: BitsPerStage must be at least 1.");
  end
  if (Latency != ti_fp_pkg::rcp_latency(FracBits, BitsPerStage)) begin : gen_check_latency
    $error("ti_fp_rcp: Latency is not that of ti_fp_pkg.");
  end

  typedef struct packed {
    logic sign;
    logic to_nan;
    logic to_inf;  // the operand is zero
    logic to_zero;  // the operand is infinite
    logic signed [WideExpBits-1:0] exponent;  // of the result when 1/m < 1
  } side_t;

  logic [Latency-1:0] valid_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_q <= '0;
    end else begin
      valid_q <= {valid_q[Latency-2:0], valid_i};
    end
  end

  // Registers in front of digit stage i; the last ones are in front of the rounding.
  logic [SigBits-1:0] divisor_q[DigitLatency+1];
  logic [SigBits-1:0] remainder_q[DigitLatency+1];
  logic [QuotBits-1:0] quotient_q[DigitLatency+1];
  side_t side_q[DigitLatency+1];

  /// {exponent field of 1/a when 1/m < 1, significand m without leading zeros}; anything for zero.
  function automatic logic [WideExpBits+SigBits-1:0] normalise(logic [ExpBits-1:0] exp_a,
                                                               logic [FracBits-1:0] frac_a);
    logic [WideExpBits-1:0] exp_rcp;
    logic [SigBits-1:0] sig_left;
    // Exponent 0 has the scale of exponent 1.
    exp_rcp  = WideExpBits'(2 * Bias - 1) - WideExpBits'(exp_a == '0 ? ExpBits'(1) : exp_a);
    sig_left = {exp_a != '0, frac_a};
    for (int i = NormSteps - 1; i >= 0; i--) begin
      if ((sig_left >> (SigBits - (1 << i))) == '0) begin
        exp_rcp  = exp_rcp + WideExpBits'(1 << i);
        sig_left = sig_left << (1 << i);
      end
    end
    return {exp_rcp, sig_left};
  endfunction

  // Step 1: unpack and normalise; the integer bit of the quotient is 1 only for a power of two.
  always_ff @(posedge clk_i) begin
    if (valid_i) begin
      automatic logic [ExpBits-1:0] exp_a = a_i[FracBits+:ExpBits];
      automatic logic [FracBits-1:0] frac_a = a_i[FracBits-1:0];
      automatic logic [WideExpBits+SigBits-1:0] normal = normalise(exp_a, frac_a);
      automatic logic one = normal[FracBits-1:0] == '0;

      divisor_q[0] <= normal[SigBits-1:0];
      remainder_q[0] <= {!one, {FracBits{1'b0}}};
      quotient_q[0] <= QuotBits'(one);
      side_q[0] <= '{
          sign: a_i[Width-1],
          to_nan: (&exp_a) && frac_a != '0,
          to_inf: a_i[MagBits-1:0] == '0,
          to_zero: (&exp_a) && frac_a == '0,
          exponent: normal[SigBits+:WideExpBits]
      };
    end
  end

  // Step 2: long division.  Always 0 <= remainder < divisor.

  /// {quotient, remainder} after `BitsPerStage` more bits.
  function automatic logic [QuotBits+SigBits-1:0] divide(
      logic [QuotBits-1:0] quotient, logic [SigBits-1:0] remainder, logic [SigBits-1:0] divisor);
    logic [QuotBits-1:0] quotient_left;
    logic [SigBits:0] remainder_left;
    logic fits;
    quotient_left  = quotient;
    remainder_left = {1'b0, remainder};
    for (int i = 0; i < BitsPerStage; i++) begin
      remainder_left = remainder_left << 1;
      fits = remainder_left >= {1'b0, divisor};
      if (fits) remainder_left = remainder_left - {1'b0, divisor};
      quotient_left = {quotient_left[QuotBits-2:0], fits};
    end
    return {quotient_left, remainder_left[SigBits-1:0]};
  endfunction

  for (genvar i = 0; i < DigitLatency; i++) begin : gen_digit
    always_ff @(posedge clk_i) begin
      if (valid_q[i]) begin
        {quotient_q[i+1], remainder_q[i+1]} <= divide(quotient_q[i], remainder_q[i], divisor_q[i]);
        divisor_q[i+1] <= divisor_q[i];
        side_q[i+1] <= side_q[i];
      end
    end
  end

  // Step 3: the exponent is at least -1, so a subnormal result is one or two places away; round.

  /// 1/m at its exponent, rounded and packed.
  function automatic logic [Width-1:0] pack(side_t side, logic [QuotBits-1:0] quotient,
                                            logic [SigBits-1:0] remainder);
    logic signed [WideExpBits-1:0] exponent;
    logic [QuotBits+1:0] shifted;
    logic [MagBits-1:0] mag;
    logic [Width-1:0] result;
    logic guard, sticky;
    exponent = side.exponent + WideExpBits'(quotient[QuotBits-1]);
    shifted  = {quotient[QuotBits-1] ? quotient : quotient << 1, 2'b00};
    if (exponent == 0) shifted = shifted >> 1;
    if (exponent < 0) shifted = shifted >> 2;
    mag = {shifted[QuotBits+1] ? exponent[ExpBits-1:0] : ExpBits'(0), shifted[QuotBits-:FracBits]};
    guard = shifted[QuotBits-FracBits];
    sticky = (|shifted[QuotBits-FracBits-1:0]) || remainder != '0;
    result = {side.sign, mag + MagBits'(guard && (sticky || mag[0]))};
    if (side.to_inf || 32'(exponent) >= ExpMax) begin
      result = {side.sign, {ExpBits{1'b1}}, {FracBits{1'b0}}};
    end
    if (side.to_zero) result = {side.sign, {MagBits{1'b0}}};
    if (side.to_nan) result = {1'b0, {ExpBits{1'b1}}, 1'b1, {(FracBits - 1) {1'b0}}};
    return result;
  endfunction

  always_ff @(posedge clk_i) begin
    if (valid_q[DigitLatency]) begin
      result_o <= pack(side_q[DigitLatency], quotient_q[DigitLatency], remainder_q[DigitLatency]);
    end
  end

  assign valid_o = valid_q[Latency-1];

endmodule : ti_fp_rcp
