// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace ti {

/// A binary floating-point format: sign, `exp_bits` of exponent, `frac_bits` of fraction, IEEE 754
/// rules.
struct Format {
  int exp_bits = 8;    ///< 3 to 8
  int frac_bits = 23;  ///< 2 to 23

  bool operator==(const Format&) const = default;

  [[nodiscard]] constexpr int width() const { return 1 + exp_bits + frac_bits; }
  [[nodiscard]] int bias() const { return (1 << (exp_bits - 1)) - 1; }
};

/// Bits (right-aligned) of the value of `format` nearest to `value`, ties to even; NaN becomes the
/// canonical quiet NaN.
[[nodiscard]] std::uint32_t round_to_bits(Format format, double value);

/// The exact value that `bits` stands for in `format`.
[[nodiscard]] double value_of_bits(Format format, std::uint32_t bits);

/// `value` rounded to `format`, as a double.
[[nodiscard]] inline double round_to(Format format, double value) {
  return value_of_bits(format, round_to_bits(format, value));
}

}  // namespace ti
