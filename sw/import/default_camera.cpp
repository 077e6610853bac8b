// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "import/import.hpp"
#include "scene/geometry.hpp"

namespace ti {

Camera default_camera(const Mesh& mesh) {
  Camera camera;
  const auto bounds = bounds_of(mesh);
  if (!bounds) return camera;
  const double radius = bounds->diagonal() > 0.0 ? 0.5 * bounds->diagonal() : 1.0;
  constexpr double kHalfRadian = 3.14159265358979323846 / 360.0;
  const double distance = 1.05 * radius / std::sin(camera.fov_y_deg * kHalfRadian);
  const glm::dvec3 direction = glm::normalize(glm::dvec3(0.5, 0.4, 1.0));
  camera.target = glm::vec3(bounds->centre());
  constexpr double kMax = std::numeric_limits<float>::max();
  camera.eye = glm::vec3(glm::clamp(bounds->centre() + distance * direction, -kMax, kMax));
  return camera;
}

}  // namespace ti
