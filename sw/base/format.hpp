// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace ti {

/// How the operators of an engine round, what they do near zero, and how they invert; `docs/fp.md`
/// has the rules.
struct Modes {
  bool toward_zero = false;  ///< every operation rounds toward zero; to nearest even when not
  bool flush = false;        ///< subnormals are zeros of their sign, as operands and as results
  int rcp_table_bits = 0;    ///< of the index into the seeds of 1/x; 0: division, no Newton steps
  int rcp_newton_steps = 0;  ///< 0 to 2

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
  /// Bound on the error of a reciprocal that is a normal number, in halves of a unit in the last
  /// place: 1 by division to nearest, 2 by division toward zero.
  [[nodiscard]] constexpr int reciprocal_half_ulps() const;
  /// The same as a relative error.
  [[nodiscard]] double reciprocal_unit() const;
  /// Largest error of an operation whose result is below the least normal number.
  [[nodiscard]] double underflow_unit() const;
  /// Least normal number.
  [[nodiscard]] double least_normal() const;
};

/// The numbers in which an engine has a scene: a place p as p 2^scale in `numbers`.
struct ScaledFormat {
  Format numbers;
  int scale = 0;
  bool by_area = false;  ///< t is found by products with the area of the triangle (Woop's test)

  ScaledFormat(const Format& format = {}, int exponent = 0, bool woop = false)
      : numbers(format), scale(exponent), by_area(woop) {}
};

constexpr int Format::reciprocal_half_ulps() const {
  if (modes.rcp_table_bits == 0) return modes.toward_zero ? 2 : 1;
  // The relative error of a seed in 2^-30, then that before the last step, as `ti_fp_pkg` has it.
  std::uint64_t error = std::uint64_t{3} << (28 - modes.rcp_table_bits);
  for (int step = 1; step < modes.rcp_newton_steps; ++step)
    error = (error * error >> 30) + 1 + (std::uint64_t{1} << (29 - frac_bits));
  if (modes.rcp_newton_steps > 0) error = (error * error >> 30) + 1;
  // In sixteenths of a unit, with the roundings of the last step and of the result.
  const std::uint64_t sixteenths =
      (error << (frac_bits + 5) >> 30) + 1 + (modes.toward_zero ? 24 : 12);
  return 2 * static_cast<int>((sixteenths + 15) / 16);
}

/// As in "(8,23)", with the modes that are not the default behind it: "(7,16) toward zero,
/// flushed, 2 steps from 7 bits".
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
