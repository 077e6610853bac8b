// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/format.hpp"

namespace ti {

/// Neighbours of a real number among the finite values of a format. Each value of a format with at
/// most 8 exponent and 23 fraction bits is a `float`, so answers are floats.
class FormatGrid {
 public:
  explicit FormatGrid(const Format& format)
      : frac_bits_(format.frac_bits),
        min_exponent_(1 - format.bias()),
        flush_(format.modes.flush),
        max_((2.0 - power(-format.frac_bits)) * power(format.bias())) {}

  /// Largest value less than `x`; -inf when there is none.
  [[nodiscard]] float below(double x) const {
    if (x > max_) return static_cast<float>(max_);
    if (!(x > -max_)) return -std::numeric_limits<float>::infinity();
    const int exponent = exponent_of(x);
    const int unit = std::max(exponent, min_exponent_) - frac_bits_;
    const double scaled = x * power(-unit);
    double count = std::ceil(scaled) - 1.0;
    // The values just below a power of two stand half as far apart.
    if (scaled == power(frac_bits_) && exponent > min_exponent_) count += 0.5;
    const double value = count * power(unit);
    if (flush_ && std::abs(value) < power(min_exponent_))
      return value < 0.0 ? static_cast<float>(-power(min_exponent_)) : 0.0F;
    return static_cast<float>(value) + 0.0F;  // + 0: no -0
  }

  /// Smallest value greater than `x`; inf when there is none.
  [[nodiscard]] float above(double x) const { return 0.0F - below(-x); }

  /// Largest value that is at most `x`; -inf when there is none.
  [[nodiscard]] float at_most(double x) const {
    return below(std::nextafter(x, std::numeric_limits<double>::infinity()));
  }

  /// Smallest value that is at least `x`; inf when there is none.
  [[nodiscard]] float at_least(double x) const { return 0.0F - at_most(-x); }

  /// Distance of the values around `magnitude` (its unit in the last place).
  [[nodiscard]] double spacing(double magnitude) const {
    return power(std::max(exponent_of(magnitude), min_exponent_) - frac_bits_);
  }

  /// Largest finite value.
  [[nodiscard]] double max() const { return max_; }

 private:
  [[nodiscard]] static double power(int exponent) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52U);
  }
  [[nodiscard]] static int exponent_of(double x) {
    return static_cast<int>((std::bit_cast<std::uint64_t>(x) >> 52U) & 0x7FFU) - 1023;
  }

  int frac_bits_;
  int min_exponent_;
  bool flush_;
  double max_;
};

}  // namespace ti
