// SPDX-License-Identifier: Apache-2.0
#include "truth/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <mutex>
#include <optional>
#include <utility>

#include "base/parallel.hpp"
#include "scene/geometry.hpp"
#include "scene/rays.hpp"

namespace ti {
namespace {

constexpr std::uint64_t kPiece = 4096;

/// One unit in the last place of `value` in the format.
double ulp_of(const Format& format, double value) {
  const double size = std::max(std::abs(value), format.least_normal());
  return std::ldexp(1.0, std::ilogb(size) - format.frac_bits);
}

/// What is right for one ray; whether a hit that is not there is a crack is found once, when asked.
class RightHit {
 public:
  RightHit(const CrackJudge& cracks, const Ray& ray)
      : cracks_(cracks), ray_(ray), truth_(cracks.exact().trace(ray)) {}

  /// Adds what became of the ray on a model; `leaves` is the triangle that it starts from, or -1.
  void judge(const Tracer& model, std::int32_t leaves, HitErrors& errors);

 private:
  bool is_crack() {
    if (!crack_) crack_ = cracks_.is_crack(ray_, truth_.t);
    return *crack_;
  }

  const CrackJudge& cracks_;
  const Ray& ray_;
  ExactTracer::Hit truth_;
  std::optional<bool> crack_;
};

void RightHit::judge(const Tracer& model, std::int32_t leaves, HitErrors& errors) {
  const Format& format = cracks_.format();
  const HitBits hit = model.trace(ray_, errors.work);
  ++errors.rays;
  if (hit.status != Status::Ok) ++errors.failed;
  if (truth_.hit) ++errors.exact_hits;
  if (hit.prim < 0) {
    if (!truth_.hit) return;
    ++errors.missed;
    if (is_crack()) ++errors.cracks;
    return;
  }
  if (hit.prim == leaves) ++errors.self_hits;
  if (!truth_.hit) {
    ++errors.false_hits;
  } else if (!std::binary_search(truth_.prims.begin(), truth_.prims.end(), hit.prim)) {
    ++errors.wrong;
    if (value_of_bits(format, hit.t) > truth_.t + cracks_.behind(ray_)) {
      ++errors.through;
      if (is_crack()) ++errors.cracks;
    }
  } else if (errors.t_ulps.size() < kMostErrors) {
    const double t = value_of_bits(format, hit.t);
    errors.t_ulps.push_back(static_cast<float>(std::abs(t - truth_.t) / ulp_of(format, truth_.t)));
  }
}

using ManyErrors = std::vector<HitErrors>;

/// The sum of `work(first, last, errors)` over pieces of [0, count), for so many models.
ManyErrors sum_of_pieces(std::uint64_t count, std::size_t models,
                         const std::function<void(std::size_t, std::size_t, ManyErrors&)>& work) {
  ManyErrors sum(models);
  std::mutex mutex;
  parallel_pieces(count, kPiece, [&](std::size_t first, std::size_t last) {
    ManyErrors mine(models);
    work(first, last, mine);
    const std::lock_guard lock(mutex);
    for (std::size_t m = 0; m < models; ++m) sum[m] += mine[m];
  });
  for (HitErrors& errors : sum) std::sort(errors.t_ulps.begin(), errors.t_ulps.end());
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
  const double reach =
      (8.0 * format_.rounding_unit() + 2.0 * format_.reciprocal_unit()) * farthest(o);
  const double limit = t + behind(ray);
  std::vector<std::uint32_t> near;
  const auto all_hit = [&](int quarter) {
    // The corners of polygons around the discs, so that no straight outline passes between them:
    // those of slope s = i / quarter at half their angle, which no trigonometry rounds.
    const double around = std::sqrt(1.0 + 1.0 / (quarter * quarter));
    for (double distance = around * reach; distance > reach / 100.0; distance *= 0.5) {
      for (int way = 0; way < 4 * quarter; ++way) {
        const double s = static_cast<double>(way % quarter) / quarter;
        double x = (1.0 - s * s) / (1.0 + s * s);
        double y = 2.0 * s / (1.0 + s * s);
        if (way / quarter % 2 != 0) x = -std::exchange(y, x);
        if (way / quarter / 2 != 0) x = -x, y = -y;
        Ray moved = ray;
        moved.o = glm::vec3(o + distance * (x * side + y * up));
        if (!exact_.reaches(moved, limit, near)) return false;
      }
    }
    return true;
  };
  return all_hit(2) && all_hit(8);
}

std::vector<HitErrors> hit_errors(const std::vector<const Tracer*>& models,
                                  const ExactTracer& exact, const Mesh& mesh, const Format& format,
                                  const AimedRays& rays, std::uint64_t count) {
  const CrackJudge cracks(exact, mesh, format);
  return sum_of_pieces(count, models.size(),
                       [&](std::size_t first, std::size_t last, ManyErrors& errors) {
                         for (std::size_t i = first; i < last; ++i) {
                           const Ray ray = rays(i);
                           RightHit right(cracks, ray);
                           for (std::size_t m = 0; m < models.size(); ++m)
                             right.judge(*models[m], -1, errors[m]);
                         }
                       });
}

HitErrors secondary_errors(const Tracer& model, const ExactTracer& exact, const Mesh& mesh,
                           const Format& format, const AimedRays& rays, std::uint64_t count,
                           std::uint64_t seed) {
  const CrackJudge cracks(exact, mesh, format);
  const auto piece = [&](std::size_t first, std::size_t last, ManyErrors& errors) {
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
    for (std::size_t i = 0; i < spawned.size(); ++i)
      RightHit(cracks, spawned[i]).judge(model, hits[i].prim, errors.front());
  };
  return sum_of_pieces(count, 1, piece).front();
}

}  // namespace ti
