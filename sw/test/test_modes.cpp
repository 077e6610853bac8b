// SPDX-License-Identifier: Apache-2.0

// What leans on the error of an operation, for every number of small formats in every mode.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "base/format.hpp"
#include "cull_claim.hpp"
#include "model/fp.hpp"
#include "model/rd.hpp"

namespace ti {
namespace {

/// `claim()` in the scope of each small format and mode, and of each reciprocal that is allowed.
template <typename Claim>
void in_all_modes(Claim claim) {
  for (const auto& [e, m] : {std::pair{3, 2}, std::pair{4, 3}}) {
    for (int mode = 0; mode < 4; ++mode) {
      for (const auto& [k, steps] : {std::pair{0, 0}, std::pair{m, 1}, std::pair{2, 2}}) {
        const Format format{e,
                            m,
                            {.toward_zero = (mode & 1) != 0,
                             .flush = (mode & 2) != 0,
                             .rcp_table_bits = k,
                             .rcp_newton_steps = steps}};
        const int half_ulps = format.reciprocal_half_ulps();
        if (half_ulps * half_ulps > 2 << m) continue;  // `scripts/configure.py` refuses it
        if (k > 0 && format.modes.flush) continue;     // the one has no part in the other
        CAPTURE(name_of(format));
        const FpRules rules(format);
        const FormatScope scope(rules);
        claim();
      }
    }
  }
}

TEST_CASE("modes: pass (a) drops a test only where its t lies outside the range for certain") {
  in_all_modes([] {
    const Drops drops = wrong_drops<AnyFp>();
    CHECK(drops.wrong == 0);
    CHECK(drops.dropped > 1000);
  });
}

TEST_CASE("modes: the t of a plane, moved outward, is not before the plane") {
  in_all_modes([] {
    const std::vector<AnyFp> numbers = positive<AnyFp>();
    const double least = std::ldexp(1.0, 1 - AnyFp::kBias);
    // An inverse out of range may be the largest number: it is no rounding of its own.
    const auto is_normal = [&](AnyFp x) {
      return x.bits() < AnyFp::kInfBits - 1 && !(x.to_double() < least);
    };
    int wrong = 0;
    int looked = 0;
    for (const AnyFp plane : numbers) {
      for (const AnyFp o : numbers) {
        const AnyFp way = plane - o;
        if (!is_normal(way)) continue;
        const double exact = plane.to_double() - o.to_double();
        for (const AnyFp d : numbers) {
          const AnyFp inverse = reciprocal(d);
          const AnyFp t = way * inverse;
          if (!is_normal(inverse) || !is_normal(t)) continue;
          ++looked;
          const std::uint32_t n = model::outward_ulps<AnyFp>();
          wrong += t.ulps_up(n).to_double() * d.to_double() < exact;
          wrong += t.ulps_down(n).to_double() * d.to_double() > exact;
        }
      }
    }
    CHECK(wrong == 0);
    CHECK(looked > 1000);
  });
}

/// The worst error of reciprocals by Newton steps, in units in the last place, as `docs/fp.md` has
/// it.
struct Measured {
  int frac_bits, table_bits, steps;
  double nearest, zero;
};
constexpr Measured kMeasured[] = {
    {10, 10, 0, 1.434, 1.434}, {10, 7, 1, 0.714, 1.217},  {13, 7, 1, 1.048, 1.516},
    {16, 7, 1, 4.482, 4.777},  {16, 8, 1, 1.587, 2.017},  {16, 10, 1, 0.756, 1.277},
    {16, 5, 2, 0.750, 1.241},  {20, 10, 1, 1.654, 2.157}, {20, 7, 2, 0.750, 1.248},
    {23, 12, 1, 1.246, 1.782}, {23, 10, 1, 8.945, 9.486}, {23, 7, 2, 0.750, 1.248},
};

/// Over every `stride`-th significand.
double worst_error(const Format& format, std::uint32_t stride) {
  const FpRules rules(format);
  const FormatScope scope(rules);
  const std::uint32_t one = static_cast<std::uint32_t>(format.bias()) << format.frac_bits;
  double worst = 0.0;
  for (std::uint32_t fraction = 0; fraction < 1U << format.frac_bits; fraction += stride) {
    const AnyFp x = AnyFp::from_bits(one | fraction);
    // Both are exact: the product has at most 48 bits, and what is left of it is near 0.
    const double relative = reciprocal(x).to_double() * x.to_double() - 1.0;
    const double unit = std::ldexp(1.0, -format.frac_bits - 1);  // of the inverse, in [1/2, 1)
    worst = std::max(worst, std::abs(relative) / x.to_double() / unit);
  }
  return worst;
}

/// Every significand of up to `most` bits, 2^16 of longer ones.
void check_measured(int most) {
  for (const Measured& m : kMeasured) {
    for (const bool toward_zero : {false, true}) {
      const Format format{8,
                          m.frac_bits,
                          {.toward_zero = toward_zero,
                           .rcp_table_bits = m.table_bits,
                           .rcp_newton_steps = m.steps}};
      CAPTURE(name_of(format));
      const bool all = m.frac_bits <= most;
      const double worst = worst_error(format, all ? 1 : (1U << (m.frac_bits - 16)) - 1);
      const double measured = toward_zero ? m.zero : m.nearest;
      INFO("worst error " << worst << ", bound " << format.reciprocal_half_ulps() / 2);
      CHECK(worst <= measured);
      CHECK((!all || worst > measured - 0.001));
      CHECK(2.0 * measured <= format.reciprocal_half_ulps());
      CHECK(2.0 * measured > format.reciprocal_half_ulps() - 6);
    }
  }
}

/// No estimate of a format of up to `most` bits of fraction leaves [1/2, 1), in which the RTL holds
/// it.
void check_range(int most) {
  std::uint64_t wrong = 0;
  for (int m = 2; m <= most; ++m) {
    for (int k = 1; k <= std::min(m, 12); ++k) {
      for (int mode = 0; mode < 6; ++mode) {
        const FpRules rules(
            {8,
             m,
             {.toward_zero = mode % 2 != 0, .rcp_table_bits = k, .rcp_newton_steps = mode / 2}});
        for (std::uint64_t fraction = 1; fraction < 1U << m; ++fraction)
          wrong += rules.inverse(fraction) >> (m + 2) != 1;
      }
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("modes: reciprocals by Newton steps are as good as they were measured") {
  check_measured(16);
  check_range(13);
}

TEST_CASE("modes: the same for every significand" * doctest::skip()) {
  check_measured(23);
  check_range(23);
}

}  // namespace
}  // namespace ti
