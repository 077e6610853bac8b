// SPDX-License-Identifier: Apache-2.0
#include "scene/rays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "scene/camera.hpp"
#include "scene/geometry.hpp"
#include "scene/random.hpp"

namespace ti {

namespace {

constexpr int kMaxSpp = 65536;
constexpr float kShadowEnd = 0.999F;

std::uint64_t hits_in(std::span<const Hit> hits) {
  return static_cast<std::uint64_t>(
      std::count_if(hits.begin(), hits.end(), [](const Hit& hit) { return hit.is_hit(); }));
}

/// The largest divisor of `n` that is not above its square root: the columns of an even grid of n
/// strata.
int strata_columns(int n) {
  int columns = 1;
  for (int c = 2; c * c <= n; ++c) {
    if (n % c == 0) columns = c;
  }
  return columns;
}

}  // namespace

PrimaryRays primary_rays(const Camera& camera, int width, int height, int spp, std::uint64_t seed) {
  const CameraRays camera_rays(camera, width, height);
  if (spp < 1 || spp > kMaxSpp) {
    throw Error(fmt::format("{} rays a pixel are not possible; choose 1 to {}", spp, kMaxSpp));
  }
  check_ray_count(fmt::format("SIZE={}x{} SPP={}", width, height, spp),
                  static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height),
                  static_cast<std::uint64_t>(spp));
  const int columns = strata_columns(spp);
  const int rows = spp / columns;

  PrimaryRays out;
  const std::vector<std::uint32_t> order = morton_order(width, height);
  out.rays.reserve(order.size() * static_cast<std::size_t>(spp));
  out.index.reserve(out.rays.capacity());
  for (const std::uint32_t pixel : order) {
    const auto w = static_cast<std::uint32_t>(width);
    const glm::dvec2 corner(pixel % w, pixel / w);
    Random random(seed, pixel);
    for (int s = 0; s < spp; ++s) {
      glm::dvec2 place(0.5);
      if (spp > 1) {
        place.x = (s % columns + random.uniform()) / columns;
        place.y = (static_cast<double>(s / columns) + random.uniform()) / rows;
      }
      out.rays.push_back(camera_rays.at(corner + place));
      out.index.push_back(pixel);
    }
  }
  return out;
}

std::vector<Ray> ao_rays(const Mesh& mesh, const ScaledFormat& format, std::span<const Ray> rays,
                         std::span<const Hit> hits, int samples, float radius, std::uint64_t seed) {
  check_ray_count("ambient occlusion", hits_in(hits), static_cast<std::uint64_t>(samples));
  std::vector<Ray> out;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i].is_hit()) continue;
    const Departure s = departure(mesh, rays[i], hits[i], format);
    Random random(seed, i);
    for (int k = 0; k < samples; ++k) {
      out.push_back(
          {.o = s.origin, .d = glm::vec3(random.cosine(s.normal)), .tmax = radius, .any = true});
    }
  }
  return out;
}

std::vector<Ray> diffuse_rays(const Mesh& mesh, const ScaledFormat& format,
                              std::span<const Ray> rays, std::span<const Hit> hits,
                              std::uint64_t seed) {
  std::vector<Ray> out;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i].is_hit()) continue;
    const Departure s = departure(mesh, rays[i], hits[i], format);
    out.push_back({.o = s.origin, .d = glm::vec3(Random(seed, i).cosine(s.normal))});
  }
  return out;
}

std::vector<Ray> shadow_rays(const Mesh& mesh, const ScaledFormat& format,
                             std::span<const Ray> rays, std::span<const Hit> hits,
                             std::span<const glm::vec3> lights) {
  check_ray_count("shadows", hits_in(hits), lights.size());
  std::vector<Ray> out;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i].is_hit()) continue;
    const Departure s = departure(mesh, rays[i], hits[i], format);
    for (const glm::vec3& light : lights) {
      Ray ray{.o = s.origin, .d = light - s.origin, .tmax = kShadowEnd, .any = true};
      if (ray.d == glm::vec3(0.0F)) {  // the light is the point itself: nothing can be between
        ray.d = glm::vec3(s.normal);
        ray.tmax = 0.0F;
      }
      out.push_back(ray);
    }
  }
  return out;
}

std::vector<glm::vec3> light_places(const Scene& scene) {
  std::vector<glm::vec3> places;
  for (const Light& light : scene.lights) {
    if (light.kind != LightKind::Directional) places.push_back(light.position);
  }
  const auto bounds = bounds_of(scene.mesh);
  if (!bounds) return places;
  struct Sum {
    double area = 0.0;
    glm::dvec3 moment{0.0};
  };
  std::vector<Sum> sums(scene.materials.size());
  for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
    if (!scene.material_of(i).is_emissive()) continue;
    const double area = 0.5 * glm::length(area_vector(scene.mesh, i));
    if (!std::isfinite(area)) continue;
    const auto p = scene.mesh.corners(i);
    Sum& sum = sums[scene.mesh.material.empty() ? 0 : scene.mesh.material[i]];
    sum.area += area;
    sum.moment += area * (glm::dvec3(p[0]) + glm::dvec3(p[1]) + glm::dvec3(p[2])) / 3.0;
  }
  for (const Sum& sum : sums) {
    if (!(sum.area > 0.0)) continue;
    glm::dvec3 place = sum.moment / sum.area;
    const glm::dvec3 inward = bounds->centre() - place;
    const double distance = glm::length(inward);
    if (distance > 0.0) place += inward * (1e-3 * bounds->diagonal() / distance);
    places.emplace_back(place);
  }
  return places;
}

std::vector<Ray> random_rays(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
  const Bounds bounds = bounds_of(mesh).value_or(Bounds{});
  const double radius = bounds.diagonal() > 0.0 ? 0.6 * bounds.diagonal() : 1.0;
  std::vector<Ray> out;
  out.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    Random random(seed, i);
    const glm::dvec3 o = bounds.centre() + radius * random.ball();
    out.push_back({.o = glm::vec3(o), .d = glm::vec3(glm::normalize(random.ball()))});
  }
  return out;
}

std::vector<Ray> inside_rays(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
  const Bounds bounds = bounds_of(mesh).value_or(Bounds{});
  std::vector<Ray> out;
  out.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    Random random(seed, i);
    const glm::dvec3 place{random.uniform(), random.uniform(), random.uniform()};
    const glm::dvec3 o = bounds.low + place * (bounds.high - bounds.low);
    out.push_back({.o = glm::vec3(o), .d = glm::vec3(glm::normalize(random.ball()))});
  }
  return out;
}

}  // namespace ti
