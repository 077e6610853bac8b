// SPDX-License-Identifier: Apache-2.0

// What leans on the error of an operation, for every number of small formats in every mode.

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "base/format.hpp"
#include "model/fp.hpp"
#include "model/ist1.hpp"
#include "model/ist2.hpp"
#include "model/rd.hpp"

namespace ti {
namespace {

/// `claim()` in the scope of each small format and mode.
template <typename Claim>
void in_all_modes(Claim claim) {
  for (const auto& [e, m] : {std::pair{3, 2}, std::pair{3, 4}, std::pair{4, 3}}) {
    for (const bool toward_zero : {false, true}) {
      for (const bool flush : {false, true}) {
        const Format format{e, m, {.toward_zero = toward_zero, .flush = flush}};
        CAPTURE(name_of(format));
        const FpRules rules(format);
        const FormatScope scope(rules);
        claim();
      }
    }
  }
}

/// All numbers greater than 0, infinity included; without those that an engine flushes.
std::vector<AnyFp> positive() {
  std::vector<AnyFp> all;
  for (std::uint32_t bits = 1; bits <= AnyFp::kInfBits; ++bits) {
    if (!AnyFp::from_bits(bits).is_zero()) all.push_back(AnyFp::from_bits(bits));
  }
  return all;
}

TEST_CASE("modes: pass (a) drops a test only where its t lies outside the range for certain") {
  in_all_modes([] {
    const std::vector<AnyFp> numbers = positive();
    int wrong = 0;
    int dropped = 0;
    for (const AnyFp det : numbers) {
      if (!det.is_finite()) continue;
      for (const AnyFp dett : numbers) {
        if (!dett.is_finite()) continue;
        // A plane across the ray: det = d_w, dett = p_w.
        ImagePlane plane{};
        plane.pw = dett.bits();
        plane.axis = 2;
        const Vec3<AnyFp> o{};
        const Vec3<AnyFp> d{AnyFp{}, AnyFp{}, det};
        const auto c = model::pass_c(model::AfterB<AnyFp>{det, dett, AnyFp{}, AnyFp{}});
        for (const AnyFp end : numbers) {
          if (!model::pass_a<TestKind::Local, AnyFp>(plane, o, d, {AnyFp{}, end})) {
            ++dropped;
            wrong += c && c->t <= end;
          }
          if (!model::pass_a<TestKind::Local, AnyFp>(plane, o, d,
                                                     {end, AnyFp::from_bits(AnyFp::kInfBits)})) {
            ++dropped;
            wrong += !(dett.to_double() < end.to_double() * det.to_double());
          }
        }
      }
    }
    CHECK(wrong == 0);
    CHECK(dropped > 1000);
  });
}

TEST_CASE("modes: the t of a plane, moved outward, is not before the plane") {
  in_all_modes([] {
    const std::vector<AnyFp> numbers = positive();
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

}  // namespace
}  // namespace ti
