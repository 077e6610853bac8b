// SPDX-License-Identifier: Apache-2.0
// The most light that a ray can find, and paths that end by it.

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "render/bound.hpp"
#include "render/film.hpp"
#include "test/picture.hpp"

namespace ti {
namespace {

/// A closed room of dark walls with a lamp below its ceiling and a box on its floor.
Scene room(float albedo) {
  Scene scene;
  scene.materials = {{.name = "wall", .diffuse = glm::vec3(albedo)},
                     {.name = "lamp", .diffuse = glm::vec3(0.0F), .emission = glm::vec3(5.0F)}};
  test::add_box(scene, {-2, -2, -2}, {2, 2, 2}, 0);
  test::add_box(scene, {-1, -2, -1}, {0, -1, 0}, 0);
  test::add_quad(scene, {{{-1, 1.9F, -1}, {1, 1.9F, -1}, {1, 1.9F, 1}, {-1, 1.9F, 1}}}, 1);
  scene.camera = {.eye = {0, 0, 1.9F}, .target = {0, -0.5F, 0}, .fov_y_deg = 70.0F};
  return scene;
}

TEST_CASE("bound: distances to corners, edges and the inside of a triangle") {
  const Corners t{glm::vec3(0, 0, 0), glm::vec3(4, 0, 0), glm::vec3(0, 4, 0)};
  CHECK(distance_to(t, {1, 1, 3}) == doctest::Approx(3.0));
  CHECK(distance_to(t, {1, 1, -2}) == doctest::Approx(2.0));
  CHECK(distance_to(t, {2, -1, 0}) == doctest::Approx(1.0));
  CHECK(distance_to(t, {-3, -4, 0}) == doctest::Approx(5.0));
  CHECK(distance_to(t, {4, 4, 0}) == doctest::Approx(std::sqrt(8.0)));
  CHECK(distance_to(t, {1, 1, 0}) == 0.0);
  const Corners flat{glm::vec3(0, 0, 0), glm::vec3(2, 0, 0), glm::vec3(1, 0, 0)};
  CHECK(distance_to(flat, {1, 3, 0}) == doctest::Approx(3.0));
}

TEST_CASE("bound: emission, lights at their nearest triangle, and what surfaces make of them") {
  Scene scene = room(0.5F);
  const LightBound lamp(scene, 2);
  CHECK(lamp.arriving(0) == doctest::Approx(5.0));
  CHECK(lamp.arriving(1) == doctest::Approx(5.0 + 0.5 * 5.0));
  CHECK(lamp.arriving(2) == doctest::Approx(5.0 + 0.5 * 7.5));

  scene.materials[1].emission = glm::vec3(0.0F);
  scene.lights = {{.position = {0, 0, 0}, .intensity = glm::vec3(8.0F)}};
  const double nearest = 1.0;  // the top of the box, at its corner
  CHECK(LightBound(scene, 1).arriving(1) ==
        doctest::Approx(8.0 / (nearest * nearest) * 0.5 / 3.14159265358979));
  scene.lights[0].position = {0, -2, 1};  // on the floor
  CHECK(std::isinf(LightBound(scene, 1).arriving(1)));
  scene.lights = {{.kind = LightKind::Directional, .intensity = glm::vec3(3.0F)}};
  scene.background = glm::vec3(0.25F);
  CHECK(LightBound(scene, 1).arriving(1) ==
        doctest::Approx(3.0 * 0.5 / 3.14159265358979 + 0.5 * 0.25));
  CHECK(LightBound(scene, 0).arriving(0) == doctest::Approx(0.25));
}

TEST_CASE("bound: no pixel of a room is brighter in the mean than what can arrive") {
  for (const float albedo : {0.1F, 0.5F, 0.9F}) {
    const Scene scene = room(albedo);
    const auto picture =
        test::picture_of(scene, {.width = 8, .height = 8, .spp = 64, .bounces = 3}, "all");
    const double most = LightBound(scene, 3).arriving(3);
    for (const glm::vec3& c : picture.radiance) CHECK(double(c.x) < most);
  }
}

TEST_CASE("dim paths: in a dark room they end, and the picture stays within half a step") {
  const Scene scene = room(0.03F);
  const FilmSize size{.width = 24, .height = 24, .spp = 8, .bounces = 8};
  const auto some = test::picture_of(scene, size, "auto");
  const auto whole = test::picture_of(scene, size, "auto+dim-paths");
  CHECK(some.dim_paths.paths > 0);
  CHECK(whole.dim_paths.paths == 0);
  CHECK(some.count(RayKind::Diffuse) < whole.count(RayKind::Diffuse) * 3 / 4);
  const double exposure = exposure_of(whole.radiance);
  CHECK(some.dim_paths.bound * exposure < 0.5 * kOutputStep);
  double difference = 0.0;
  for (std::size_t i = 0; i < whole.radiance.size(); ++i)
    difference = std::max(
        difference, glm::length(glm::dvec3(whole.radiance[i]) - glm::dvec3(some.radiance[i])));
  CHECK(difference > 0.0);
  CHECK(difference * exposure < 0.5 * kOutputStep);
}

TEST_CASE("dim paths: in a bright room none ends, and no bit changes") {
  const Scene scene = room(0.7F);
  const FilmSize size{.width = 16, .height = 16, .spp = 4, .bounces = 4};
  const auto some = test::picture_of(scene, size, "auto");
  CHECK(some.plan.ends_dim_paths);
  CHECK(some.dim_paths.paths == 0);
  CHECK(some.radiance == test::picture_of(scene, size, "all").radiance);
}

}  // namespace
}  // namespace ti
