// SPDX-License-Identifier: Apache-2.0
#include "truth/exact_picture.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/limits.hpp"
#include "base/parallel.hpp"
#include "scene/geometry.hpp"
#include "scene/scaling.hpp"

namespace ti {
namespace {

constexpr std::size_t kPiece = 256;
constexpr std::size_t kSample = 64;
constexpr double kInFront = 0.02;  ///< of the distance, how far a point may lie behind a pixel's

}  // namespace

ExactPicture::ExactPicture(const Scene& scene, const ExactTracer& exact, int width, int height)
    : mesh_(scene.mesh), width_(width), height_(height), camera_(scene.camera, width, height) {
  check_ray_count("the picture", static_cast<std::uint64_t>(width),
                  static_cast<std::uint64_t>(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) rays_.push_back(camera_.at({x + 0.5, y + 0.5}));
  }
  hits_.resize(rays_.size());
  parallel_pieces(rays_.size(), kPiece, [this, &exact](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) hits_[i] = exact.trace(rays_[i]);
  });
  std::vector<double> distances;
  for (const ExactTracer::Hit& hit : hits_) {
    if (hit.hit) distances.push_back(hit.t);
  }
  if (!distances.empty()) {
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    if (*middle > 0.0) median_ = *middle;
  }
  for (std::size_t i = 0; i < rays_.size(); ++i)
    picture_.pixels.push_back(shade(i, hits_[i].hit ? hits_[i].prims.front() : -1, hits_[i].t));
}

glm::vec3 ExactPicture::shade(std::size_t pixel, std::int32_t prim, double t) const {
  if (prim < 0) return glm::vec3(0.0F);
  const glm::dvec3 normal = area_vector(mesh_, static_cast<std::size_t>(prim));
  const glm::dvec3 d(rays_[pixel].d);
  const double size = glm::length(normal) * glm::length(d);
  const double facing = size > 0.0 ? std::abs(glm::dot(normal, d)) / size : 0.0;
  const double away = t / median_;
  return glm::vec3(static_cast<float>(facing / (1.0 + away * away)));
}

std::optional<ShadedPicture> ExactPicture::of(const Tracer& model, const ScaledFormat& format,
                                              double most_work) const {
  const std::size_t stride = std::max<std::size_t>(1, rays_.size() / kSample);
  Work sampled;
  for (std::size_t i = stride / 2; i < rays_.size(); i += stride)
    (void)model.trace(scaled(rays_[i], format.scale), sampled);
  const double work = static_cast<double>(sampled.steps + sampled.a_tests);
  if (work * static_cast<double>(stride) > most_work) return {};

  ShadedPicture picture;
  picture.pixels.resize(rays_.size());
  std::atomic<std::uint64_t> wrong = 0;
  parallel_pieces(rays_.size(), kPiece, [&](std::size_t first, std::size_t last) {
    Work work;
    for (std::size_t i = first; i < last; ++i) {
      const HitBits bits = model.trace(scaled(rays_[i], format.scale), work);
      const Hit hit = scaled(hit_of(format.numbers, bits), -format.scale);
      const auto& prims = hits_[i].prims;
      const bool right =
          hit.is_hit() ? std::binary_search(prims.begin(), prims.end(), hit.prim) : !hits_[i].hit;
      if (!right) ++wrong;
      picture.pixels[i] = shade(i, hit.prim, double{hit.t});
    }
  });
  picture.wrong = wrong;
  return picture;
}

std::vector<ExactPicture::Place> ExactPicture::places_of(std::span<const glm::dvec3> points) const {
  std::vector<Place> places;
  for (const glm::dvec3& point : points) {
    const auto at = camera_.place_of(point);
    if (!at || !(at->x >= 0.0 && at->x < width_ && at->y >= 0.0 && at->y < height_)) continue;
    const std::size_t pixel = static_cast<std::size_t>(at->y) * static_cast<std::size_t>(width_) +
                              static_cast<std::size_t>(at->x);
    const ExactTracer::Hit& hit = hits_[pixel];
    const double distance = glm::distance(point, glm::dvec3(rays_[pixel].o));
    places.push_back({at->x, at->y, !hit.hit || distance <= (1.0 + kInFront) * hit.t});
  }
  return places;
}

}  // namespace ti
