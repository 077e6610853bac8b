// SPDX-License-Identifier: Apache-2.0

/// Modes of the floating-point operators, and their latencies in cycles for the pipelines built from
/// them.
///
/// Both follow the configuration.  The operators check their own sum of steps against the stages
/// that they are asked for.
package ti_fp_pkg;

  /// Whether every operation rounds toward zero; to nearest even when not.
  localparam bit TowardZero = ti_config_pkg::Rounding == ti_config_pkg::RoundingZero;

  /// Whether subnormals are zeros of their sign, as operands and as results.
  localparam bit Flush = ti_config_pkg::Subnormals == ti_config_pkg::SubnormalsFlush;

  /// `ti_fp_add`.
  localparam int unsigned AddLatency = ti_config_pkg::FpAddStages;

  /// `ti_fp_mul`.
  localparam int unsigned MulLatency = ti_config_pkg::FpMulStages;

  /// From `ti_fp_cmp`, which is combinational, to what is decided by it.
  localparam int unsigned CmpLatency = ti_config_pkg::FpCmpStages;

  /// From the multiplexers that choose operands, of a step, an axis and a pass of IST1, to the operators.
  localparam int unsigned ChoiceLatency = (ti_config_pkg::LookupStages >= 4) ? 1 : 0;

  /// Quotient bits that `ti_fp_rcp` finds in one stage unless its parameter says otherwise.
  localparam int unsigned RcpBitsPerStage = ti_config_pkg::FpRcpBitsPerStage;

  /// Stages of `ti_fp_rcp` in front of and behind the quotient, unless its parameter says otherwise.
  localparam int unsigned RcpEndStages = ti_config_pkg::FpRcpEndStages;

  /// Whether reciprocals are found by Newton steps; by division when not.
  localparam bit Newton = ti_config_pkg::Reciprocal == ti_config_pkg::ReciprocalNewton;

  /// Bits of the index into the seeds of `ti_fp_newton`; 0: division.
  localparam int unsigned RcpTableBits = Newton ? ti_config_pkg::RcpTableBits : 0;

  /// Newton steps from a seed.
  localparam int unsigned RcpNewtonSteps = ti_config_pkg::RcpNewtonSteps;

  /// Stages of a product in a Newton step: in two halves where `ti_fp_mul` makes it so.
  localparam int unsigned RcpProductStages = (MulLatency >= 5) ? 2 : 1;

  /// `ti_fp_rcp`: `end_stages`, and in between ceil((frac_bits + 2) / bits_per_stage) for the quotient,
  /// or 1 for the seed and two products a Newton step.
  function automatic int unsigned rcp_latency(
      int unsigned frac_bits, int unsigned bits_per_stage = RcpBitsPerStage,
      int unsigned end_stages = RcpEndStages, int unsigned table_bits = RcpTableBits,
      int unsigned newton_steps = RcpNewtonSteps, int unsigned product_stages = RcpProductStages);
    if (table_bits != 0) return end_stages + 1 + 2 * newton_steps * product_stages;
    return end_stages + (frac_bits + 1 + bits_per_stage) / bits_per_stage;
  endfunction

  /// Bound on the error of `ti_fp_rcp` in halves of a unit in the last place, for normal results.
  ///
  /// By division 1 to nearest, 2 toward zero.  A seed of k index bits is relatively off by less than
  /// 3/4 of 2^-k: half the interval, and half a unit of its own.  A Newton step squares that and adds
  /// two units of 2^-(FracBits+3), to nearest one of either sign; then the result is rounded.  Kept
  /// in 2^-30, at last in sixteenths of a unit.
  function automatic int unsigned rcp_half_ulps(int unsigned frac_bits);
    logic [63:0] error, sixteenths;
    if (RcpTableBits == 0) return TowardZero ? 2 : 1;
    error = 64'd3 << (28 - RcpTableBits);
    if (RcpNewtonSteps > 1) begin
      error = ((error * error) >> 30) + 64'd1 + (64'd1 << (29 - frac_bits));
    end
    if (RcpNewtonSteps > 0) error = ((error * error) >> 30) + 64'd1;
    sixteenths = ((error << (frac_bits + 5)) >> 30) + (TowardZero ? 64'd25 : 64'd13);
    return 2 * 32'((sixteenths + 64'd15) >> 4);
  endfunction

  /// Units in the last place that cover a difference, an inverse and a product: the t of a plane.
  function automatic int unsigned outward_ulps(int unsigned frac_bits);
    return rcp_half_ulps(frac_bits) + (TowardZero ? 6 : 3);
  endfunction

endpackage : ti_fp_pkg
