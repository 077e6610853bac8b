// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "base/format.hpp"
#include "model/fp.hpp"

using ti::Format;
using ti::Fp;
using ti::round_to_bits;
using ti::value_of_bits;

namespace {

using Wide = __int128;
using Single = Fp<8, 23>;

/// The image of (-1)^negative * `value` / 2^`scale` in the modes of the format, found by integers
/// alone. A value that is a little more than `value` (less than one unit) is told by `more`.
std::uint32_t rounded(Format format, bool negative, Wide value, int scale, bool more = false) {
  const std::uint32_t sign = negative ? 1u << (format.exp_bits + format.frac_bits) : 0u;
  const std::uint32_t inf = ((1u << format.exp_bits) - 1) << format.frac_bits;
  const std::uint32_t least = 1u << format.frac_bits;
  const bool flush = format.modes.flush;
  // Walk from the subnormals up until the fraction fits; 2 bits below the unit tell the rounding.
  // What is flushed and yet might round to the least normal number has its units at field 0.
  for (int field = flush ? 0 : 1; field < (1 << format.exp_bits) - 1; ++field) {
    const int unit = field - format.bias() - format.frac_bits;  // log2
    const int drop = unit + scale - 2;
    Wide quarters = value;
    bool rest = more;
    if (drop > 0) {
      const int shift = drop < 126 ? drop : 126;
      quarters = value >> shift;
      rest = rest || (quarters << shift) != value;
    } else {
      if (-drop > 64) return sign | inf;  // not met by the cases of this file
      quarters = value << -drop;
    }
    const Wide units = quarters >> 2;
    if (units >= (Wide{1} << (format.frac_bits + 1))) continue;
    const int part = static_cast<int>(quarters & 3);
    const bool up =
        !format.modes.toward_zero && (part == 3 || (part == 2 && (rest || (units & 1) != 0)));
    const auto steps = static_cast<std::uint32_t>(units) + (up ? 1u : 0u);
    if (field == 0) return steps == 2 * least ? sign | least : sign;
    const auto base = static_cast<std::uint32_t>(field - 1) << format.frac_bits;
    return flush && base + steps < least ? sign : sign | (base + steps);
  }
  return sign | (format.modes.toward_zero ? inf - 1 : inf);
}

/// A finite value as an integer number of least subnormals.
struct Quanta {
  bool negative;
  Wide magnitude;
};

Quanta quanta(Format format, std::uint32_t bits) {
  const auto field = static_cast<int>((bits >> format.frac_bits) & ((1u << format.exp_bits) - 1));
  Wide magnitude = bits & ((1u << format.frac_bits) - 1);
  if (field > 0) magnitude = (magnitude | (Wide{1} << format.frac_bits)) << (field - 1);
  if (field == 0 && format.modes.flush) magnitude = 0;
  return {(bits >> (format.exp_bits + format.frac_bits)) != 0, magnitude};
}

/// Of `F`, which has that format.
template <class F>
void check_all_finite_pairs(Format format) {
  CAPTURE(ti::name_of(format));
  const int scale = format.bias() - 1 + format.frac_bits;  // a quantum is 2^-scale
  const std::uint32_t count = 1u << format.width();
  int differences = 0;
  for (std::uint32_t a = 0; a < count; ++a) {
    const F x = F::from_bits(a);
    if (!x.is_finite()) continue;
    const Quanta qa = quanta(format, a);
    const Wide va = qa.negative ? -qa.magnitude : qa.magnitude;
    if (va != 0) {
      const Wide one = Wide{1} << 100;
      differences += reciprocal(x).bits() != rounded(format, qa.negative, one / qa.magnitude,
                                                     100 - scale, one % qa.magnitude != 0);
    }
    for (std::uint32_t b = 0; b < count; ++b) {
      const F y = F::from_bits(b);
      if (!y.is_finite()) continue;
      const Quanta qb = quanta(format, b);
      const Wide vb = qb.negative ? -qb.magnitude : qb.magnitude;
      const Wide sum = va + vb;
      const bool sum_negative = sum < 0 || (sum == 0 && qa.negative && qb.negative);
      differences += (x + y).bits() != rounded(format, sum_negative, sum < 0 ? -sum : sum, scale);
      differences += (x - y).bits() != (x + -y).bits();
      differences += (x * y).bits() != rounded(format, qa.negative != qb.negative,
                                               qa.magnitude * qb.magnitude, 2 * scale);
      differences += (x < y) != (va < vb);
      differences += (x <= y) != (va <= vb);
      differences += (x == y) != (va == vb);
    }
  }
  CHECK(differences == 0);
}

/// In all modes, as a format that is compiled and as one that is known at run time.
template <int E, int M, bool kZero = false, bool kFlush = false>
void check_all_modes() {
  constexpr Format kFormat{E, M, {.toward_zero = kZero, .flush = kFlush}};
  check_all_finite_pairs<Fp<E, M, kFormat.modes>>(kFormat);
  const ti::FpRules rules(kFormat);
  const ti::FormatScope scope(rules);
  check_all_finite_pairs<ti::AnyFp>(kFormat);
  if constexpr (!kZero) check_all_modes<E, M, true, kFlush>();
  if constexpr (!kZero && !kFlush) check_all_modes<E, M, false, true>();
}

std::uint32_t add(std::uint32_t a, std::uint32_t b) {
  return (Single::from_bits(a) + Single::from_bits(b)).bits();
}
std::uint32_t mul(std::uint32_t a, std::uint32_t b) {
  return (Single::from_bits(a) * Single::from_bits(b)).bits();
}
std::uint32_t rcp(std::uint32_t a) { return reciprocal(Single::from_bits(a)).bits(); }

}  // namespace

