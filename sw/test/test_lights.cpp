// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "render/lights.hpp"
#include "render/sampler.hpp"
#include "test/picture.hpp"

namespace ti {
namespace {

/// Two lamps, one four times as large, one twice as bright, around the origin.
Scene lamps() {
  Scene scene;
  scene.materials = {
      {.diffuse = glm::vec3(0.5F)}, {.emission = glm::vec3(1.0F)}, {.emission = glm::vec3(2.0F)}};
  test::add_quad(scene, {{{-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}}}, 1);
  test::add_quad(scene, {{{3, -0.5F, -0.5F}, {3, 0.5F, -0.5F}, {3, 0.5F, 0.5F}, {3, -0.5F, 0.5F}}},
                 2);
  test::add_quad(scene, {{{-9, -5, -9}, {9, -5, -9}, {9, -5, 9}, {-9, -5, 9}}}, 0);
  return scene;
}

TEST_CASE("lights: triangles are chosen by their power, points by the density that they have") {
  const Scene scene = lamps();
  const Lights lights(scene);
  REQUIRE(lights.has_area());
  int large = 0;
  double solid_angle = 0.0;
  constexpr int kCount = 1 << 14;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const Sampler random(1, 0, i);
    const auto p = lights.sample(glm::dvec3(0.0), random.get2({0, Purpose::Light}));
    REQUIRE(p);
    const auto prim = static_cast<std::size_t>(p->hit.prim);
    REQUIRE(prim < 4);
    large += prim < 2 ? 1 : 0;
    solid_angle += 1.0 / p->density;
    CHECK(p->emission == glm::dvec3(prim < 2 ? 1.0 : 2.0));
    CHECK(p->hit.u + p->hit.v <= 1.0F + 1e-6F);
    // The same density, seen from a ray that meets the point.
    const double t = prim < 2 ? 2.0 / p->direction.y : 3.0 / p->direction.x;
    CHECK(lights.density(prim, glm::dvec3(0.0), t * p->direction) ==
          doctest::Approx(p->density).epsilon(1e-5));
  }
  CHECK(large / double(kCount) == doctest::Approx(4.0 / 6.0).epsilon(0.01));
  // Solid angles of the two squares from the origin: 4 asin(a^2 / (a^2 + h^2)).
  const double expected = 4.0 * std::asin(1.0 / (1.0 + 4.0)) + 4.0 * std::asin(0.25 / (0.25 + 9.0));
  CHECK(solid_angle / kCount == doctest::Approx(expected).epsilon(0.005));
  CHECK(lights.density(4, glm::dvec3(0.0), {0, -5, 0}) == 0.0);
}

/// The density of a direction: that of all places of lamps that it meets.
double density_along(const Scene& scene, const Lights& lights, const glm::dvec3& from,
                     const glm::dvec3& direction) {
  double sum = 0.0;
  for (std::size_t prim = 0; prim < scene.mesh.triangles.size(); ++prim) {
    const glm::dvec3 p0 = scene.mesh.vertex(prim, 0);
    const glm::dvec3 e1 = glm::dvec3(scene.mesh.vertex(prim, 1)) - p0;
    const glm::dvec3 e2 = glm::dvec3(scene.mesh.vertex(prim, 2)) - p0;
    const glm::dvec3 across = glm::cross(direction, e2);
    const double det = glm::dot(e1, across);
    if (det == 0.0) continue;
    const glm::dvec3 q = glm::cross(from - p0, e1);
    const double u = glm::dot(from - p0, across) / det;
    const double v = glm::dot(direction, q) / det;
    const double t = glm::dot(e2, q) / det;
    if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0)
      sum += lights.density(prim, from, from + t * direction);
  }
  return sum;
}

TEST_CASE("lights: densities over all directions add up to one, from before and from behind") {
  Scene scene = lamps();
  // A third lamp in front of the first, so that some directions meet two.
  test::add_quad(scene, {{{-0.5F, 1, -0.5F}, {0.5F, 1, 0}, {0.5F, 1, 0.5F}, {-0.5F, 1, 0.5F}}}, 2);
  const Lights lights(scene);
  for (const glm::dvec3& from :
       {glm::dvec3(0.0), glm::dvec3(0.3, 1.5, -0.2), glm::dvec3(1.5, 3.0, 0.5)}) {
    // Directions along a spiral whose turn is the golden angle, all of the same solid angle.
    constexpr int kCount = 1 << 19;
    const double turn = std::acos(-1.0) * (3.0 - std::sqrt(5.0));
    double sum = 0.0;
    for (int i = 0; i < kCount; ++i) {
      const double z = 2.0 * (i + 0.5) / kCount - 1.0;
      const double r = std::sqrt(1.0 - z * z);
      sum +=
          density_along(scene, lights, from, {r * std::cos(i * turn), r * std::sin(i * turn), z});
    }
    CHECK(sum * 4.0 * std::acos(-1.0) / kCount == doctest::Approx(1.0).epsilon(0.002));
  }
}

