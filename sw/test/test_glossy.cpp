// SPDX-License-Identifier: Apache-2.0
// The glossy lobe is drawn with the density that it states, from a mirror's smoothness on.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "base/vec.hpp"
#include "render/lobes.hpp"
#include "render/sampler.hpp"
#include "scene/random.hpp"

namespace ti {
namespace {

constexpr double kPi = 3.14159265358979323846;

Material glossy(float alpha) {
  return {.diffuse = glm::vec3(0.0F), .specular = glm::vec3(1.0F), .roughness = alpha};
}

/// Axes of a surface that lies askew.
struct Frame {
  glm::dvec3 n = glm::normalize(glm::dvec3(-0.4, 0.7, -0.3));
  glm::dvec3 s = glm::normalize(glm::cross(n, glm::dvec3(0.0, 0.0, 1.0)));
  glm::dvec3 t = glm::cross(n, s);

  /// The direction of this cosine with the normal and this angle about it.
  [[nodiscard]] glm::dvec3 at(double z, double phi) const {
    const double r = std::sqrt(1.0 - z * z);
    return z * n + r * std::cos(phi) * s + r * std::sin(phi) * t;
  }
  [[nodiscard]] Place seen_at(double cosine) const {
    return {.normal = n, .to_eye = at(cosine, 0.3)};
  }
};

/// Pearson's statistic of directions drawn, over boxes of equal solid angle and the draws that give
/// none, in standard deviations above its mean.
double surprise(const Material& material, const Place& place, const Frame& frame) {
  constexpr int kRings = 16;
  constexpr int kSectors = 16;
  constexpr int kInner = 24;
  constexpr int kDraws = 1 << 16;
  std::vector<double> expected(kRings * kSectors + 1, 0.0);
  std::vector<double> seen(expected.size(), 0.0);
  double inside = 0.0;
  for (int i = 0; i < kRings * kInner; ++i) {
    for (int j = 0; j < kSectors * kInner; ++j) {
      const glm::dvec3 d = frame.at((i + 0.5) / (kRings * kInner),
                                    2.0 * kPi * (j + 0.5) / (kSectors * kInner) - kPi);
      const double share = density(Lobe::Glossy, material, place, d) * 2.0 * kPi /
                           (kRings * kInner * kSectors * kInner);
      const int box = i / kInner * kSectors + j / kInner;
      expected[static_cast<std::size_t>(box)] += kDraws * share;
      inside += share;
    }
  }
  expected.back() = kDraws * std::max(0.0, 1.0 - inside);
  Random random(1, 0);
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.uniform();
    const double y = random.uniform();
    const auto s = scatter(Lobe::Glossy, material, place, {x, y}, 0.0);
    if (!s) {
      ++seen.back();
      continue;
    }
    const double z = glm::dot(s->direction, frame.n);
    const double phi = std::atan2(glm::dot(s->direction, frame.t), glm::dot(s->direction, frame.s));
    const int ring = std::min(kRings - 1, static_cast<int>(z * kRings));
    const int sector =
        std::min(kSectors - 1, static_cast<int>((phi + kPi) / (2.0 * kPi) * kSectors));
    ++seen[static_cast<std::size_t>(ring * kSectors + sector)];
  }
  // Boxes of few draws count together.
  double statistic = 0.0;
  double few_expected = 0.0;
  double few_seen = 0.0;
  int boxes = 0;
  const auto add = [&](double mean, double count) {
    statistic += (count - mean) * (count - mean) / mean;
    ++boxes;
  };
  for (std::size_t k = 0; k < expected.size(); ++k) {
    if (expected[k] >= 8.0) {
      add(expected[k], seen[k]);
    } else {
      few_expected += expected[k];
      few_seen += seen[k];
    }
  }
  if (few_expected >= 8.0)
    add(few_expected, few_seen);
  else
    CHECK(few_seen < 40.0);
  return (statistic - (boxes - 1)) / std::sqrt(2.0 * (boxes - 1));
}

TEST_CASE("glossy: directions fall where their density says") {
  const Frame frame;
  for (const float alpha : {0.25F, 0.5F, 1.0F}) {
    for (const double cosine : {1.0, 0.7, 0.3, 0.05}) {
      CAPTURE(alpha);
      CAPTURE(cosine);
      CHECK(surprise(glossy(alpha), frame.seen_at(cosine), frame) < 5.0);
    }
  }
}

TEST_CASE("glossy: a smooth surface's density is as exact as a rough one's") {
  // Seen from above, with the half vector as far from the normal as its tangent, times alpha, says:
  // D = 1 / (pi alpha^2 cos^4 (1 + tan^2 / alpha^2)^2), over 4 for the reflection, with a G1 of 1.
  const Frame frame;
  const Place place = frame.seen_at(1.0);
  for (const float alpha : {1e-7F, 1e-6F, 1e-5F, 1e-4F, 1e-3F}) {
    for (const double tangent : {0.5, 1.0, 3.0}) {
      CAPTURE(alpha);
      CAPTURE(tangent);
      const double angle = std::atan(tangent * alpha);
      const glm::dvec3 half = std::cos(angle) * frame.n + std::sin(angle) * frame.s;
      const glm::dvec3 light = 2.0 * glm::dot(half, frame.n) * half - frame.n;
      const double expected = std::pow(1.0 + tangent * tangent, -2.0) /
                              (4.0 * kPi * double(alpha) * alpha * std::pow(std::cos(angle), 4.0));
      CHECK(density(Lobe::Glossy, glossy(alpha), place, light) ==
            doctest::Approx(expected).epsilon(1e-6));
    }
  }
}

TEST_CASE("glossy: any roughness gives numbers, and the smoothest reflect as a mirror does") {
  const Frame frame;
  // 2^-26 is where the square of alpha is a unit in the last place of 1.
  for (const float alpha : {1e-45F, 1e-38F, 1e-20F, 1e-16F, 1e-12F, 1e-9F, 0x1p-26F, 2.1073424e-8F,
                            0x1p-25F, 1e-7F, 1e-6F, 1e-5F, 1e-4F, 1e-3F, 0.1F, 1.0F}) {
    for (const double cosine : {1.0, 1.0 - 1e-15, 0.9, 0.3, 1e-3, 1e-6, 1e-9, 1e-12, 0.0}) {
      CAPTURE(alpha);
      CAPTURE(cosine);
      const Material material = glossy(alpha);
      const Place place = frame.seen_at(cosine);
      const glm::dvec3 mirrored = 2.0 * cosine * place.normal - place.to_eye;
      REQUIRE(finite(evaluate(Lobe::Glossy, material, place, mirrored)));
      REQUIRE(std::isfinite(density(Lobe::Glossy, material, place, mirrored)));
      for (const double edge : {0.0, 0x1p-32, 0.5, 1.0 - 0x1p-32}) {
        for (std::uint32_t i = 0; i < 16; ++i) {
          const glm::dvec2 u = Sampler(2, 0, i).get2({0, Purpose::Glossy});
          for (const glm::dvec2& drawn : {glm::dvec2(edge, u.x), glm::dvec2(u.x, edge), u}) {
            const auto s = scatter(Lobe::Glossy, material, place, drawn, 0.0);
            if (!s) continue;
            REQUIRE(finite(s->direction));
            REQUIRE(glm::length(s->direction) == doctest::Approx(1.0).epsilon(1e-12));
            REQUIRE(finite(s->weight));
            REQUIRE(s->weight.x <= 1.0 + 1e-9);
            REQUIRE(std::isfinite(s->density));
            REQUIRE(s->density > 0.0);
            // But for the one draw in 2^32 whose normal lies in the surface.
            if (alpha <= 1e-6F && cosine > 0.1 && drawn == u) {
              REQUIRE(s->weight.x == doctest::Approx(1.0).epsilon(1e-4));
              REQUIRE(glm::dot(s->direction, mirrored) == doctest::Approx(1.0).epsilon(1e-6));
            }
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace ti
