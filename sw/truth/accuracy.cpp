// SPDX-License-Identifier: Apache-2.0
#include "truth/accuracy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <mutex>

#include "base/parallel.hpp"
#include "scene/geometry.hpp"
#include "scene/rays.hpp"

namespace ti {
namespace {

constexpr std::uint64_t kPiece = 4096;

/// One unit in the last place of `value` in the format.
double ulp_of(const Format& format, double value) {
  const double size = std::max(std::abs(value), format.least_normal());
  return std::exp2(std::floor(std::log2(size)) - format.frac_bits);
}

/// Adds what became of one ray.
void judge(const Tracer& model, const ExactTracer& exact, const Mesh& mesh, const Format& format,
           const Ray& ray, std::int32_t leaves, HitErrors& errors) {
  const HitBits hit = model.trace(ray, errors.work);
  const ExactTracer::Hit truth = exact.trace(ray);
  ++errors.rays;
  if (hit.status != Status::Ok) ++errors.failed;
  if (truth.hit) ++errors.exact_hits;
  if (hit.prim < 0) {
    if (!truth.hit) return;
    ++errors.missed;
    if (is_crack(exact, mesh, format, ray)) ++errors.cracks;
    return;
  }
  if (hit.prim == leaves) ++errors.self_hits;
  if (!truth.hit) {
    ++errors.false_hits;
  } else if (!std::binary_search(truth.prims.begin(), truth.prims.end(), hit.prim)) {
    ++errors.wrong;
  } else if (errors.t_ulps.size() < kMostErrors) {
    const double t = value_of_bits(format, hit.t);
    errors.t_ulps.push_back(static_cast<float>(std::abs(t - truth.t) / ulp_of(format, truth.t)));
  }
}

/// The sum of `work(first, last)` over pieces of [0, count).
HitErrors sum_of_pieces(std::uint64_t count,
                        const std::function<HitErrors(std::size_t, std::size_t)>& work) {
  HitErrors sum;
  std::mutex mutex;
  parallel_pieces(count, kPiece, [&](std::size_t first, std::size_t last) {
    const HitErrors mine = work(first, last);
    const std::lock_guard lock(mutex);
    sum += mine;
  });
  std::sort(sum.t_ulps.begin(), sum.t_ulps.end());
  return sum;
}

}  // namespace

HitErrors& HitErrors::operator+=(const HitErrors& other) {
  rays += other.rays;
  exact_hits += other.exact_hits;
  missed += other.missed;
  cracks += other.cracks;
  false_hits += other.false_hits;
  wrong += other.wrong;
  self_hits += other.self_hits;
  failed += other.failed;
  work += other.work;
  const std::size_t room = kMostErrors - std::min(kMostErrors, t_ulps.size());
  const auto end =
      other.t_ulps.begin() + static_cast<std::ptrdiff_t>(std::min(room, other.t_ulps.size()));
  t_ulps.insert(t_ulps.end(), other.t_ulps.begin(), end);
  return *this;
}

bool is_crack(const ExactTracer& exact, const Mesh& mesh, const Format& format, const Ray& ray) {
  const Bounds bounds = bounds_of(mesh).value_or(Bounds{});
  const glm::dvec3 o(ray.o);
  double farthest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    farthest = std::max(
        {farthest, std::abs(bounds.low[axis] - o[axis]), std::abs(bounds.high[axis] - o[axis])});
  }
  const glm::dvec3 d = glm::normalize(glm::dvec3(ray.d));
  const glm::dvec3 other = std::abs(d.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 side = glm::normalize(glm::cross(d, other));
  const glm::dvec3 up = glm::cross(d, side);
  const double reach = (8.0 * format.rounding_unit() + 2.0 * format.reciprocal_unit()) * farthest;
  const double diagonal = std::sqrt(0.5);
  const std::array<std::array<double, 2>, 8> ways{{{1, 0},
                                                   {0, 1},
                                                   {-1, 0},
                                                   {0, -1},
                                                   {diagonal, diagonal},
                                                   {-diagonal, diagonal},
                                                   {diagonal, -diagonal},
                                                   {-diagonal, -diagonal}}};
  for (double distance = reach; distance > reach / 100.0; distance *= 0.5) {
    for (const auto& way : ways) {
      Ray moved = ray;
      moved.o = glm::vec3(o + distance * (way[0] * side + way[1] * up));
      if (!exact.trace(moved).hit) return false;
    }
  }
  return true;
}

HitErrors hit_errors(const Tracer& model, const ExactTracer& exact, const Mesh& mesh,
                     const Format& format, const AimedRays& rays, std::uint64_t count) {
  return sum_of_pieces(count, [&](std::size_t first, std::size_t last) {
    HitErrors errors;
    for (std::size_t i = first; i < last; ++i)
      judge(model, exact, mesh, format, rays(i), -1, errors);
    return errors;
  });
}

HitErrors secondary_errors(const Tracer& model, const ExactTracer& exact, const Mesh& mesh,
                           const Format& format, const AimedRays& rays, std::uint64_t count,
                           std::uint64_t seed) {
  return sum_of_pieces(count, [&](std::size_t first, std::size_t last) {
    std::vector<Ray> given;
    std::vector<Hit> hits;
    Work before;
    for (std::size_t i = first; i < last; ++i) {
      const Hit hit = hit_of(format, model.trace(rays(i), before));
      if (!hit.is_hit()) continue;
      given.push_back(rays(i));
      hits.push_back(hit);
    }
    const std::vector<Ray> spawned = diffuse_rays(mesh, format, given, hits, seed ^ first);
    HitErrors errors;
    for (std::size_t i = 0; i < spawned.size(); ++i)
      judge(model, exact, mesh, format, spawned[i], hits[i].prim, errors);
    return errors;
  });
}

}  // namespace ti
