// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "import/import.hpp"
#include "scene/geometry.hpp"

namespace ti {

namespace {

/// Irradiance at which the log-average of the surfaces is put (Reinhard et al. 2002, section 3.1,
/// with their key value taken for incident light).
constexpr double kKey = 0.4;
constexpr std::size_t kMaxSamples = 1U << 22;

double luminance(const glm::dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

glm::dvec3 centroid(const Mesh& mesh, std::size_t i) {
  return (glm::dvec3(mesh.vertex(i, 0)) + glm::dvec3(mesh.vertex(i, 1)) +
          glm::dvec3(mesh.vertex(i, 2))) /
         3.0;
}

std::size_t material_of(const Mesh& mesh, std::size_t i) {
  return mesh.material.empty() ? 0 : mesh.material[i];
}

}  // namespace

std::vector<PointLight> emissive_lights(const Scene& scene) {
  const auto bounds = bounds_of(scene.mesh);
  if (!bounds) return {};
  struct Sum {
    double area = 0.0;
    glm::dvec3 moment{0.0};
  };
  std::vector<Sum> sums(scene.materials.size());
  for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
    const std::size_t m = material_of(scene.mesh, i);
    if (scene.materials[m].emission == glm::vec3(0.0F)) continue;
    const double area = 0.5 * glm::length(area_vector(scene.mesh, i));
    if (!std::isfinite(area)) continue;
    sums[m].area += area;
    sums[m].moment += area * centroid(scene.mesh, i);
  }
  std::vector<PointLight> lights;
  for (std::size_t m = 0; m < sums.size(); ++m) {
    if (!(sums[m].area > 0.0)) continue;
    glm::dvec3 position = sums[m].moment / sums[m].area;
    const glm::dvec3 inward = bounds->centre() - position;
    const double distance = glm::length(inward);
    if (distance > 0.0) position += inward * (1e-3 * bounds->diagonal() / distance);
    lights.push_back({.position = glm::vec3(position),
                      .intensity = scene.materials[m].emission * static_cast<float>(sums[m].area)});
  }
  return lights;
}

void expose(Scene& scene) {
  const auto bounds = bounds_of(scene.mesh);
  if (!bounds || scene.lights.empty()) return;
  const double nearest = 1e-4 * bounds->diagonal() * bounds->diagonal();
  const std::size_t count = scene.mesh.triangles.size();
  const std::size_t step = 1 + count * scene.lights.size() / kMaxSamples;
  double log_sum = 0.0;
  double weight = 0.0;
  for (std::size_t i = 0; i < count; i += step) {
    if (scene.materials[material_of(scene.mesh, i)].emission != glm::vec3(0.0F)) continue;
    const glm::dvec3 n = area_vector(scene.mesh, i);
    const double area = glm::length(n);
    if (!(area > 0.0) || !std::isfinite(area)) continue;
    double incident = 0.0;
    for (const PointLight& light : scene.lights) {
      const glm::dvec3 to = glm::dvec3(light.position) - centroid(scene.mesh, i);
      const double d2 = std::max(glm::dot(to, to), nearest);
      const double cosine = std::abs(glm::dot(n, to)) / (area * std::sqrt(d2));
      incident += luminance(light.intensity) * cosine / d2;
    }
    if (!(incident > 0.0) || !std::isfinite(incident)) continue;
    log_sum += area * std::log(incident);
    weight += area;
  }
  if (!(weight > 0.0)) return;
  const double factor = kKey / std::exp(log_sum / weight);
  if (!std::isfinite(factor)) return;
  for (PointLight& light : scene.lights) light.intensity *= static_cast<float>(factor);
}

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
