// SPDX-License-Identifier: Apache-2.0
#include "render/lights.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/vec.hpp"
#include "scene/geometry.hpp"

namespace ti {

namespace {

double luminance(const glm::vec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

/// The triangle's normal times its area; not finite or 0 where it has none.
glm::dvec3 half_area(const Mesh& mesh, std::size_t prim) { return 0.5 * area_vector(mesh, prim); }

/// The window of KHR_lights_punctual: 1 at the light, 0 from its range on.
double window(double distance, double range) {
  if (!std::isfinite(range)) return 1.0;
  const double x = distance / range;
  return std::clamp(1.0 - x * x * x * x, 0.0, 1.0);
}

/// The cone of KHR_lights_punctual: full inside the inner one, nothing beyond the outer, the square
/// of a ramp of the cosine between, and that at least 0.001 wide.
double cone(const Light& light, double cosine) {
  const double width = std::max(1e-3, double(light.cos_inner) - double(light.cos_outer));
  const double ramp = std::clamp((cosine - light.cos_outer) / width, 0.0, 1.0);
  return ramp * ramp;
}

}  // namespace

Lights::Lights(const Scene& scene) : scene_(scene) {
  double sum = 0.0;
  for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
    const Material& material = scene.material_of(i);
    if (!material.is_emissive()) continue;
    const double power = glm::length(half_area(scene.mesh, i)) * luminance(material.emission);
    if (!(power > 0.0) || !std::isfinite(power)) continue;
    sum += power;
    triangles_.push_back(static_cast<std::uint32_t>(i));
    powers_.push_back(sum);
  }
}

std::optional<Lights::Toward> Lights::toward(std::size_t i, const glm::dvec3& from) const {
  const Light& light = scene_.lights[i];
  const glm::dvec3 intensity(light.intensity);
  Toward out;
  if (light.kind == LightKind::Directional) {
    out.direction = -glm::dvec3(light.direction);
    out.irradiance = intensity;
  } else {
    const glm::dvec3 to = glm::dvec3(light.position) - from;
    const double distance2 = glm::dot(to, to);
    if (!(distance2 > 0.0)) return std::nullopt;
    const double distance = std::sqrt(distance2);
    out.direction = to / distance;
    out.irradiance = intensity * (window(distance, light.range) / distance2);
    if (light.kind == LightKind::Spot)
      out.irradiance *= cone(light, -glm::dot(out.direction, glm::dvec3(light.direction)));
  }
  if (out.irradiance == glm::dvec3(0.0) || !finite(out.irradiance)) return std::nullopt;
  return out;
}

Lights::End Lights::end_of(std::size_t i, const glm::vec3& origin, Format format) const {
  const Light& light = scene_.lights[i];
  if (light.kind == LightKind::Directional)
    return {.d = -light.direction, .tmax = std::numeric_limits<float>::infinity()};
  const glm::vec3 d = light.position - origin;
  const glm::dvec3 size = glm::abs(glm::dvec3(d));
  const glm::dvec3 reach =
      glm::max(glm::abs(glm::dvec3(light.position)), glm::abs(glm::dvec3(origin)));
  // A wall through the light, its vertices rounded to the format, is off by half a unit in the last
  // place of their coordinates on each axis, and so are both ends of the ray; t of the engine is
  // off by 6 units (docs/tree.md). 16 hold all of it, projected on a ray that meets the wall at an
  // angle above 15 degrees.
  const double unit = 2.0 * format.rounding_unit();
  // And its reciprocal by what that is off more than another operation.
  const double off = 2.0 * (format.reciprocal_unit() - format.rounding_unit());
  const double share = 16.0 * unit * (reach.x + reach.y + reach.z) / (size.x + size.y + size.z);
  return {.d = d, .tmax = static_cast<float>(1.0 - std::min(0.5, share + 8.0 * unit + off))};
}

std::optional<Lights::Point> Lights::sample(const glm::dvec3& from, const glm::dvec2& u) const {
  const auto chosen = std::upper_bound(powers_.begin(), powers_.end(), u.x * powers_.back());
  const std::size_t at = std::min<std::size_t>(static_cast<std::size_t>(chosen - powers_.begin()),
                                               triangles_.size() - 1);
  const double before = at == 0 ? 0.0 : powers_[at - 1];
  const double width = powers_[at] - before;
  const double rest = width > 0.0 ? (u.x * powers_.back() - before) / width : 0.0;
  const std::size_t prim = triangles_[at];
  const double root = std::sqrt(std::clamp(rest, 0.0, 1.0));
  const auto b1 = static_cast<float>(root * (1.0 - u.y));
  const auto b2 = static_cast<float>(root * u.y);
  const glm::dvec3 p0 = scene_.mesh.vertex(prim, 0);
  const glm::dvec3 p = p0 + double(b1) * (glm::dvec3(scene_.mesh.vertex(prim, 1)) - p0) +
                       double(b2) * (glm::dvec3(scene_.mesh.vertex(prim, 2)) - p0);
  Point out;
  out.hit = {.t = 1.0F, .u = b1, .v = b2, .prim = static_cast<std::int32_t>(prim)};
  out.density = density(prim, from, p);
  if (!(out.density > 0.0) || !std::isfinite(out.density)) return std::nullopt;
  out.direction = glm::normalize(p - from);
  out.emission = scene_.material_of(prim).emission;
  return out;
}

double Lights::density(std::size_t prim, const glm::dvec3& from, const glm::dvec3& at) const {
  const double light = luminance(scene_.material_of(prim).emission);
  if (!(light > 0.0) || triangles_.empty()) return 0.0;
  // Chosen by area times light, uniform over the area: light over the sum, a unit of area.
  const glm::dvec3 to = at - from;
  const double distance2 = glm::dot(to, to);
  const glm::dvec3 normal = area_vector(scene_.mesh, prim);
  const double length = glm::length(normal);
  if (!(length > 0.0) || !std::isfinite(length) || !(distance2 > 0.0)) return 0.0;
  const double cosine = std::abs(glm::dot(normal, to)) / (length * std::sqrt(distance2));
  if (!(cosine > 0.0)) return 0.0;
  return light / powers_.back() * distance2 / cosine;
}

bool is_unlit(const Scene& scene) {
  if (!scene.lights.empty() || scene.background != glm::vec3(0.0F)) return false;
  return !Lights(scene).has_area();
}

}  // namespace ti