/// Irradiance of a polygon of radiance 1, all of it above the surface, after Lambert (Photometria,
/// 1760): half the sum, over its edges, of the angle that an edge takes up times the cosine of its
/// plane.
double lambert(const std::array<glm::vec3, 4>& corners, const glm::dvec3& at,
               const glm::dvec3& normal) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec3 a = glm::normalize(glm::dvec3(corners[i]) - at);
    const glm::dvec3 b = glm::normalize(glm::dvec3(corners[(i + 1) % 4]) - at);
    const glm::dvec3 plane = glm::cross(a, b);
    sum += std::atan2(glm::length(plane), glm::dot(a, b)) * glm::dot(glm::normalize(plane), normal);
  }
  return 0.5 * std::abs(sum);
}

TEST_CASE("lights: a square lamp gives the irradiance of Lambert's formula at any distance") {
  const std::array<glm::vec3, 4> corners{{{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}}};
  Scene scene;
  scene.materials = {{.emission = glm::vec3(1.0F, 2.0F, 0.5F)}};
  test::add_quad(scene, corners, 0);
  const Lights lights(scene);
  for (const double distance : {0.1, 0.5, 1.0, 3.0, 30.0, 1000.0}) {
    // Both sides of the lamp, below its middle and aside, facing it and askew.
    for (const glm::dvec3& place : {glm::dvec3(0, -1, 0), {0, 1, 0}, {0.9, -1, 0.4}}) {
      const glm::dvec3 at = place * distance;
      const double side = place.y < 0.0 ? 1.0 : -1.0;
      // Tilted by no more than leaves the whole lamp above.
      const double tilt = distance < 1.0 ? 0.05 * distance : 0.3;
      for (const glm::dvec3& normal :
           {glm::dvec3(0, side, 0), glm::normalize(glm::dvec3(tilt, side, 0))}) {
        CAPTURE(distance);
        CAPTURE(place.x);
        CAPTURE(normal.x);
        // Points in the middle of equal boxes of the numbers that choose them.
        glm::dvec3 sum(0.0);
        constexpr int kSide = 256;
        constexpr int kCount = 2 * kSide * kSide;
        for (int i = 0; i < kCount; ++i) {
          const glm::dvec2 u((i % (2 * kSide) + 0.5) / (2 * kSide),
                             (i / (2 * kSide) + 0.5) / kSide);
          const auto p = lights.sample(at, u);
          if (!p) FAIL("no point of the lamp");
          sum += p->emission * std::max(0.0, glm::dot(normal, p->direction)) / p->density;
        }
        sum /= kCount;
        const double expected = lambert(corners, at, normal);
        CHECK(std::abs(sum.x / expected - 1.0) < 2e-3);
        CHECK(sum.y == doctest::Approx(2.0 * sum.x));
        CHECK(sum.z == doctest::Approx(0.5 * sum.x));
      }
    }
  }
}

TEST_CASE("lights: a lamp of two triangles converges as the sampler's points do") {
  Scene scene;
  scene.materials = {{.emission = glm::vec3(1.0F)}};
  const std::array<glm::vec3, 4> corners{{{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}}};
  test::add_quad(scene, corners, 0);
  const Lights lights(scene);
  const glm::dvec3 at(0.9, -1.0, 0.4);
  const glm::dvec3 up(0.0, 1.0, 0.0);
  // Shares are half open: at their border the next one begins.
  CHECK(lights.sample(at, {0.5, 0.3})->hit.prim == 1);
  CHECK(lights.sample(at, {std::nextafter(0.5, 0.0), 0.3})->hit.prim == 0);
  const double expected = lambert(corners, at, up);
  constexpr int kPixels = 64;
  constexpr int kSamples = 256;
  double squares = 0.0;
  for (std::uint32_t pixel = 0; pixel < kPixels; ++pixel) {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      const Sampler random(1, pixel, i);
      const auto p = lights.sample(at, random.get2({0, Purpose::Light}));
      if (!p) FAIL("no point of the lamp");
      sum += p->direction.y / p->density;
    }
    squares += std::pow(sum / kSamples - expected, 2.0);
  }
  // Random numbers, also those that choose triangle and place apart, give 6 %.
  CHECK(std::sqrt(squares / kPixels) < 0.005 * expected);
}

