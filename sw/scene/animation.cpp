// SPDX-License-Identifier: Apache-2.0
#include "scene/animation.hpp"

#include <algorithm>
#include <limits>

namespace ti {

namespace {

void add(Box& box, const glm::vec3& place) {
  if (!finite(place)) return;
  const Point p = point_of(place);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lo[axis] = std::min(box.lo[axis], p[axis]);
    box.hi[axis] = std::max(box.hi[axis], p[axis]);
  }
}

bool same(const Camera& a, const Camera& b) {
  return a.eye == b.eye && a.target == b.target && a.up == b.up && a.fov_y_deg == b.fov_y_deg &&
         a.aperture == b.aperture && a.focus_distance == b.focus_distance;
}

bool same(const Light& a, const Light& b) {
  return a.kind == b.kind && a.position == b.position && a.direction == b.direction &&
         a.intensity == b.intensity && a.range == b.range && a.cos_inner == b.cos_inner &&
         a.cos_outer == b.cos_outer;
}

}  // namespace

void Animation::pose(Scene& scene, std::size_t frame) const {
  const Frame& now = frames.at(frame);
  for (std::size_t i = 0; i < moving.size(); ++i) scene.mesh.vertices[moving[i]] = now.positions[i];
  scene.camera = now.camera;
  scene.lights = now.lights;
}

Box Animation::reach(const Scene& scene) const {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  Box box{{kInf, kInf, kInf}, {-kInf, -kInf, -kInf}};
  for (const auto& corners : scene.mesh.triangles)
    for (const std::uint32_t corner : corners) add(box, scene.mesh.vertices[corner]);
  for (const Frame& frame : frames)
    for (const glm::vec3& place : frame.positions) add(box, place);
  return box;
}

Change change_between(const Scene& before, const Scene& after) {
  Change change;
  change.moved.resize(after.mesh.triangles.size());
  for (std::size_t i = 0; i < change.moved.size(); ++i) {
    if (before.mesh.corners(i) == after.mesh.corners(i)) continue;
    change.moved[i] = 1;
    ++change.triangles;
    change.emits = change.emits || after.material_of(i).is_emissive();
  }
  change.view = !same(before.camera, after.camera);
  change.lights =
      !std::equal(before.lights.begin(), before.lights.end(), after.lights.begin(),
                  after.lights.end(), [](const Light& a, const Light& b) { return same(a, b); });
  return change;
}

}  // namespace ti
