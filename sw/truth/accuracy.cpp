// SPDX-License-Identifier: Apache-2.0
#include "truth/accuracy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
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
void judge(const Tracer& model, const CrackJudge& cracks, const Ray& ray, std::int32_t leaves,
           HitErrors& errors) {
  const Format& format = cracks.format();
  const HitBits hit = model.trace(ray, errors.work);
  const ExactTracer::Hit truth = cracks.exact().trace(ray);
  ++errors.rays;
  if (hit.status != Status::Ok) ++errors.failed;
  if (truth.hit) ++errors.exact_hits;
  if (hit.prim < 0) {
    if (!truth.hit) return;
    ++errors.missed;
    if (cracks.is_crack(ray, truth.t)) ++errors.cracks;
    return;
  }
  if (hit.prim == leaves) ++errors.self_hits;
  if (!truth.hit) {
    ++errors.false_hits;
  } else if (!std::binary_search(truth.prims.begin(), truth.prims.end(), hit.prim)) {
    ++errors.wrong;
    if (value_of_bits(format, hit.t) > truth.t + cracks.behind(ray)) {
      ++errors.through;
      if (cracks.is_crack(ray, truth.t)) ++errors.cracks;
    }
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
  through += other.through;
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

CrackJudge::CrackJudge(const ExactTracer& exact, const Mesh& mesh, const Format& format)
    : exact_(exact), format_(format) {
  const Bounds bounds = bounds_of(mesh).value_or(Bounds{});
  low_ = bounds.low;
  high_ = bounds.high;
  diagonal_ = bounds.diagonal();
}

double CrackJudge::farthest(const glm::dvec3& o) const {
  double farthest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    farthest =
        std::max({farthest, std::abs(low_[axis] - o[axis]), std::abs(high_[axis] - o[axis])});
  }
  return farthest;
}

double CrackJudge::behind(const Ray& ray) const {
  const double errors = 64.0 * format_.rounding_unit() * farthest(glm::dvec3(ray.o));
  return std::max(1e-3 * diagonal_, errors) / glm::length(glm::dvec3(ray.d));
}

bool CrackJudge::is_crack(const Ray& ray, double t) const {
  const glm::dvec3 o(ray.o);
  const glm::dvec3 d = glm::normalize(glm::dvec3(ray.d));
  const glm::dvec3 other = std::abs(d.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 side = glm::normalize(glm::cross(d, other));
  const glm::dvec3 up = glm::cross(d, side);
  // The corners of an octagon around the disc, so that no straight outline passes between them.
  const double around = 1.0 / std::cos(std::acos(-1.0) / 8.0);
  const double reach =
      around * (8.0 * format_.rounding_unit() + 2.0 * format_.reciprocal_unit()) * farthest(o);
  const double diagonal = std::sqrt(0.5);
  const std::array<std::array<double, 2>, 8> ways{{{1, 0},
                                                   {0, 1},
                                                   {-1, 0},
                                                   {0, -1},
                                                   {diagonal, diagonal},
                                                   {-diagonal, diagonal},
                                                   {diagonal, -diagonal},
                                                   {-diagonal, -diagonal}}};
  const double room = behind(ray);
  for (double distance = reach; distance > reach / 100.0; distance *= 0.5) {
    for (const auto& way : ways) {
      Ray moved = ray;
      moved.o = glm::vec3(o + distance * (way[0] * side + way[1] * up));
      const ExactTracer::Hit hit = exact_.trace(moved);
      if (!hit.hit || hit.t > t + room) return false;
    }
  }
  return true;
}

HitErrors hit_errors(const Tracer& model, const ExactTracer& exact, const Mesh& mesh,
                     const Format& format, const AimedRays& rays, std::uint64_t count) {
  const CrackJudge cracks(exact, mesh, format);
  return sum_of_pieces(count, [&](std::size_t first, std::size_t last) {
    HitErrors errors;
    for (std::size_t i = first; i < last; ++i) judge(model, cracks, rays(i), -1, errors);
    return errors;
  });
}

HitErrors secondary_errors(const Tracer& model, const ExactTracer& exact, const Mesh& mesh,
                           const ScaledFormat& format, const AimedRays& rays, std::uint64_t count,
                           std::uint64_t seed) {
  const CrackJudge cracks(exact, mesh, format.numbers);
  return sum_of_pieces(count, [&](std::size_t first, std::size_t last) {
    std::vector<Ray> given;
    std::vector<Hit> hits;
    Work before;
    for (std::size_t i = first; i < last; ++i) {
      const Hit hit = hit_of(format.numbers, model.trace(rays(i), before));
      if (!hit.is_hit()) continue;
      given.push_back(rays(i));
      hits.push_back(hit);
    }
    const std::vector<Ray> spawned = diffuse_rays(mesh, format, given, hits, seed ^ first);
    HitErrors errors;
    for (std::size_t i = 0; i < spawned.size(); ++i)
      judge(model, cracks, spawned[i], hits[i].prim, errors);
    return errors;
  });
}

}  // namespace ti
