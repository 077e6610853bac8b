// SPDX-License-Identifier: Apache-2.0

/// Floating-point a * b.
///
/// Latency 3, one result a cycle, never stalls: `valid_o` is `valid_i` three cycles later.  All
/// paths start and end in registers except the inputs.  A stage works only for a valid pair.
///
/// IEEE 754: one rounding to nearest even; subnormals kept on both sides; overflow gives infinity;
/// a NaN operand or 0 * infinity gives the one quiet NaN (sign 0, fraction 10...0); the sign of
/// every other result, zeros included, is the exclusive or of the signs.  Method: full product of
/// the significands as they stand, one shift (left while the exponent allows, or right into the
/// subnormals), round.
module ti_fp_mul #(
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

  output logic             valid_o,
  output logic [Width-1:0] result_o
);

  localparam int unsigned ProductLatency = 1;
  localparam int unsigned NormLatency = 1;
  localparam int unsigned RoundLatency = 1;
  localparam int unsigned Latency = ProductLatency + NormLatency + RoundLatency;

  localparam int unsigned MagBits = ExpBits + FracBits;
  localparam int unsigned SigBits = FracBits + 1;
  localparam int unsigned ProdBits = 2 * SigBits;
  // Enough for the signed sum of two exponents of up to 8 bits less the bias.
  localparam int unsigned SumExpBits = 10;
  localparam int signed Bias = (1 << (ExpBits - 1)) - 1;
  localparam int unsigned ExpMax = (1 << ExpBits) - 1;
  // A shift by SigBits + 1 leaves nothing but the sticky bit.
  localparam int unsigned ShiftMax = SigBits + 1;
  localparam int unsigned ShiftBits = $clog2(ShiftMax + 1);
  // A product to be moved left has at most one subnormal factor: up to SigBits leading zeros.
  localparam int unsigned NormSteps = $clog2(SigBits + 1);

  if (ExpBits < 3 || ExpBits > 8) begin : gen_check_exp_bits
    $error("ti_fp_mul: ExpBits must be 3 to 8.");
  end
  if (FracBits < 2 || FracBits > 23) begin : gen_check_frac_bits
    $error("ti_fp_mul: FracBits must be 2 to 23.");
  end
  if (Latency != ti_fp_pkg::MulLatency) begin : gen_check_latency
    $error("ti_fp_mul: Latency is not that of ti_fp_pkg.");
  end

  logic [Latency-1:0] valid_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_q <= '0;
    end else begin
      valid_q <= {valid_q[Latency-2:0], valid_i};
    end
  end

  // Step 1: product; exponent of its top bit.
  logic [ProdBits-1:0] prod_q;
  logic signed [SumExpBits-1:0] prod_exp_q;
  logic prod_sign_q, prod_nan_q, prod_inf_q;

  always_ff @(posedge clk_i) begin
    if (valid_i) begin
      automatic logic [ExpBits-1:0] exp_a = a_i[FracBits+:ExpBits];
      automatic logic [ExpBits-1:0] exp_b = b_i[FracBits+:ExpBits];
      automatic logic [FracBits-1:0] frac_a = a_i[FracBits-1:0];
      automatic logic [FracBits-1:0] frac_b = b_i[FracBits-1:0];
      automatic logic max_a = &exp_a;
      automatic logic max_b = &exp_b;

      prod_q <= ProdBits'({exp_a != '0, frac_a}) * ProdBits'({exp_b != '0, frac_b});
      // Exponent 0 has the scale of exponent 1.
      prod_exp_q <= SumExpBits'(exp_a) + SumExpBits'(exp_b) + SumExpBits'(exp_a == '0)
          + SumExpBits'(exp_b == '0) - SumExpBits'(Bias - 1);
      prod_sign_q <= a_i[Width-1] ^ b_i[Width-1];
      prod_inf_q <= max_a || max_b;
      prod_nan_q <= (max_a && frac_a != '0) || (max_b && frac_b != '0)
          || (max_a && b_i[MagBits-1:0] == '0) || (max_b && a_i[MagBits-1:0] == '0);
    end
  end

  // Step 2: one shift.
  logic [MagBits-1:0] norm_mag_q;
  logic norm_guard_q, norm_sticky_q, norm_inf_q, norm_sign_q, norm_nan_q;

  /// {exponent field, product} with the product moved left by its leading zeros, or as far as
  /// exponent 1.  For a positive exponent.
  ///
  /// A step of 2^i places is written without a branch, which a simulator would guess wrong.
  function automatic logic [SumExpBits+ProdBits-1:0] normalise(
      logic signed [SumExpBits-1:0] exponent, logic [ProdBits-1:0] product);
    logic [SumExpBits-1:0] exp_left;
    logic [ProdBits-1:0] prod_left;
    logic [NormSteps-1:0] step;
    logic moves;
    exp_left  = exponent;
    prod_left = product;
    for (int i = NormSteps - 1; i >= 0; i--) begin
      moves = (prod_left >> (ProdBits - (1 << i))) == '0 && 32'(exp_left) > (1 << i);
      step = NormSteps'(moves) << i;
      exp_left = exp_left - SumExpBits'(step);
      prod_left = prod_left << step;
    end
    return {prod_left[ProdBits-1] ? exp_left : SumExpBits'(0), prod_left};
  endfunction

  /// {0, product} with the product moved right to exponent 1; what leaves is kept in its lowest bit.
  /// For an exponent of 0 or less.
  function automatic logic [SumExpBits+ProdBits-1:0] denormalise(
      logic signed [SumExpBits-1:0] exponent, logic [ProdBits-1:0] product);
    logic [SumExpBits-1:0] distance;
    logic [ShiftBits-1:0] shift;
    logic lost;
    distance = SumExpBits'(1) - exponent;
    shift = 32'(distance) > ShiftMax ? ShiftBits'(ShiftMax) : ShiftBits'(distance);
    lost = |(product[ShiftMax-1:0] & ~({ShiftMax{1'b1}} << shift));
    return {SumExpBits'(0), (product >> shift) | ProdBits'(lost)};
  endfunction

  /// `normalise` or `denormalise`, as the exponent asks.
  function automatic logic [SumExpBits+ProdBits-1:0] shifted(logic signed [SumExpBits-1:0] exponent,
                                                             logic [ProdBits-1:0] product);
    logic [SumExpBits+ProdBits-1:0] result;
    if (exponent > 0) result = normalise(exponent, product);
    else result = denormalise(exponent, product);
    return result;
  endfunction

  always_ff @(posedge clk_i) begin
    if (valid_q[0]) begin
      automatic logic [SumExpBits+ProdBits-1:0] normal = shifted(prod_exp_q, prod_q);

      norm_mag_q <= {normal[ProdBits+:ExpBits], normal[ProdBits-2-:FracBits]};
      norm_guard_q <= normal[ProdBits-2-FracBits];
      norm_sticky_q <= |normal[ProdBits-3-FracBits:0];
      norm_inf_q <= prod_inf_q || 32'(normal[ProdBits+:SumExpBits]) >= ExpMax;
      norm_sign_q <= prod_sign_q;
      norm_nan_q <= prod_nan_q;
    end
  end

  // Step 3: round.  A carry out of the fraction is the right exponent, up to infinity.
  always_ff @(posedge clk_i) begin
    if (valid_q[1]) begin
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

endmodule : ti_fp_mul
