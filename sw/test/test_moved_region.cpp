// SPDX-License-Identifier: Apache-2.0
// Rays that may meet what moved are told from those that cannot.

#include <doctest/doctest.h>

#include "render/moved_region.hpp"
#include "test/picture.hpp"

namespace ti {
namespace {

constexpr Box kReach{{-10, -10, -10}, {10, 10, 10}};

/// A box that stands at `place`, and a floor far below.
Scene scene_at(const glm::vec3& place) {
  Scene scene;
  scene.materials = {{}};
  test::add_box(scene, place, place + glm::vec3(1.0F), 0);
  test::add_quad(scene, {{{-9, -9, -9}, {-9, -9, 9}, {9, -9, 9}, {9, -9, -9}}}, 0);
  return scene;
}

Ray ray(const glm::vec3& o, const glm::vec3& d) { return {.o = o, .d = d}; }

TEST_CASE("moved region: rays through the old and the new place meet it, others do not") {
  const Scene before = scene_at({0, 0, 0});
  const Scene after = scene_at({3, 0, 0});
  const Change change = change_between(before, after);
  CHECK(change.triangles == 12);
  const MovedRegion region(before.mesh, after.mesh, change, kReach, {});
  CHECK(region.met_by(ray({0.5F, 5, 0.5F}, {0, -1, 0})));
  CHECK(region.met_by(ray({3.5F, 5, 0.5F}, {0, -1, 0})));
  CHECK(!region.met_by(ray({2.0F, 5, 0.5F}, {0, -1, 0})));   // between both
  CHECK(!region.met_by(ray({-5.0F, 5, 0.5F}, {0, -1, 0})));  // to the floor, which stands still
}

TEST_CASE("moved region: a ray counts up to its hit, an any-hit ray whole") {
  const Scene before = scene_at({0, 0, 0});
  const Scene after = scene_at({0, 0.5F, 0});
  const MovedRegion region(before.mesh, after.mesh, change_between(before, after), kReach, {});
  const Ray down = ray({0.5F, 5, 0.5F}, {0, -1, 0});
  const Hit early{.t = 2.0F, .prim = 12};
  const Hit late{.t = 3.5F, .prim = 12};
  CHECK(!region.met_by(cut_at(down, early)));
  CHECK(region.met_by(cut_at(down, late)));
  CHECK(region.met_by(cut_at(down, Hit{})));
  Ray any = down;
  any.any = true;
  CHECK(region.met_by(cut_at(any, Hit{.t = 0.0F, .prim = 0})));
}

TEST_CASE("moved region: boxes are wider the fewer bits the format has") {
  const Scene before = scene_at({0, 0, 0});
  const Scene after = scene_at({0, 0.5F, 0});
  const Change change = change_between(before, after);
  const Ray beside = ray({1.01F, 5, 0.5F}, {0, -1, 0});
  CHECK(!MovedRegion(before.mesh, after.mesh, change, kReach, Format{8, 23}).met_by(beside));
  CHECK(MovedRegion(before.mesh, after.mesh, change, kReach, Format{8, 13}).met_by(beside));
}

TEST_CASE("moved region: rays along a side of a box, and rays that are out of range") {
  const Scene before = scene_at({0, 0, 0});
  const Scene after = scene_at({0, 1, 0});
  const MovedRegion region(before.mesh, after.mesh, change_between(before, after), kReach, {});
  CHECK(region.met_by(ray({1.0F, -5, 0.5F}, {0, 1, 0})));
  CHECK(region.met_by(ray({0, -5, 0}, {0, 1, 0})));
  CHECK(region.met_by(ray({1e30F, 0, 0}, {0, 1, 0})));  // cannot be told, so it counts
  Ray empty = ray({0.5F, 5, 0.5F}, {0, -1, 0});
  empty.tmax = -1.0F;
  CHECK(!region.met_by(empty));
}

TEST_CASE("change: triangles, lamps, the camera and lights, each by itself") {
  const Scene scene = scene_at({0, 0, 0});
  CHECK(change_between(scene, scene).nothing());
  Scene other = scene;
  other.camera.fov_y_deg = 50.0F;
  CHECK(change_between(scene, other).view);
  other = scene;
  other.lights.push_back({});
  CHECK(change_between(scene, other).lights);
  other = scene;
  other.mesh.vertices[0].x += 1.0F;
  CHECK(change_between(scene, other).triangles == 2);
  CHECK(!change_between(scene, other).emits);
  other.materials[0].emission = glm::vec3(1.0F);
  CHECK(change_between(scene, other).emits);
}

}  // namespace
}  // namespace ti
