// SPDX-License-Identifier: Apache-2.0

/// Latencies in cycles of the floating-point operators, for the pipelines built from them.
///
/// The operators check their own sum of steps against these values.
package ti_fp_pkg;

  /// `ti_fp_add`: order, align and add, normalise, round.
  localparam int unsigned AddLatency = 4;

  /// `ti_fp_mul`: multiply, normalise, round.
  localparam int unsigned MulLatency = 3;

  /// Quotient bits that `ti_fp_rcp` finds in one stage unless its parameter says otherwise.
  localparam int unsigned RcpBitsPerStage = 2;

  /// `ti_fp_rcp`: unpack, ceil((frac_bits + 2) / bits_per_stage) digit stages, round.
  function automatic int unsigned rcp_latency(int unsigned frac_bits,
                                              int unsigned bits_per_stage = RcpBitsPerStage);
    return 2 + (frac_bits + 1 + bits_per_stage) / bits_per_stage;
  endfunction

endpackage : ti_fp_pkg
