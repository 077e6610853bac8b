// SPDX-License-Identifier: Apache-2.0
#include "scene/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace ti {

namespace {

bool finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

double Bounds::diagonal() const { return glm::length(high - low); }

std::optional<Bounds> bounds_of(const Mesh& mesh) {
  std::optional<Bounds> bounds;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::dvec3 p[3] = {mesh.vertex(i, 0), mesh.vertex(i, 1), mesh.vertex(i, 2)};
    if (!finite(p[0]) || !finite(p[1]) || !finite(p[2])) continue;
    if (!bounds) bounds = {p[0], p[0]};
    for (const glm::dvec3& q : p) {
      bounds->low = glm::min(bounds->low, q);
      bounds->high = glm::max(bounds->high, q);
    }
  }
  return bounds;
}

glm::dvec3 area_vector(const Mesh& mesh, std::size_t i) {
  const glm::dvec3 p0 = mesh.vertex(i, 0);
  return glm::cross(glm::dvec3(mesh.vertex(i, 1)) - p0, glm::dvec3(mesh.vertex(i, 2)) - p0);
}

Surface surface_at(const Mesh& mesh, const Ray& ray, const Hit& hit) {
  const auto i = static_cast<std::size_t>(hit.prim);
  const auto& corner = mesh.triangles.at(i);
  const glm::dvec3 p0 = mesh.vertices[corner[0]];
  const glm::dvec3 p1 = mesh.vertices[corner[1]];
  const glm::dvec3 p2 = mesh.vertices[corner[2]];
  const double u = hit.u;
  const double v = hit.v;
  const glm::dvec3 d = ray.d;

  Surface s;
  s.position = (1.0 - u - v) * p0 + u * p1 + v * p2;
  const glm::dvec3 n = area_vector(mesh, i);
  const double length = glm::length(n);
  s.normal = length > 0.0 ? n / length : -glm::normalize(d);
  if (glm::dot(s.normal, d) > 0.0) s.normal = -s.normal;
  const double scale = std::max(largest(s.position), largest(static_cast<double>(hit.t) * d));
  s.origin = glm::vec3(s.position + s.normal * (16.0 * 0x1p-23 * scale));
  return s;
}

}  // namespace ti
