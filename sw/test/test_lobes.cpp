// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>

#include "base/vec.hpp"
#include "render/lobes.hpp"
#include "render/sampler.hpp"

namespace ti {
namespace {

constexpr double kPi = 3.14159265358979323846;

Material matt(float albedo) { return {.diffuse = glm::vec3(albedo)}; }
Material glossy(float alpha, float f0 = 1.0F, float schlick = 0.0F) {
  return {.diffuse = glm::vec3(0.0F),
          .specular = glm::vec3(f0),
          .schlick = schlick,
          .roughness = alpha};
}
Material mirror(float f0) { return {.diffuse = glm::vec3(0.0F), .specular = glm::vec3(f0)}; }
Material glass(float ior, float tint = 1.0F) {
  return {.diffuse = glm::vec3(0.0F), .transmission = glm::vec3(tint), .ior = ior};
}

/// A place whose normal is none of the axes, seen at an angle whose cosine is given.
Place place_at(double cosine) {
  const glm::dvec3 n = glm::normalize(glm::dvec3(1.0, -2.0, 0.5));
  const glm::dvec3 t = glm::normalize(glm::cross(n, glm::dvec3(0.0, 0.0, 1.0)));
  return {.normal = n, .to_eye = glm::normalize(cosine * n + std::sqrt(1.0 - cosine * cosine) * t)};
}

/// Mean of `value(u, choice)` over `count` points.
template <typename Value>
glm::dvec3 mean(int count, const Value& value) {
  glm::dvec3 sum(0.0);
  for (int i = 0; i < count; ++i) {
    const Sampler sampler(1, 0, static_cast<std::uint32_t>(i));
    sum += value(sampler.get2({0, Purpose::Diffuse}), sampler.get1({0, Purpose::Glass}));
  }
  return sum / static_cast<double>(count);
}

/// The share of light from everywhere that comes to the eye, by drawing directions.
double albedo(Lobe lobe, const Material& material, const Place& place) {
  return mean(4096,
              [&](const glm::dvec2& u, double choice) {
                const auto s = scatter(lobe, material, place, u, choice);
                return s ? s->weight : glm::dvec3(0.0);
              })
      .x;
}

/// An integral over the hemisphere of the normal, by uniform directions.
template <typename Value>
double over_hemisphere(const Place& place, const Value& value) {
  const glm::dvec3 t = glm::normalize(glm::cross(place.normal, glm::dvec3(0.3, 0.2, 0.9)));
  const glm::dvec3 b = glm::cross(place.normal, t);
  double sum = 0.0;
  constexpr int kRings = 1200;
  constexpr int kSteps = 600;
  for (int i = 0; i < kRings; ++i) {
    const double z = (i + 0.5) / kRings;
    const double r = std::sqrt(1.0 - z * z);
    for (int j = 0; j < kSteps; ++j) {
      const double phi = 2.0 * kPi * (j + 0.5) / kSteps;
      sum += value(z * place.normal + r * std::cos(phi) * t + r * std::sin(phi) * b);
    }
  }
  return sum * 2.0 * kPi / (static_cast<double>(kRings) * kSteps);
}

TEST_CASE("lobes: white surfaces give back all light, and none more than it gets") {
  for (const double cosine : {1.0, 0.7, 0.2, 0.01}) {
    const Place place = place_at(cosine);
    CHECK(albedo(Lobe::Diffuse, matt(1.0F), place) == doctest::Approx(1.0));
    CHECK(albedo(Lobe::Mirror, mirror(1.0F), place) == doctest::Approx(1.0));
    CHECK(albedo(Lobe::Glass, glass(1.0F), place) == doctest::Approx(1.0));
    for (const float alpha : {0.01F, 0.1F, 0.3F, 0.6F, 1.0F}) {
      const double share = albedo(Lobe::Glossy, glossy(alpha), place);
      CHECK(share <= 1.0 + 1e-9);
      // Single scattering loses up to two thirds of it, and nothing where the surface is smooth.
      CHECK(share > (alpha <= 0.01F && cosine > 0.1 ? 0.99 : 0.3));
    }
  }
}

TEST_CASE("lobes: the roughest surface, seen from above, reflects 1 - ln 2") {
  // Its D is 1 / pi and its masking 2 c / (1 + c), so the integral over c is that of c / (1 + c).
  CHECK(albedo(Lobe::Glossy, glossy(1.0F), place_at(1.0)) ==
        doctest::Approx(1.0 - std::log(2.0)).epsilon(1e-3));
}

TEST_CASE("lobes: light that is not radiance but power is kept by glass") {
  // Radiance through the surface is divided by the square of the index; times it, all is there.
  for (const bool entering : {true, false}) {
    Place place = place_at(0.9);
    place.entering = entering;
    const Material material = glass(1.5F);
    const double index = entering ? 1.5 : 1.0 / 1.5;
    const double sum = mean(1 << 14, [&](const glm::dvec2& u, double choice) {
                         const auto s = scatter(Lobe::Glass, material, place, u, choice);
                         const bool through = glm::dot(s->direction, place.normal) < 0.0;
                         return s->weight * (through ? index * index : 1.0);
                       }).x;
    CHECK(sum == doctest::Approx(1.0));
  }
}

TEST_CASE("lobes: densities add up to one and weights are value over density") {
  for (const double cosine : {0.95, 0.4}) {
    const Place place = place_at(cosine);
    for (const Material& material : {glossy(0.3F), glossy(0.7F, 0.4F, 1.0F)}) {
      const double sum = over_hemisphere(
          place, [&](const glm::dvec3& d) { return density(Lobe::Glossy, material, place, d); });
      // Directions below the surface are missing; the sample count that is lost says how many.
      const double kept =
          mean(1 << 14, [&](const glm::dvec2& u, double choice) {
            return glm::dvec3(scatter(Lobe::Glossy, material, place, u, choice) ? 1.0 : 0.0);
          }).x;
      CHECK(sum == doctest::Approx(kept).epsilon(0.01));
      const double by_value = over_hemisphere(
          place, [&](const glm::dvec3& d) { return evaluate(Lobe::Glossy, material, place, d).x; });
      CHECK(by_value == doctest::Approx(albedo(Lobe::Glossy, material, place)).epsilon(0.01));
    }
    const Material material = matt(0.6F);
    CHECK(over_hemisphere(place, [&](const glm::dvec3& d) {
            return density(Lobe::Diffuse, material, place, d);
          }) == doctest::Approx(1.0).epsilon(1e-3));
    for (const auto& [lobe, m] :
         {std::pair{Lobe::Diffuse, material}, {Lobe::Glossy, glossy(0.2F)}}) {
      for (std::uint32_t i = 0; i < 256; ++i) {
        const auto s = scatter(lobe, m, place, Sampler(1, 0, i).get2({0, Purpose::Glossy}), 0.0);
        if (!s) continue;
        CHECK(s->density == doctest::Approx(density(lobe, m, place, s->direction)).epsilon(1e-9));
        CHECK(s->weight.x * s->density ==
              doctest::Approx(evaluate(lobe, m, place, s->direction).x).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("lobes: light may go either way along a path") {
  const Place there = place_at(0.8);
  for (const auto& [lobe, material] :
       {std::pair{Lobe::Diffuse, matt(0.5F)}, {Lobe::Glossy, glossy(0.4F, 0.3F, 1.0F)}}) {
    for (std::uint32_t i = 0; i < 200; ++i) {
      const auto s =
          scatter(lobe, material, there, Sampler(3, 0, i).get2({0, Purpose::Glossy}), 0.0);
      if (!s) continue;
      const Place back{.normal = there.normal, .to_eye = s->direction};
      const double f =
          evaluate(lobe, material, there, s->direction).x / glm::dot(there.normal, s->direction);
      const double g =
          evaluate(lobe, material, back, there.to_eye).x / glm::dot(there.normal, there.to_eye);
      CHECK(f == doctest::Approx(g).epsilon(1e-9));
    }
  }
}

TEST_CASE("lobes: glass bends light by Snell's law and reflects it by Fresnel's") {
  CHECK(fresnel(1.0, 1.5) == doctest::Approx(0.04));
  CHECK(fresnel(1.0, 1.0 / 1.5) == doctest::Approx(0.04));
  CHECK(fresnel(0.0, 1.5) == doctest::Approx(1.0));
  CHECK(fresnel(0.5, 1.0) == doctest::Approx(0.0));
  const double brewster = std::cos(std::atan(1.5));
  CHECK(fresnel(brewster, 1.5) ==
        doctest::Approx(0.5 * std::pow((1.5 * 1.5 - 1.0) / (1.5 * 1.5 + 1.0), 2.0)));
  const double critical = std::sqrt(1.0 - 1.0 / (1.5 * 1.5));
  CHECK(fresnel(critical - 1e-6, 1.0 / 1.5) == 1.0);
  CHECK(fresnel(critical + 1e-6, 1.0 / 1.5) < 1.0);
  CHECK(fresnel(critical + 1e-6, 1.0 / 1.5) > 0.98);

  for (const bool entering : {true, false}) {
    for (const double cosine : {1.0, 0.9, 0.8}) {
      Place place = place_at(cosine);
      place.entering = entering;
      const Material material = glass(1.5F);
      const auto through = scatter(Lobe::Glass, material, place, {0.5, 0.5}, 1.0 - 1e-12);
      REQUIRE(through);
      const double sine_in = std::sqrt(1.0 - cosine * cosine);
      const double out = -glm::dot(through->direction, place.normal);
      CHECK(out > 0.0);
      CHECK(std::sqrt(std::max(0.0, 1.0 - out * out)) ==
            doctest::Approx(entering ? sine_in / 1.5 : sine_in * 1.5));
      // Back on the same path.
      const Place back{
          .normal = -place.normal, .to_eye = through->direction, .entering = !entering};
      const auto home = scatter(Lobe::Glass, material, back, {0.5, 0.5}, 1.0 - 1e-12);
      CHECK(glm::dot(home->direction, place.to_eye) == doctest::Approx(1.0));
      CHECK(home->weight.x * through->weight.x == doctest::Approx(1.0));
    }
  }
  // Beyond the critical angle all is reflected, whatever is drawn.
  Place inside = place_at(0.5);
  inside.entering = false;
  const auto total = scatter(Lobe::Glass, glass(1.5F), inside, {0.5, 0.5}, 1.0 - 1e-12);
  CHECK(glm::dot(total->direction, inside.normal) == doctest::Approx(0.5));
  CHECK(total->weight.x == 1.0);
  // An index of 1 is no surface.
  const Place place = place_at(0.3);
  const auto straight = scatter(Lobe::Glass, glass(1.0F), place, {0.5, 0.5}, 0.0);
  CHECK(glm::dot(straight->direction, place.to_eye) == doctest::Approx(-1.0));
  CHECK(straight->weight.x == 1.0);
}

TEST_CASE("lobes: Fresnel's share is one from either side of any glass, and one of light") {
  for (const double index : {1.0, 1.0 + 1e-12, 1.0 + 1e-7, 1.33, 1.5, 2.4, 100.0}) {
    CAPTURE(index);
    CHECK(fresnel(1.0, index) ==
          doctest::Approx(std::pow((index - 1.0) / (index + 1.0), 2.0)).epsilon(1e-12));
    for (const double cosine : {1.0, 1.0 - 1e-16, 0.7, 0.1, 1e-3, 1e-8, 0.0}) {
      CAPTURE(cosine);
      const double outside = fresnel(cosine, index);
      CHECK(outside >= 0.0);
      CHECK(outside <= 1.0);
      const double within = std::sqrt(1.0 - (1.0 - cosine * cosine) / (index * index));
      const double inside = fresnel(within, 1.0 / index);
      CHECK(inside >= 0.0);
      CHECK(inside <= 1.0);
      // At grazing angles the cosine of the other side has no bits of this one's.
      if (cosine >= 0.1) CHECK(inside == doctest::Approx(outside).epsilon(1e-9));
      for (const double choice : {0.0, 0.5, 1.0 - 0x1p-32}) {
        for (const bool entering : {true, false}) {
          Place place = place_at(cosine);
          place.entering = entering;
          const auto s =
              scatter(Lobe::Glass, glass(static_cast<float>(index)), place, {0.5, 0.5}, choice);
          REQUIRE(s);
          CHECK(glm::length(s->direction) == doctest::Approx(1.0).epsilon(1e-12));
          CHECK(finite(s->weight));
        }
      }
    }
  }
}

TEST_CASE("lobes: no direction and no roughness gives a number that is none") {
  for (const double cosine : {1.0, 0.5, 1e-3, 1e-8, 1e-12, 0.0}) {
    for (const bool entering : {true, false}) {
      Place place = place_at(cosine);
      place.entering = entering;
      for (const float alpha : {1e-4F, 1e-3F, 0.05F, 1.0F}) {
        Material material = glossy(alpha, 0.2F, 1.0F);
        material.transmission = glm::vec3(0.5F);
        material.diffuse = glm::vec3(0.3F);
        for (std::uint32_t i = 0; i < 64; ++i) {
          const glm::dvec2 u = Sampler(1, 1, i).get2({0, Purpose::Glossy});
          for (const Lobe lobe : {Lobe::Diffuse, Lobe::Glossy, Lobe::Mirror, Lobe::Glass}) {
            const auto s = scatter(lobe, material, place, u, u.x);
            if (!s) continue;
            REQUIRE(finite(s->direction));
            REQUIRE(finite(s->weight));
            REQUIRE(std::isfinite(s->density));
            REQUIRE(finite(evaluate(lobe, material, place, s->direction)));
          }
        }
      }
    }
  }
}

TEST_CASE("lobes: one is chosen by its brightness") {
  const auto sum = [](const Material& material) {
    double all = 0.0;
    for (const double chance : chances(material)) all += chance;
    return all;
  };
  Material mixed = matt(0.3F);
  mixed.specular = glm::vec3(0.1F);
  mixed.roughness = 0.2F;
  CHECK(sum(mixed) == doctest::Approx(1.0));
  CHECK(chances(mixed)[0] == doctest::Approx(0.75));
  CHECK(sum(matt(0.0F)) == 0.0);
  CHECK(chances(glass(1.5F))[3] == 1.0);
  for (const Lobe lobe : {Lobe::Diffuse, Lobe::Glossy, Lobe::Mirror, Lobe::Glass})
    CHECK(!has(lobe, matt(0.0F)));
}

}  // namespace
}  // namespace ti