TEST_CASE("small formats agree with integer arithmetic on every finite pair in every mode") {
  check_all_modes<3, 2>();
  check_all_modes<3, 4>();
  check_all_modes<4, 3>();
}

TEST_CASE("binary32 corners of the sum") {
  CHECK(add(0x3f800000, 0xbf800000) == 0x00000000);  // x + -x is +0
  CHECK(add(0x80000000, 0x80000000) == 0x80000000);
  CHECK(add(0x80000000, 0x00000000) == 0x00000000);
  CHECK(add(0x3f800000, 0x33800000) == 0x3f800000);  // tie, to even
  CHECK(add(0x3f800001, 0x33800000) == 0x3f800002);  // tie, to even
  CHECK(add(0x3f800000, 0x33800001) == 0x3f800001);
  CHECK(add(0x00800000, 0x80000001) == 0x007fffff);  // into the subnormals
  CHECK(add(0x007fffff, 0x00000001) == 0x00800000);
  CHECK(add(0x7f7fffff, 0x73000000) == 0x7f800000);  // tie at the overflow
  CHECK(add(0x7f7fffff, 0x72ffffff) == 0x7f7fffff);
  CHECK(add(0x7f800000, 0xff800000) == Single::kNanBits);
  CHECK(add(0xffffffff, 0x3f800000) == Single::kNanBits);
}

TEST_CASE("binary32 corners of the product") {
  CHECK(mul(0x00000001, 0x3f000000) == 0x00000000);  // half a quantum, to even
  CHECK(mul(0x00000003, 0x3f000000) == 0x00000002);
  CHECK(mul(0x80000001, 0x3f000001) == 0x80000001);
  CHECK(mul(0x00ffffff, 0x3f000000) == 0x00800000);  // rounds up to the least normal
  CHECK(mul(0x00000001, 0x00000001) == 0x00000000);
  CHECK(mul(0x80000000, 0x40000000) == 0x80000000);
  CHECK(mul(0x7f7fffff, 0x3f800001) == 0x7f800000);
  CHECK(mul(0x00000000, 0xff800000) == Single::kNanBits);
  CHECK(mul(0x00000001, 0x7e800000) == 0x34000000);  // 2^-149 * 2^126
}

TEST_CASE("binary32 corners of the reciprocal") {
  CHECK(rcp(0x00000000) == 0x7f800000);
  CHECK(rcp(0x80000000) == 0xff800000);
  CHECK(rcp(0xff800000) == 0x80000000);
  CHECK(rcp(0x00000001) == 0x7f800000);
  CHECK(rcp(0x00200000) == 0x7f800000);  // 2^-128
  CHECK(rcp(0x00200001) == 0x7f7ffff8);
  CHECK(rcp(0x7f000000) == 0x00400000);  // subnormal result
  CHECK(rcp(0x7f7fffff) == 0x00200000);
  CHECK(rcp(0x40400000) == 0x3eaaaaab);
  CHECK(rcp(0x7fc00001) == Single::kNanBits);
}

