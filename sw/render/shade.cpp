// SPDX-License-Identifier: Apache-2.0
#include "render/shade.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/geometry.hpp"

namespace ti {

namespace {

constexpr glm::vec3 kBackground{0.30F, 0.36F, 0.44F};
constexpr float kAmbient = 0.07F;  ///< light from everywhere, beside lights of a middle exposure
constexpr float kFill = 0.15F;     ///< light from the eye, so that unlit surfaces keep their shape

/// Light that falls on a surface: inverse square, on the side that the ray sees only.
glm::vec3 incident(const Surface& surface, const std::vector<PointLight>& lights) {
  glm::dvec3 sum(0.0);
  for (const PointLight& light : lights) {
    const glm::dvec3 to = glm::dvec3(light.position) - surface.position;
    const double d2 = glm::dot(to, to);
    const double cosine = glm::dot(surface.normal, to);
    if (cosine > 0.0) sum += glm::dvec3(light.intensity) * (cosine / (d2 * std::sqrt(d2)));
  }
  return glm::vec3(sum);
}

/// Bright colours bend towards 1 in place of breaking off there: 1 - exp(-x) from 0.5 on,
/// continuous in value and slope.
glm::vec3 shoulder(const glm::vec3& c) {
  const auto bend = [](float x) {
    return x <= 0.5F ? x : 1.0F - 0.5F * std::exp(-2.0F * (x - 0.5F));
  };
  return {bend(c.x), bend(c.y), bend(c.z)};
}

}  // namespace

std::vector<glm::vec3> shade(const Scene& scene, std::span<const Ray> rays,
                             std::span<const Hit> hits) {
  std::vector<glm::vec3> out(hits.size(), kBackground);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i].is_hit()) continue;
    const Surface surface = surface_at(scene.mesh, rays[i], hits[i]);
    const auto prim = static_cast<std::size_t>(hits[i].prim);
    const Material& material =
        scene.materials[scene.mesh.material.empty() ? 0 : scene.mesh.material[prim]];
    const glm::dvec3 view = -glm::normalize(glm::dvec3(rays[i].d));
    const auto facing = static_cast<float>(glm::dot(surface.normal, view));
    const glm::vec3 light =
        scene.lights.empty() ? glm::vec3(facing) : incident(surface, scene.lights) + kFill * facing;
    const glm::vec3 reflected = shoulder(material.diffuse * (light + kAmbient));
    out[i] = glm::min(reflected + material.emission, glm::vec3(1.0F));
  }
  return out;
}

}  // namespace ti
