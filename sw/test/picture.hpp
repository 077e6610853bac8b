// SPDX-License-Identifier: Apache-2.0
// Small scenes, and pictures of them traced by the model.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "accel/build.hpp"
#include "engine/lock_step.hpp"
#include "model/tracer.hpp"
#include "render/path.hpp"
#include "render/plan.hpp"

namespace ti::test {

/// Adds a quadrilateral a b c d of a material, its front where the corners run counterclockwise.
inline void add_quad(Scene& scene, const std::array<glm::vec3, 4>& corners,
                     std::uint16_t material) {
  const auto first = static_cast<std::uint32_t>(scene.mesh.vertices.size());
  scene.mesh.vertices.insert(scene.mesh.vertices.end(), corners.begin(), corners.end());
  scene.mesh.triangles.push_back({first, first + 1, first + 2});
  scene.mesh.triangles.push_back({first, first + 2, first + 3});
  scene.mesh.material.insert(scene.mesh.material.end(), {material, material});
}

/// Adds a box with its fronts outside.
inline void add_box(Scene& scene, const glm::vec3& lo, const glm::vec3& hi,
                    std::uint16_t material) {
  const auto p = [&](int x, int y, int z) {
    return glm::vec3(x != 0 ? hi.x : lo.x, y != 0 ? hi.y : lo.y, z != 0 ? hi.z : lo.z);
  };
  add_quad(scene, {p(0, 0, 0), p(0, 0, 1), p(0, 1, 1), p(0, 1, 0)}, material);
  add_quad(scene, {p(1, 0, 0), p(1, 1, 0), p(1, 1, 1), p(1, 0, 1)}, material);
  add_quad(scene, {p(0, 0, 0), p(1, 0, 0), p(1, 0, 1), p(0, 0, 1)}, material);
  add_quad(scene, {p(0, 1, 0), p(0, 1, 1), p(1, 1, 1), p(1, 1, 0)}, material);
  add_quad(scene, {p(0, 0, 0), p(0, 1, 0), p(1, 1, 0), p(1, 0, 0)}, material);
  add_quad(scene, {p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1)}, material);
}

struct Picture {
  std::vector<glm::vec3> radiance;
  RayCounts rays{};
  DimPaths dim_paths{};
  Plan plan;

  [[nodiscard]] std::uint64_t count(RayKind kind) const {
    return rays[static_cast<std::size_t>(kind)];
  }
  [[nodiscard]] glm::dvec3 mean() const {
    glm::dvec3 sum(0.0);
    for (const glm::vec3& c : radiance) sum += glm::dvec3(c);
    return sum / static_cast<double>(radiance.size());
  }
};

inline Picture picture_of(const Scene& scene, const FilmSize& size, const std::string& effects) {
  BuildStats stats;
  const Image image = build_image(scene.mesh, {}, stats);
  const auto model = Tracer::create(image, {});
  Picture out;
  out.plan = make_plan(scene, size, EffectRequest::of(effects));
  PathTracer tracer(scene,
                    {.width = size.width,
                     .height = size.height,
                     .spp = size.spp,
                     .bounces = size.bounces,
                     .effects = out.plan.effects,
                     .everything = out.plan.everything,
                     .ends_dim_paths = out.plan.ends_dim_paths},
                    [&](std::span<const Ray> rays, std::span<const std::uint32_t>) {
                      std::vector<Hit> hits;
                      for (const HitBits& bits : run_model(*model, rays).hits)
                        hits.push_back(hit_of({}, bits));
                      return hits;
                    });
  Film film(size.width, size.height);
  tracer.render(film);
  out.radiance = film.radiance();
  out.rays = tracer.rays();
  out.dim_paths = tracer.dim_paths();
  return out;
}

}  // namespace ti::test