TEST_CASE("lights: of many triangles each is chosen as often as its power says") {
  Scene scene;
  scene.materials = {{.emission = glm::vec3(1.0F)}, {.emission = glm::vec3(0.0F)}};
  // Areas 1, 2, 3 and so on; each third has none, each fifth does not emit.
  std::vector<double> power;
  double all = 0.0;
  for (int i = 0; i < 30; ++i) {
    const auto first = static_cast<std::uint32_t>(scene.mesh.vertices.size());
    const auto x = static_cast<float>(10 * i);
    const bool flat = i % 3 == 0;
    const bool dark = i % 5 == 0;
    scene.mesh.vertices.insert(
        scene.mesh.vertices.end(),
        {{x, 5, 0}, {x + 2.0F, 5, 0}, {x, 5, flat ? 0.0F : static_cast<float>(i + 1)}});
    scene.mesh.triangles.push_back({first, first + 1, first + 2});
    scene.mesh.material.push_back(dark ? 1 : 0);
    power.push_back(flat || dark ? 0.0 : i + 1.0);
    all += power.back();
  }
  const Lights lights(scene);
  std::vector<double> chosen(power.size(), 0.0);
  constexpr int kCount = 1 << 14;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    // All choices at the same distance from each other, the first and the last that there are among
    // them.
    const double choice = i + 1 == kCount ? 1.0 - 0x1p-53 : static_cast<double>(i) / kCount;
    const auto p = lights.sample(glm::dvec3(0.0), {choice, 0.6});
    REQUIRE(p);
    chosen[static_cast<std::size_t>(p->hit.prim)] += 1.0;
    CHECK(p->hit.u >= 0.0F);
    CHECK(p->hit.v >= 0.0F);
    CHECK(p->hit.u + p->hit.v <= 1.0F + 1e-6F);
  }
  for (std::size_t i = 0; i < power.size(); ++i)
    CHECK(std::abs(chosen[i] - kCount * power[i] / all) <= 1.0);
}

TEST_CASE("lights: a scene without lights has none") {
  Scene scene;
  scene.materials = {{.diffuse = glm::vec3(0.5F)}};
  for (int i = 0; i < 2; ++i) {
    const Lights lights(scene);
    CHECK(lights.count() == 0);
    CHECK(!lights.has_area());
    CHECK(is_unlit(scene));
    if (i == 1) CHECK(lights.density(0, {0, 1, 0}, {0, 0, 0}) == 0.0);
    test::add_quad(scene, {{{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}}}, 0);
  }
}

TEST_CASE("lights: triangles without an area or a finite place are no lamps") {
  Scene scene;
  scene.materials = {{.emission = glm::vec3(1.0F)}};
  scene.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {NAN, 0, 0}};
  scene.mesh.triangles = {{0, 1, 2}, {0, 1, 3}};
  CHECK(!Lights(scene).has_area());
  CHECK(is_unlit(scene));
  scene.background.x = 0.1F;
  CHECK(!is_unlit(scene));
  // From a point in the plane of a lamp nothing of it is seen.
  CHECK(!Lights(lamps()).sample({0, 2, 0}, {0.3, 0.3}));
}

TEST_CASE("lights: points fall off by the square, spots by their cone, both end at their range") {
  Scene scene;
  scene.lights = {
      {.intensity = glm::vec3(8.0F)},
      {.intensity = glm::vec3(8.0F), .range = 4.0F},
      {.kind = LightKind::Spot,
       .direction = {0, -1, 0},
       .intensity = glm::vec3(8.0F),
       .cos_inner = 0.9F,
       .cos_outer = 0.5F},
      {.kind = LightKind::Directional, .direction = {0, -1, 0}, .intensity = glm::vec3(3.0F)}};
  const Lights lights(scene);
  const auto at = [&](std::size_t i, const glm::dvec3& from) {
    const auto toward = lights.toward(i, from);
    return toward ? toward->irradiance.x : 0.0;
  };
  CHECK(at(0, {0, -2, 0}) == doctest::Approx(2.0));
  CHECK(at(0, {0, -4, 0}) == doctest::Approx(0.5));
  CHECK(at(0, {0, 0, 0}) == 0.0);
  CHECK(at(1, {0, -2, 0}) == doctest::Approx(2.0 * 15.0 / 16.0));
  CHECK(at(1, {0, -4, 0}) == 0.0);
  CHECK(at(1, {0, -5, 0}) == 0.0);
  CHECK(at(2, {0, -2, 0}) == doctest::Approx(2.0));
  CHECK(at(2, {0, 2, 0}) == 0.0);
  const double tilt = std::acos(0.7);
  CHECK(at(2, {2 * std::sin(tilt), -2 * std::cos(tilt), 0}) == doctest::Approx(2.0 * 0.25));
  CHECK(at(3, {7, 7, 7}) == doctest::Approx(3.0));
  CHECK(lights.toward(3, {7, 7, 7})->direction == glm::dvec3(0, 1, 0));
  CHECK(std::isinf(lights.end_of(3, {0, 0, 0}, {}).tmax));
  // A spot without a ramp has one of 0.001 from the outer cone on.
  scene.lights[2].cos_inner = scene.lights[2].cos_outer;
  const auto edge = [&](double cosine) {
    const double sine = std::sqrt(1.0 - cosine * cosine);
    return at(2, {2 * sine, -2 * cosine, 0});
  };
  CHECK(edge(0.499) == 0.0);
  CHECK(edge(0.5005) == doctest::Approx(2.0 * 0.25));
  CHECK(edge(0.502) == doctest::Approx(2.0));
  const auto end = lights.end_of(0, {0, -2, 0}, {});
  CHECK(end.tmax < 1.0F);
  CHECK(end.tmax > 0.9999F);
}

}  // namespace
}  // namespace ti
