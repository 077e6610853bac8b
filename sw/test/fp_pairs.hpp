// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <utility>

namespace ti::test {

/// Seeded source of operand images of a format, weighted towards the places where operators go
/// wrong.
///
/// A quarter of the pairs are uniform bits. The rest are pairs of special values; pairs of near
/// exponents; pairs that nearly cancel; pairs whose product or sum is near the ends of the range;
/// and fractions of few bits, which make ties.
class FpPairs {
 public:
  FpPairs(int exp_bits, int frac_bits, std::uint64_t seed)
      : exp_bits_(exp_bits), frac_bits_(frac_bits), state_(seed) {}

  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> next() {
    const std::uint32_t a = value(below(6));
    switch (below(8)) {
      case 0:
      case 1:
        return {uniform(), uniform()};
      case 2:
        return {special(), special()};
      case 3:
        return ordered(special(), a);
      case 4: {  // exponents so near that the smaller operand decides the rounding
        const int reach = frac_bits_ + 3;
        const int exponent = exponent_of(a) + static_cast<int>(below(2 * reach + 1)) - reach;
        return ordered(a, any_with(exponent));
      }
      case 5: {  // nearly equal magnitudes
        const std::uint32_t moved = a + below(9) - 4;
        return {a, (moved ^ (below(2) << (exp_bits_ + frac_bits_))) & mask()};
      }
      case 6: {  // product near the underflow, or near 1 or the overflow
        const int bias = (1 << (exp_bits_ - 1)) - 1;
        const std::array<int, 3> targets = {1 - static_cast<int>(below(frac_bits_ + 4)), bias,
                                            2 * bias + 1};
        const int exponent =
            targets[below(3)] + bias - exponent_of(a) + static_cast<int>(below(3)) - 1;
        return ordered(a, any_with(exponent));
      }
      default:
        return {a, value(below(6))};
    }
  }

 private:
  /// SplitMix64 (Steele, Lea, Flood 2014).
  std::uint64_t random() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint32_t below(int bound) {
    return static_cast<std::uint32_t>((random() >> 32) * static_cast<std::uint64_t>(bound) >> 32);
  }

  std::uint32_t mask() const {
    return static_cast<std::uint32_t>((std::uint64_t{1} << (1 + exp_bits_ + frac_bits_)) - 1);
  }
  std::uint32_t frac_mask() const { return (1u << frac_bits_) - 1; }
  int exp_max() const { return (1 << exp_bits_) - 1; }
  int exponent_of(std::uint32_t bits) const {
    return static_cast<int>(bits >> frac_bits_) & exp_max();
  }
  std::uint32_t uniform() { return static_cast<std::uint32_t>(random()) & mask(); }

  /// The exponent is brought into the range of the format.
  std::uint32_t pack(std::uint32_t sign, int exponent, std::uint32_t fraction) const {
    const int clamped = exponent < 0 ? 0 : exponent > exp_max() ? exp_max() : exponent;
    return sign << (exp_bits_ + frac_bits_) | static_cast<std::uint32_t>(clamped) << frac_bits_ |
           (fraction & frac_mask());
  }

  /// A random sign and fraction.
  std::uint32_t any_with(int exponent) {
    const std::uint32_t sign = below(2);
    return pack(sign, exponent, fraction());
  }

  /// Random bits, or few ones, or few zeros at either end.
  std::uint32_t fraction() {
    const auto bits = static_cast<std::uint32_t>(random());
    const int place = static_cast<int>(below(frac_bits_ + 1));
    switch (below(5)) {
      case 0:
        return bits << place;
      case 1:
        return 1u << place;
      case 2:
        return (1u << place) - 1;
      case 3:
        return ~((1u << place) - 1);
      default:
        return bits;
    }
  }

  /// Zeros, ends of the subnormal and normal ranges, one and its neighbours, infinities, NaNs.
  std::uint32_t special() {
    const int bias = (1 << (exp_bits_ - 1)) - 1;
    const std::array<int, 9> exponents = {0,        1,        bias - 1,      bias,     bias + 1,
                                          bias + 2, 2 * bias, exp_max() - 1, exp_max()};
    const std::array<std::uint32_t, 6> fractions = {
        0, 1, 2, 1u << (frac_bits_ - 1), frac_mask() - 1, frac_mask()};
    const std::uint32_t sign = below(2);
    const int exponent = exponents[below(9)];
    return pack(sign, exponent, fractions[below(6)]);
  }

  std::uint32_t value(std::uint32_t kind) {
    switch (kind) {
      case 0:
        return special();
      case 1:  // subnormal, or least normal
        return any_with(static_cast<int>(below(2)));
      case 2:
        return uniform();
      default:
        return any_with(static_cast<int>(below(exp_max())));
    }
  }

  std::pair<std::uint32_t, std::uint32_t> ordered(std::uint32_t a, std::uint32_t b) {
    return below(2) != 0 ? std::pair{a, b} : std::pair{b, a};
  }

  int exp_bits_;
  int frac_bits_;
  std::uint64_t state_;
};

}  // namespace ti::test
