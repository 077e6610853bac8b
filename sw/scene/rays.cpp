// SPDX-License-Identifier: Apache-2.0
#include "scene/rays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "scene/geometry.hpp"
#include "scene/random.hpp"

namespace ti {

namespace {

constexpr int kMaxSpp = 65536;
constexpr float kShadowEnd = 0.999F;

/// The even bits of a Morton code, packed.
std::uint32_t even_bits(std::uint32_t code) {
  code &= 0x55555555U;
  code = (code | code >> 1) & 0x33333333U;
  code = (code | code >> 2) & 0x0F0F0F0FU;
  code = (code | code >> 4) & 0x00FF00FFU;
  return (code | code >> 8) & 0x0000FFFFU;
}

std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 8) & 0x00FF00FFU;
  x = (x | x << 4) & 0x0F0F0F0FU;
  x = (x | x << 2) & 0x33333333U;
  return (x | x << 1) & 0x55555555U;
}

std::vector<std::uint32_t> morton_codes(std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint32_t> codes;
  codes.reserve(static_cast<std::size_t>(width) * height);
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      codes.push_back(spread(x) | spread(y) << 1);
    }
  }
  std::sort(codes.begin(), codes.end());
  return codes;
}

/// Three vectors with eye + x * right + y * up + forward on the image plane at distance 1.
struct Frame {
  glm::dvec3 right;
  glm::dvec3 up;
  glm::dvec3 forward;
};

Frame frame_of(const Camera& camera) {
  const glm::dvec3 forward = glm::dvec3(camera.target) - glm::dvec3(camera.eye);
  const double distance = glm::length(forward);
  if (!(distance > 0.0) || !std::isfinite(distance)) {
    throw Error("the camera has no direction; choose a finite target that is not the eye");
  }
  if (!(camera.fov_y_deg > 0.0F && camera.fov_y_deg < 180.0F)) {
    throw Error(fmt::format("the camera's field of view is {} degrees; choose one inside 0 to 180",
                            camera.fov_y_deg));
  }
  Frame f;
  f.forward = forward / distance;
  f.right = glm::cross(f.forward, glm::dvec3(camera.up));
  if (!(glm::length(f.right) > 1e-6 * glm::length(glm::dvec3(camera.up)))) {
    // `up` is zero or along the view: take the coordinate axis that is the least along it.
    const glm::dvec3 a = glm::abs(f.forward);
    const glm::dvec3 axis = a.x <= a.y && a.x <= a.z ? glm::dvec3(1, 0, 0)
                            : a.y <= a.z             ? glm::dvec3(0, 1, 0)
                                                     : glm::dvec3(0, 0, 1);
    f.right = glm::cross(f.forward, axis);
  }
  f.right = glm::normalize(f.right);
  f.up = glm::cross(f.right, f.forward);
  return f;
}

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
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    throw Error(fmt::format("a picture of {}x{} is not possible; choose 1 to {} a side", width,
                            height, kMaxSide));
  }
  if (spp < 1 || spp > kMaxSpp) {
    throw Error(fmt::format("{} rays a pixel are not possible; choose 1 to {}", spp, kMaxSpp));
  }
  check_ray_count(fmt::format("SIZE={}x{} SPP={}", width, height, spp),
                  static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height),
                  static_cast<std::uint64_t>(spp));
  const Frame frame = frame_of(camera);
  constexpr double kHalfRadian = 3.14159265358979323846 / 360.0;
  const double half_height = std::tan(static_cast<double>(camera.fov_y_deg) * kHalfRadian);
  const double half_width = half_height * width / height;
  const int columns = strata_columns(spp);
  const int rows = spp / columns;

  PrimaryRays out;
  const auto codes =
      morton_codes(static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height));
  out.rays.reserve(codes.size() * static_cast<std::size_t>(spp));
  out.index.reserve(out.rays.capacity());
  for (const std::uint32_t code : codes) {
    const std::uint32_t x = even_bits(code);
    const std::uint32_t y = even_bits(code >> 1);
    const std::uint32_t pixel = y * static_cast<std::uint32_t>(width) + x;
    Random random(seed, pixel);
    for (int s = 0; s < spp; ++s) {
      const double jx = spp == 1 ? 0.5 : (s % columns + random.uniform()) / columns;
      const double jy =
          spp == 1 ? 0.5 : (static_cast<double>(s / columns) + random.uniform()) / rows;
      const double px = (2.0 * (x + jx) / width - 1.0) * half_width;
      const double py = (1.0 - 2.0 * (y + jy) / height) * half_height;
      Ray ray;
      ray.o = camera.eye;
      ray.d = glm::vec3(glm::normalize(frame.forward + px * frame.right + py * frame.up));
      out.rays.push_back(ray);
      out.index.push_back(pixel);
    }
  }
  return out;
}

std::vector<Ray> ao_rays(const Mesh& mesh, Format format, std::span<const Ray> rays,
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

std::vector<Ray> diffuse_rays(const Mesh& mesh, Format format, std::span<const Ray> rays,
                              std::span<const Hit> hits, std::uint64_t seed) {
  std::vector<Ray> out;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i].is_hit()) continue;
    const Departure s = departure(mesh, rays[i], hits[i], format);
    out.push_back({.o = s.origin, .d = glm::vec3(Random(seed, i).cosine(s.normal))});
  }
  return out;
}

std::vector<Ray> shadow_rays(const Mesh& mesh, Format format, std::span<const Ray> rays,
                             std::span<const Hit> hits, std::span<const PointLight> lights) {
  check_ray_count("shadows", hits_in(hits), lights.size());
  std::vector<Ray> out;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i].is_hit()) continue;
    const Departure s = departure(mesh, rays[i], hits[i], format);
    for (const PointLight& light : lights) {
      Ray ray{.o = s.origin, .d = light.position - s.origin, .tmax = kShadowEnd, .any = true};
      if (ray.d == glm::vec3(0.0F)) {  // the light is the point itself: nothing can be between
        ray.d = glm::vec3(s.normal);
        ray.tmax = 0.0F;
      }
      out.push_back(ray);
    }
  }
  return out;
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
    const glm::dvec3 place(random.uniform(), random.uniform(), random.uniform());
    const glm::dvec3 o = bounds.low + place * (bounds.high - bounds.low);
    out.push_back({.o = glm::vec3(o), .d = glm::vec3(glm::normalize(random.ball()))});
  }
  return out;
}

}  // namespace ti
