// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/format.hpp"

namespace ti {

/// A format with what arithmetic in it needs, worked out once, and the rounding of a real number to
/// it that a `double` and the sign of its error stand for.
class FpRules {
 public:
  constexpr explicit FpRules(const Format& of)
      : format(of),
        sign_bit(std::uint32_t{1} << (of.exp_bits + of.frac_bits)),
        inf_bits(((std::uint32_t{1} << of.exp_bits) - 1) << of.frac_bits),
        nan_bits(inf_bits | (std::uint32_t{1} << (of.frac_bits - 1))),
        rebias(static_cast<std::uint32_t>(127 - of.bias()) << 23),
        least_normal(pow2(1 - of.bias())),
        quantum(pow2(1 - of.bias() - of.frac_bits)),
        quanta(pow2(of.bias() + of.frac_bits - 1)),
        reciprocal_half_ulps(of.reciprocal_half_ulps()) {}

  Format format;
  std::uint32_t sign_bit;
  std::uint32_t inf_bits;  ///< of +infinity
  std::uint32_t nan_bits;  ///< the one quiet NaN
  std::uint32_t rebias;    ///< what a float image has on top of that of the format, where normal
  double least_normal;
  double quantum;  ///< least subnormal
  double quanta;   ///< in 1
  int reciprocal_half_ulps;

  /// `value` rounded to nearest even. The float is exact.
  [[nodiscard]] constexpr float nearest(double value) const { return round(value, false); }

  /// The number that `value`, its double nearest to even, stands for, rounded toward zero; `error`
  /// has the sign of that number less `value`, or is 0 where they are equal.
  ///
  /// The double is the number rounded to nearest. Where that has gone away from zero the next
  /// double towards zero is on the right side, and between the two there is no value of the format.
  [[nodiscard]] constexpr float toward_zero(double value, double error) const {
    if (value < 0.0 ? error > 0.0 : error < 0.0)
      value = std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) - 1);
    return round(value, true);
  }

  /// 1 / x by Newton steps from a table of seeds, where the format has one; x a number or zero as
  /// operations see it.
  ///
  /// Bit-exact model of `ti_fp_newton`: x = X 2^-M in [1, 2) is inverted as Y 2^-(M+3) in [1/2, 1).
  /// A step is Y := Y E 2^-(M+3) cut off, plus 1 to nearest, with E = 2^(M+4) - 1 - X Y 2^-M cut
  /// off. Then Y is rounded as any result. Powers of two are exact.
  [[nodiscard]] constexpr float newton(double x) const {
    const int m = format.frac_bits;
    const std::uint64_t image = std::bit_cast<std::uint64_t>(size(x));
    const std::uint64_t fraction = (image & ((std::uint64_t{1} << 52) - 1)) >> (52 - m);
    if (fraction == 0 || !(size(x) < std::numeric_limits<double>::infinity()))
      return rounded(1.0 / x);
    const int exponent = static_cast<int>(image >> 52) - 1023;
    return rounded(
        signed_like(static_cast<double>(inverse(fraction)) * pow2(-exponent - m - 3), x));
  }

  /// The Y of `newton` for X = 2^M + `fraction`, which is not 2^M.
  [[nodiscard]] constexpr std::uint64_t inverse(std::uint64_t fraction) const {
    const int m = format.frac_bits;
    const int k = format.modes.rcp_table_bits;
    const std::uint64_t x = std::uint64_t{1} << m | fraction;
    std::uint64_t y = seed(k, fraction >> (m - k)) << (m + 2 - k);
    for (int step = 0; step < format.modes.rcp_newton_steps; ++step) {
      const std::uint64_t e = (std::uint64_t{1} << (m + 4)) - 1 - (x * y >> m);
      y = (y * e >> (m + 3)) + (format.modes.toward_zero ? 0 : 1);
    }
    return y;
  }

 private:
  /// The inverse of the middle of the interval with that index, in units of 2^-(k+1).
  static constexpr std::uint64_t seed(int k, std::uint64_t index) {
    const std::uint64_t middle = (std::uint64_t{1} << (k + 1)) + 2 * index + 1;
    return ((std::uint64_t{1} << (2 * k + 3)) + middle) / (2 * middle);
  }
  /// `value`, which is exact, rounded as operations do.
  [[nodiscard]] constexpr float rounded(double value) const {
    return round(value, format.modes.toward_zero);
  }

  /// 2^exponent, exact, for normal doubles.
  static constexpr double pow2(int exponent) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
  }
  static constexpr double size(double value) {
    return std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) & ~(std::uint64_t{1} << 63));
  }

  [[nodiscard]] constexpr float round(double value, bool truncate) const {
    const int dropped = 52 - format.frac_bits;
    const std::uint64_t overflow = static_cast<std::uint64_t>(1023 + format.bias() + 1) << 52;
    const bool flush = format.modes.flush;
    const double magnitude = size(value);
    if (magnitude < least_normal && !flush) {
      // In this binade of double one unit is one quantum, so that the addition rounds.
      const double shift = pow2(52) * quantum;
      const double rounded =
          truncate ? static_cast<double>(static_cast<std::uint32_t>(magnitude * quanta)) * quantum
                   : (magnitude + shift) - shift;
      return static_cast<float>(signed_like(rounded, value));
    }
    if (magnitude != magnitude) return std::numeric_limits<float>::quiet_NaN();
    std::uint64_t image = std::bit_cast<std::uint64_t>(magnitude);
    const bool finite = magnitude < std::numeric_limits<double>::infinity();
    if (!truncate) image += (std::uint64_t{1} << (dropped - 1)) - 1 + ((image >> dropped) & 1);
    image &= ~((std::uint64_t{1} << dropped) - 1);
    if (image >= overflow) {
      const std::uint64_t largest = overflow - (std::uint64_t{1} << dropped);
      image = truncate && finite ? largest : std::uint64_t{0x7ff} << 52;
    }
    const double rounded = std::bit_cast<double>(image);
    return static_cast<float>(signed_like(flush && rounded < least_normal ? 0.0 : rounded, value));
  }
  static constexpr double signed_like(double magnitude, double value) {
    const std::uint64_t sign = std::bit_cast<std::uint64_t>(value) & (std::uint64_t{1} << 63);
    return std::bit_cast<double>(std::bit_cast<std::uint64_t>(magnitude) | sign);
  }
};

}  // namespace ti
