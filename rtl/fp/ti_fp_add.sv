// SPDX-License-Identifier: Apache-2.0

/// Floating-point a + b, or a - b where `negate_b_i` is 1.
///
/// Latency 4, one result a cycle, never stalls: `valid_o` is `valid_i` four cycles later.  All paths
/// start and end in registers except the inputs.  A stage works only for a valid operand pair.
///
/// IEEE 754: one rounding to nearest even; subnormals kept on both sides; overflow gives infinity;
/// a NaN operand or infinity - infinity gives the one quiet NaN (sign 0, fraction 10...0);
/// x + -x is +0, -0 + -0 is -0.  Method: order by magnitude, align with guard, round and sticky
/// bits, add, shift left as far as the exponent allows, round.
module ti_fp_add #(
  /// Exponent bits, 3 to 8.
  parameter int unsigned ExpBits = 8,
  /// Stored fraction bits, 2 to 23.
  parameter int unsigned FracBits = 23,
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

  localparam int unsigned OrderLatency = 1;
  localparam int unsigned SumLatency = 1;
  localparam int unsigned NormLatency = 1;
  localparam int unsigned RoundLatency = 1;
  localparam int unsigned Latency = OrderLatency + SumLatency + NormLatency + RoundLatency;

  localparam int unsigned MagBits = ExpBits + FracBits;
  // Significand with its leading bit, then guard, round and sticky; the sum has a carry on top.
  localparam int unsigned SigBits = FracBits + 1;
  localparam int unsigned AlignedBits = SigBits + 3;
  localparam int unsigned SumBits = AlignedBits + 1;
  // A shift by SigBits + 2 leaves nothing but the sticky bit.
  localparam int unsigned ShiftMax = SigBits + 2;
  localparam int unsigned ShiftBits = $clog2(ShiftMax + 1);
  localparam int unsigned NormSteps = $clog2(SumBits);

  if (ExpBits < 3 || ExpBits > 8) begin : gen_check_exp_bits
    $error("ti_fp_add: ExpBits must be 3 to 8.");
  end
  if (FracBits < 2 || FracBits > 23) begin : gen_check_frac_bits
    $error("ti_fp_add: FracBits must be 2 to 23.");
  end
  if (Latency != ti_fp_pkg::AddLatency) begin : gen_check_latency
    $error("ti_fp_add: Latency is not that of ti_fp_pkg.");
  end

  logic [Latency-1:0] valid_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_q <= '0;
    end else begin
      valid_q <= {valid_q[Latency-2:0], valid_i};
    end
  end

  // Step 1: larger magnitude (`major`) first, distance of the exponents.
  logic [  MagBits-1:0] order_major_q;
  logic [  SigBits-1:0] order_minor_q;
  logic [ShiftBits-1:0] order_shift_q;
  logic order_subtract_q, order_sign_q, order_nan_q;

  /// Places by which the smaller significand moves right; exponents 0 and 1 have the same scale.
  function automatic logic [ShiftBits-1:0] align_shift(logic [ExpBits-1:0] exp_major,
                                                       logic [ExpBits-1:0] exp_minor);
    logic [ExpBits-1:0] distance;
    distance = exp_major - exp_minor;
    if (exp_minor == '0 && exp_major != '0) distance = distance - 1'b1;
    return 32'(distance) > ShiftMax ? ShiftBits'(ShiftMax) : ShiftBits'(distance);
  endfunction

  always_ff @(posedge clk_i) begin
    if (valid_i) begin
      automatic logic sign_a = a_i[Width-1];
      automatic logic sign_b = b_i[Width-1] ^ negate_b_i;
      automatic logic subtract = sign_a ^ sign_b;
      automatic logic equal = a_i[MagBits-1:0] == b_i[MagBits-1:0];
      automatic logic swap = a_i[MagBits-1:0] < b_i[MagBits-1:0];
      automatic logic [MagBits-1:0] major = swap ? b_i[MagBits-1:0] : a_i[MagBits-1:0];
      automatic logic [MagBits-1:0] minor = swap ? a_i[MagBits-1:0] : b_i[MagBits-1:0];
      automatic logic [ExpBits-1:0] exp_major = major[FracBits+:ExpBits];
      automatic logic [ExpBits-1:0] exp_minor = minor[FracBits+:ExpBits];

      order_major_q <= major;
      order_minor_q <= {exp_minor != '0, minor[FracBits-1:0]};
      order_shift_q <= align_shift(exp_major, exp_minor);
      order_subtract_q <= subtract;
      order_sign_q <= (swap ? sign_b : sign_a) && !(subtract && equal);
      order_nan_q <= (&exp_major) && ((|major[FracBits-1:0]) || (subtract && (&exp_minor)));
    end
  end

  // Step 2: align and add.  Bits that leave on the right stay as the sticky bit.
  logic [SumBits-1:0] sum_q;
  logic [ExpBits-1:0] sum_exp_q;
  logic sum_sign_q, sum_nan_q;

  /// Sum of significands, three more places on the right, a carry on the left.
  function automatic logic [SumBits-1:0] sum_of(logic [MagBits-1:0] major,
                                                logic [SigBits-1:0] minor,
                                                logic [ShiftBits-1:0] shift, logic subtract);
    logic [SigBits+ShiftMax-1:0] wide;
    logic [SumBits-1:0] base, addend;
    wide   = {minor, {ShiftMax{1'b0}}} >> shift;
    base   = {1'b0, major[FracBits+:ExpBits] != '0, major[FracBits-1:0], 3'b000};
    addend = {1'b0, wide[SigBits+ShiftMax-1:SigBits], |wide[SigBits-1:0]};
    return subtract ? base - addend : base + addend;
  endfunction

  always_ff @(posedge clk_i) begin
    if (valid_q[0]) begin
      sum_q <= sum_of(order_major_q, order_minor_q, order_shift_q, order_subtract_q);
      sum_exp_q <= order_major_q[FracBits+:ExpBits];
      sum_sign_q <= order_sign_q;
      sum_nan_q <= order_nan_q;
    end
  end

  // Step 3: normalise.
  logic [MagBits-1:0] norm_mag_q;
  logic norm_guard_q, norm_sticky_q, norm_inf_q, norm_sign_q, norm_nan_q;

  /// {exponent field, sum} with the sum moved left by its leading zeros, or as far as exponent 1.
  ///
  /// A step of 2^i places is written without a branch, which a simulator would guess wrong.
  function automatic logic [ExpBits+SumBits-1:0] normalise(logic [ExpBits-1:0] exp_major,
                                                           logic [SumBits-1:0] sum);
    logic [ExpBits-1:0] exp_left;
    logic [SumBits-1:0] sum_left;
    logic [NormSteps-1:0] step;
    logic moves;
    // The exponent of the carry bit; exponent 0 has the scale of exponent 1.
    exp_left = exp_major == '0 ? ExpBits'(2) : exp_major + ExpBits'(1);
    sum_left = sum;
    for (int i = NormSteps - 1; i >= 0; i--) begin
      moves = (sum_left >> (SumBits - (1 << i))) == '0 && 32'(exp_left) > (1 << i);
      step = NormSteps'(moves) << i;
      exp_left = exp_left - ExpBits'(step);
      sum_left = sum_left << step;
    end
    return {sum_left[SumBits-1] ? exp_left : ExpBits'(0), sum_left};
  endfunction

  always_ff @(posedge clk_i) begin
    if (valid_q[1]) begin
      automatic logic [ExpBits+SumBits-1:0] normal = normalise(sum_exp_q, sum_q);

      norm_mag_q <= {normal[SumBits+:ExpBits], normal[SumBits-2-:FracBits]};
      norm_guard_q <= normal[SumBits-2-FracBits];
      norm_sticky_q <= |normal[SumBits-3-FracBits:0];
      norm_inf_q <= (&sum_exp_q) || (&normal[SumBits+:ExpBits]);
      norm_sign_q <= sum_sign_q;
      norm_nan_q <= sum_nan_q;
    end
  end

  // Step 4: round.  A carry out of the fraction is the right exponent, up to infinity.
  always_ff @(posedge clk_i) begin
    if (valid_q[2]) begin
      automatic logic norm_up = norm_guard_q && (norm_sticky_q || norm_mag_q[0]);

      if (norm_nan_q) begin
        result_o <= {1'b0, {ExpBits{1'b1}}, 1'b1, {(FracBits - 1) {1'b0}}};
      end else if (norm_inf_q) begin
        result_o <= {norm_sign_q, {ExpBits{1'b1}}, {FracBits{1'b0}}};
      end else begin
        result_o <= {norm_sign_q, norm_mag_q + MagBits'(norm_up)};
      end
    end
  end

  assign valid_o = valid_q[Latency-1];

endmodule : ti_fp_add
