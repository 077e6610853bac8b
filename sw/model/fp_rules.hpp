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
        quanta(pow2(of.bias() + of.frac_bits - 1)) {}

  Format format;
  std::uint32_t sign_bit;
  std::uint32_t inf_bits;  ///< of +infinity
  std::uint32_t nan_bits;  ///< the one quiet NaN
  std::uint32_t rebias;    ///< what a float image has on top of that of the format, where normal
  double least_normal;
  double quantum;  ///< least subnormal
  double quanta;   ///< in 1

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

 private:
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
      return signed_like(rounded, value);
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
    return signed_like(flush && rounded < least_normal ? 0.0 : rounded, value);
  }
  static constexpr float signed_like(double magnitude, double value) {
    const std::uint64_t sign = std::bit_cast<std::uint64_t>(value) & (std::uint64_t{1} << 63);
    return static_cast<float>(
        std::bit_cast<double>(std::bit_cast<std::uint64_t>(magnitude) | sign));
  }
};

}  // namespace ti
