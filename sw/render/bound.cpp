// SPDX-License-Identifier: Apache-2.0
#include "render/bound.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

namespace ti {

namespace {

constexpr double kPi = 3.14159265358979323846;

double brightest(const glm::vec3& c) { return std::max({c.x, c.y, c.z}); }

/// Distance from a point to the segment a b.
double distance_to_segment(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& point) {
  const glm::dvec3 along = b - a;
  const double length2 = glm::dot(along, along);
  const double s = length2 > 0.0 ? std::clamp(glm::dot(point - a, along) / length2, 0.0, 1.0) : 0.0;
  return glm::length(point - a - s * along);
}

/// Irradiance of a light on a surface that faces it at the nearest triangle.
double strongest(const Light& light, const Mesh& mesh) {
  const double intensity = brightest(light.intensity);
  if (light.kind == LightKind::Directional || intensity == 0.0) return intensity;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    nearest = std::min(nearest, distance_to(mesh.corners(i), light.position));
  return intensity / (nearest * nearest);
}

}  // namespace

double distance_to(const Corners& triangle, const glm::dvec3& point) {
  const glm::dvec3 p[] = {triangle[0], triangle[1], triangle[2]};
  const glm::dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
  const double length2 = glm::dot(normal, normal);
  double nearest = std::numeric_limits<double>::infinity();
  bool above = length2 > 0.0;  // the point is over the inside
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3& a = p[i];
    const glm::dvec3& b = p[(i + 1) % 3];
    above = above && glm::dot(glm::cross(b - a, point - a), normal) >= 0.0;
    nearest = std::min(nearest, distance_to_segment(a, b, point));
  }
  if (above)
    nearest = std::min(nearest, std::abs(glm::dot(point - p[0], normal)) / std::sqrt(length2));
  return nearest;
}

LightBound::LightBound(const Scene& scene, int scatterings) {
  double emission = 0.0;
  double albedo = 0.0;
  double of_irradiance = 0.0;
  for (const Material& m : scene.materials) {
    const double specular = m.schlick > 0.0F ? 1.0 : brightest(m.specular);
    emission = std::max<double>(emission, brightest(m.emission));
    double sum = brightest(m.diffuse);
    double peak = sum / kPi;
    if (m.is_glossy() || m.is_mirror()) sum += specular;
    if (m.is_glossy()) peak += specular / (2.0 * kPi * std::pow(m.roughness, 3));
    if (m.is_glass()) sum += brightest(m.transmission) * m.ior * m.ior;
    albedo = std::max(albedo, sum);
    of_irradiance = std::max(of_irradiance, peak);
  }
  double irradiance = 0.0;
  for (const Light& light : scene.lights) irradiance += strongest(light, scene.mesh);
  const double background = brightest(scene.background);
  arriving_.push_back(std::max(emission, background));
  for (int k = 1; k <= scatterings; ++k)
    arriving_.push_back(
        std::max(background, emission + irradiance * of_irradiance + albedo * arriving_.back()));
}

}  // namespace ti
