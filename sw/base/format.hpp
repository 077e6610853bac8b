// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace ti {

/// How the operators of an engine round and what they do near zero; `docs/fp.md` has the rules.
struct Modes {
  bool toward_zero = false;  ///< every operation rounds toward zero; to nearest even when not
  bool flush = false;        ///< subnormals are zeros of their sign, as operands and as results

  bool operator==(const Modes&) const = default;
};

/// A binary floating-point format: sign, `exp_bits` of exponent, `frac_bits` of fraction, IEEE 754
/// rules but for its modes.
struct Format {
  int exp_bits = 8;    ///< 3 to 8
  int frac_bits = 23;  ///< 2 to 23
  Modes modes{};

  bool operator==(const Format&) const = default;

  [[nodiscard]] constexpr int width() const { return 1 + exp_bits + frac_bits; }
  [[nodiscard]] constexpr int bias() const { return (1 << (exp_bits - 1)) - 1; }

  /// Largest relative error of an operation whose result is a normal number.
  [[nodiscard]] double rounding_unit() const;
  /// Largest error of an operation whose result is below the least normal number.
  [[nodiscard]] double underflow_unit() const;
  /// Least normal number.
  [[nodiscard]] double least_normal() const;
};

/// As in "(8,23)", with the modes that are not the default behind it: "(7,16) toward zero,
/// flushed".
[[nodiscard]] std::string name_of(const Format& format);

/// Bits (right-aligned) of the value of `format` nearest to `value`, ties to even, in every mode:
/// so programs round what they give to an engine. NaN becomes the canonical quiet NaN; with `flush`
/// what is below the least normal number after rounding to `frac_bits` becomes zero of its sign.
[[nodiscard]] std::uint32_t round_to_bits(const Format& format, double value);

/// The exact value that `bits` stands for in `format`.
[[nodiscard]] double value_of_bits(const Format& format, std::uint32_t bits);

/// `value` rounded to `format`, as a double.
[[nodiscard]] inline double round_to(const Format& format, double value) {
  return value_of_bits(format, round_to_bits(format, value));
}

}  // namespace ti