TEST_CASE("toward zero, overflow ends at the largest number, and 1/0 is infinite") {
  using F = Fp<8, 23, ti::Modes{.toward_zero = true}>;
  const F largest = F::from_bits(0x7f7fffff);
  CHECK((largest + largest).bits() == 0x7f7fffff);
  CHECK((largest * -largest).bits() == 0xff7fffff);
  CHECK(reciprocal(F::from_bits(0x00000001)).bits() == 0x7f7fffff);
  CHECK(reciprocal(F::from_bits(0x80000000)).bits() == 0xff800000);
  CHECK((F::from_bits(F::kInfBits) + largest).bits() == F::kInfBits);
  CHECK((F::from_bits(0x3f800000) - F::from_bits(0x00000001)).bits() == 0x3f7fffff);
  CHECK((F::from_bits(0x3f800001) * F::from_bits(0x3f800001)).bits() == 0x3f800002);
  CHECK((F::from_double(1.0) - F::from_double(1.0)).bits() == 0);
  CHECK(reciprocal(F::from_bits(0x40400000)).bits() == 0x3eaaaaaa);
  CHECK(F::from_double(2.0 / 3.0).bits() == 0x3f2aaaab);  // what enters is rounded to nearest
}

TEST_CASE("flushed subnormals are zeros of their sign as operands and as results") {
  using F = Fp<8, 23, ti::Modes{.flush = true}>;
  const F tiny = F::from_bits(0x807fffff);
  const F least = F::from_bits(0x00800000);
  CHECK(tiny.is_zero());
  CHECK(tiny == F{});
  CHECK_FALSE(tiny < F{});
  CHECK(tiny.bits() == 0x807fffff);
  CHECK((tiny + tiny).bits() == 0x80000000);
  CHECK((tiny + F{}).bits() == 0);
  CHECK(reciprocal(tiny).bits() == 0xff800000);
  CHECK((tiny * F::from_bits(0x7f800000)).bits() == F::kNanBits);
  CHECK((least * F::from_bits(0x3f7fffff)).bits() == 0);
  CHECK((F::from_bits(0x00ffffff) * F::from_bits(0x3f000000)).bits() == 0);  // 2^-126 - 2^-150
  CHECK((F::from_bits(0x00ffffff) * F::from_bits(0x3f000001)).bits() == 0x00800000);
  CHECK((F::from_bits(0x00800001) - least).bits() == 0);
  CHECK(reciprocal(F::from_bits(0x7e800001)).bits() == 0);
  CHECK(reciprocal(F::from_bits(0x7e800000)).bits() == 0x00800000);
}

TEST_CASE("what enters an engine is flushed by one rule, whoever rounds it") {
  const double least = 0x1p-14;
  for (const bool zero : {false, true}) {
    const Format format{5, 10, {.toward_zero = zero, .flush = true}};
    const ti::FpRules rules(format);
    const ti::FormatScope scope(rules);
    for (const auto& [share, bits] : {std::pair{1.0, 0x400u}, std::pair{1.0 - 0x1p-12, 0x400u},
                                      std::pair{1.0 - 0x1.8p-12, 0u}, std::pair{0x1p-60, 0u}}) {
      CHECK(round_to_bits(format, -share * least) == (bits | 0x8000u));
      CHECK(ti::AnyFp::from_double(-share * least).bits() == (bits | 0x8000u));
    }
    CHECK(value_of_bits(format, 0x83ff) == 0.0);
    CHECK(std::signbit(value_of_bits(format, 0x83ff)));
  }
}

