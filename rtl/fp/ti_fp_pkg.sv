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

  /// Units in the last place that cover three roundings: those of the t of a plane.
  localparam int unsigned OutwardUlps = TowardZero ? 8 : 4;

  /// `ti_fp_add`.
  localparam int unsigned AddLatency = ti_config_pkg::FpAddStages;

  /// `ti_fp_mul`.
  localparam int unsigned MulLatency = ti_config_pkg::FpMulStages;

  /// Quotient bits that `ti_fp_rcp` finds in one stage unless its parameter says otherwise.
  localparam int unsigned RcpBitsPerStage = ti_config_pkg::FpRcpBitsPerStage;

  /// Stages of `ti_fp_rcp` in front of and behind the quotient, unless its parameter says otherwise.
  localparam int unsigned RcpEndStages = ti_config_pkg::FpRcpEndStages;

  /// `ti_fp_rcp`: `end_stages`, and ceil((frac_bits + 2) / bits_per_stage) for the quotient.
  function automatic int unsigned rcp_latency(int unsigned frac_bits,
                                              int unsigned bits_per_stage = RcpBitsPerStage,
                                              int unsigned end_stages = RcpEndStages);
    return end_stages + (frac_bits + 1 + bits_per_stage) / bits_per_stage;
  endfunction

endpackage : ti_fp_pkg
