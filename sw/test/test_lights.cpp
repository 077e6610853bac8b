// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <glm/geometric.hpp>

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
    const auto p = lights.sample(glm::dvec3(0.0), random.get1({0, Purpose::LightChoice}),
                                 random.get2({0, Purpose::LightPoint}));
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
  CHECK(!Lights(lamps()).sample({0, 2, 0}, 0.0, {0.3, 0.3}));
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
  const auto end = lights.end_of(0, {0, -2, 0}, {});
  CHECK(end.tmax < 1.0F);
  CHECK(end.tmax > 0.9999F);
}

}  // namespace
}  // namespace ti
