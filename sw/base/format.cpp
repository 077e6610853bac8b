// SPDX-License-Identifier: Apache-2.0
#include "base/format.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ti {

double Format::rounding_unit() const {
  return std::ldexp(1.0, modes.toward_zero ? -frac_bits : -frac_bits - 1);
}

double Format::reciprocal_unit() const {
  return std::ldexp(static_cast<double>(reciprocal_half_ulps()), -frac_bits - 1);
}

double Format::least_normal() const { return std::ldexp(1.0, 1 - bias()); }

double Format::underflow_unit() const {
  return modes.flush ? least_normal() : least_normal() * rounding_unit();
}

std::string name_of(const Format& format) {
  std::string text =
      "(" + std::to_string(format.exp_bits) + "," + std::to_string(format.frac_bits) + ")";
  const char* before = " ";
  const auto add = [&](const std::string& words) {
    text += before + words;
    before = ", ";
  };
  if (format.modes.toward_zero) add("toward zero");
  if (format.modes.flush) add("flushed");
  if (format.modes.rcp_table_bits > 0)
    add(std::to_string(format.modes.rcp_newton_steps) + " steps from " +
        std::to_string(format.modes.rcp_table_bits) + " bits");
  return text;
}

std::uint32_t round_to_bits(const Format& format, double value) {
  const int m = format.frac_bits;
  const std::uint32_t inf = ((1u << format.exp_bits) - 1) << m;
  if (std::isnan(value)) return inf | (1u << (m - 1));
  const std::uint32_t sign = std::signbit(value) ? 1u << (format.exp_bits + m) : 0u;
  if (std::isinf(value)) return sign | inf;
  if (value == 0.0) return sign;

  // value = significand * 2^exponent with a 53-bit (or shorter, for subnormal doubles) significand.
  int exponent = 0;
  const double fraction = std::frexp(std::fabs(value), &exponent);
  const auto significand = static_cast<std::uint64_t>(std::ldexp(fraction, 53));
  exponent -= 53;

  // The unit of the last place is 2^(field - bias - m), with the least field 1 shared by
  // subnormals that are kept.
  const bool flush = format.modes.flush;
  const int field = std::max(exponent + 52 + format.bias(), flush ? -m : 1);
  if (field > 2 * format.bias()) return sign | inf;
  const int dropped = field - format.bias() - m - exponent;  // at least 52 - m
  if (dropped > 54) return sign;
  const std::uint64_t kept = significand >> dropped;
  const std::uint64_t rest = significand - (kept << dropped);
  const std::uint64_t half = std::uint64_t{1} << (dropped - 1);
  const bool up = rest > half || (rest == half && (kept & 1) != 0);
  // `kept` has its leading bit at m for normal numbers, which counts one into the exponent field; a
  // carry of the rounding does the same, up to infinity.
  const std::int64_t base = std::int64_t{field - 1} * (std::int64_t{1} << m);
  const std::int64_t magnitude = base + static_cast<std::int64_t>(kept) + (up ? 1 : 0);
  if (flush && magnitude < std::int64_t{1} << m) return sign;
  return sign | static_cast<std::uint32_t>(magnitude);
}

double value_of_bits(const Format& format, std::uint32_t bits) {
  const int m = format.frac_bits;
  const std::uint32_t fraction = bits & ((1u << m) - 1);
  const int field = static_cast<int>((bits >> m) & ((1u << format.exp_bits) - 1));
  const bool negative = ((bits >> (format.exp_bits + m)) & 1) != 0;

  double magnitude = 0.0;
  if (field == (1 << format.exp_bits) - 1) {
    if (fraction != 0) return std::numeric_limits<double>::quiet_NaN();
    magnitude = std::numeric_limits<double>::infinity();
  } else if (field == 0 && format.modes.flush) {
    magnitude = 0.0;
  } else if (field == 0) {
    magnitude = std::ldexp(static_cast<double>(fraction), 1 - format.bias() - m);
  } else {
    magnitude = std::ldexp(static_cast<double>(fraction | (1u << m)), field - format.bias() - m);
  }
  return negative ? -magnitude : magnitude;
}

}  // namespace ti
