// SPDX-License-Identifier: Apache-2.0
// The signs of Woop's edge functions: what Gappa has no theorem for, tried in full.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/format.hpp"
#include "model/fp.hpp"
#include "model/woop_test.hpp"

namespace ti {
namespace {

/// All finite numbers of the format in whose scope this runs; without those that an engine flushes.
std::vector<AnyFp> all_finite() {
  std::vector<AnyFp> all;
  for (std::uint32_t bits = 0; bits <= (AnyFp::kSignBit | AnyFp::kInfBits); ++bits) {
    const AnyFp x = AnyFp::from_bits(bits);
    const bool flushed = x.is_zero() && (bits & ~AnyFp::kSignBit) != 0;
    if (x.is_finite() && !flushed) all.push_back(x);
  }
  return all;
}

TEST_CASE("signs: a rounded product less another never has the wrong sign") {
  // A product of two numbers of these formats is exact in double.
  for (const auto& [e, m] : {std::pair{3, 2}, std::pair{4, 3}, std::pair{3, 4}, std::pair{5, 4}}) {
    for (int mode = 0; mode < 4; ++mode) {
      const Format format{e, m, {.toward_zero = (mode & 1) != 0, .flush = (mode & 2) != 0}};
      CAPTURE(name_of(format));
      const FpRules rules(format);
      const FormatScope scope(rules);
      const std::vector<AnyFp> numbers = all_finite();

      // Products in the order of their exact values have rounded values in that order ...
      std::vector<std::pair<double, double>> products;
      for (const AnyFp a : numbers) {
        for (const AnyFp b : numbers)
          products.emplace_back(a.to_double() * b.to_double(), (a * b).to_double());
      }
      std::sort(products.begin(), products.end());
      std::uint64_t wrong = 0;
      for (std::size_t i = 1; i < products.size(); ++i) {
        wrong += products[i].second < products[i - 1].second;
        wrong += products[i].first == products[i - 1].first &&
                 products[i].second != products[i - 1].second;
      }
      CHECK(wrong == 0);

      // ... and a difference of two numbers has their order, or is a zero.
      std::uint64_t false_zeros = 0;
      for (const AnyFp x : numbers) {
        for (const AnyFp y : numbers) {
          const AnyFp difference = x - y;
          wrong += x.to_double() >= y.to_double() && difference < AnyFp{};
          wrong += x.to_double() <= y.to_double() && difference > AnyFp{};
          false_zeros += x.to_double() != y.to_double() && difference.is_zero();
        }
      }
      CHECK(wrong == 0);
      CHECK((false_zeros > 0) == format.modes.flush);
    }
  }
}

TEST_CASE("signs: a needle as wide as an ulp is hit from beyond its end") {
  // It points at the ray, and its nearer end is 2.2 away: the errors of corners do not bound how
  // far from its outline a triangle is hit whose products round to the same number.
  using F = Fp<8, 23>;
  const auto at = [](double x, double y) {
    return Vec3<F>{F::from_double(x), F::from_double(y), F::from_double(3.0)};
  };
  const std::array<Vec3<F>, 3> needle{at(0x1.8bb342p+1, 0x1.38da8cp+1),
                                      at(0x1.b9fa2cp+0, 0x1.5d711cp+0),
                                      at(0x1.b9fa2cp+0, 0x1.5d711ep+0)};
  const F one = F::from_double(1.0);
  const auto edges =
      model::edge_functions(needle, Vec3<F>{}, {.z = 2, .sx = {}, .sy = {}, .sz = one});
  REQUIRE(edges);
  CHECK(edges->weight[1].is_zero());
  CHECK(edges->weight[2].is_zero());
  const auto hit = model::pass_c(*edges, one);
  REQUIRE(hit);
  CHECK(hit->t.to_double() == 3.0);
}

}  // namespace
}  // namespace ti