TEST_CASE("every image comes back from its value") {
  int differences = 0;
  for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
    const auto x = Fp<5, 10>::from_bits(bits);
    const std::uint32_t want = x.is_nan() ? Fp<5, 10>::kNanBits : bits;
    differences += x.bits() != want;
    differences += round_to_bits({5, 10}, value_of_bits({5, 10}, bits)) != want;
    differences += Fp<5, 10>::from_double(value_of_bits({5, 10}, bits)).bits() != want;
    differences +=
        Fp<8, 7>::from_bits(bits).bits() != round_to_bits({8, 7}, std::bit_cast<float>(bits << 16));
  }
  CHECK(differences == 0);
}

TEST_CASE("rounding a double agrees with the conversion to float and between the two routes") {
  int differences = 0;
  std::uint64_t state = 1;
  for (int i = 0; i < 1'000'000; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    // Exponents around those of binary32, and fractions near the ties of 23 and 10 bits.
    std::uint64_t image = (state >> 12) | static_cast<std::uint64_t>(860 + state % 310) << 52;
    if ((i & 1) != 0) image = (image & ~std::uint64_t{0x1fffffff}) | 0x10000000u;
    if ((i & 2) != 0) image &= ~std::uint64_t{0x3fffffffff};
    if ((i & 4) != 0) image |= std::uint64_t{1} << 63;
    const double value = std::bit_cast<double>(image);
    differences +=
        round_to_bits({8, 23}, value) != std::bit_cast<std::uint32_t>(static_cast<float>(value));
    differences += round_to_bits({5, 10}, value) != Fp<5, 10>::from_double(value).bits();
    differences += round_to_bits({7, 16}, value) != Fp<7, 16>::from_double(value).bits();
    differences += round_to_bits({8, 12}, value) != Fp<8, 12>::from_double(value).bits();
  }
  CHECK(differences == 0);
  CHECK(round_to_bits({5, 10}, 5e-324) == 0);
  CHECK(round_to_bits({5, 10}, -5e-324) == 0x8000);
  CHECK(round_to_bits({5, 10}, 65519.99) == 0x7bff);
  CHECK(round_to_bits({5, 10}, 65520.0) == 0x7c00);
  CHECK(round_to_bits({5, 10}, -std::numeric_limits<double>::infinity()) == 0xfc00);
  CHECK(round_to_bits({5, 10}, -std::numeric_limits<double>::quiet_NaN()) == 0x7e00);
}

TEST_CASE("NaN is unordered, and -0 equals +0") {
  using F = Fp<7, 16>;
  const F nan = F::from_bits(F::kNanBits | 1);
  const F one = F::from_double(1.0);
  CHECK(nan.is_nan());
  CHECK_FALSE(nan == nan);
  CHECK_FALSE(nan < one);
  CHECK_FALSE(one <= nan);
  CHECK_FALSE((-nan).signbit());
  CHECK(F::from_double(-0.0) == F::from_double(0.0));
  CHECK_FALSE(F::from_double(-0.0) < F::from_double(0.0));
  CHECK(F::from_double(-0.0).signbit());
  CHECK((-one).bits() == (one.bits() | F::kSignBit));
}

TEST_CASE("steps in units of the last place stop at infinity and at zero") {
  CHECK(Single::from_double(1.0).ulps_up(4).bits() == 0x3f800004);
  CHECK(Single::from_double(-1.0).ulps_up(4).bits() == 0xbf800004);
  CHECK(Single::from_bits(0x7f7ffffe).ulps_up(4).bits() == 0x7f800000);
  CHECK(Single::from_bits(0xff7ffffe).ulps_up(0xffffffff).bits() == 0xff800000);
  CHECK(Single::from_bits(0x7f800000).ulps_up(1).bits() == 0x7f800000);
  CHECK(Single::from_bits(0x00800000).ulps_down(1).bits() == 0x007fffff);
  CHECK(Single::from_bits(0x80000003).ulps_down(4).bits() == 0x80000000);
  CHECK(Single::from_bits(0x7f800000).ulps_down(1).bits() == 0x7f7fffff);
  CHECK(Single::from_bits(Single::kNanBits).ulps_up(1).bits() == Single::kNanBits);
  CHECK(Fp<5, 10>::from_bits(0x03ff).ulps_up(1).bits() == 0x0400);
  CHECK(Fp<5, 10>::from_bits(0x7bff).ulps_up(1).bits() == 0x7c00);
}
