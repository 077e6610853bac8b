// SPDX-License-Identifier: Apache-2.0
// The signs of Woop's edge functions: what Gappa has no theorem for, tried in full.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
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

using Single = Fp<8, 23>;

/// A corner in the plane z = 3.
Vec3<Single> corner(double x, double y) {
  return {Single::from_double(x), Single::from_double(y), Single::from_double(3.0)};
}

/// The ray along z from the origin.
std::optional<model::Edges<Single>> edges_of(const std::array<Vec3<Single>, 3>& triangle) {
  const Single one = Single::from_double(1.0);
  return model::edge_functions(triangle, Vec3<Single>{}, {.z = 2, .sx = {}, .sy = {}, .sz = one});
}
std::optional<model::Candidate<Single>> hit_of(const std::array<Vec3<Single>, 3>& triangle) {
  const auto edges = edges_of(triangle);
  return edges ? model::pass_c(*edges, Single::from_double(1.0)) : std::nullopt;
}

TEST_CASE("signs: a needle as wide as an ulp is hit from beyond its end") {
  // It points at the ray, and its nearer end is 2.2 away: the errors of corners do not bound how
  // far from its outline a triangle is hit whose products round to the same number.
  const std::array<Vec3<Single>, 3> needle{corner(0x1.8bb342p+1, 0x1.38da8cp+1),
                                           corner(0x1.b9fa2cp+0, 0x1.5d711cp+0),
                                           corner(0x1.b9fa2cp+0, 0x1.5d711ep+0)};
  const auto edges = edges_of(needle);
  REQUIRE(edges);
  CHECK(edges->weight[1].is_zero());
  CHECK(edges->weight[2].is_zero());
  const auto hit = hit_of(needle);
  REQUIRE(hit);
  CHECK(hit->t.to_double() == 3.0);
}

TEST_CASE("signs: a needle with three false zeros is missed, and a neighbour is hit in its place") {
  // The ray meets it: the exact weights are -1.5e-7, -1.2e-7 and -8.7e-9.
  const Vec3<Single> a = corner(0x1.c97afap+0, 0x1.ca3808p+0);
  const Vec3<Single> b = corner(-0x1.1f9032p+1, -0x1.200708p+1);
  const Vec3<Single> c = corner(-0x1.486cdp+0, -0x1.48f48ap+0);
  const auto edges = edges_of({a, b, c});
  REQUIRE(edges);
  for (const Single weight : edges->weight) CHECK(weight.is_zero());
  CHECK(!hit_of({a, b, c}));
  // Across its long edge, on either side.
  CHECK(hit_of({b, a, corner(3.0, -3.0)}));
  CHECK(hit_of({b, a, corner(-3.0, 3.0)}));
}

}  // namespace
}  // namespace ti
