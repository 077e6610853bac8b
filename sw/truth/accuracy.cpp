// SPDX-License-Identifier: Apache-2.0
#include "truth/accuracy.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>

#include "base/parallel.hpp"
#include "scene/rays.hpp"
#include "truth/crack_judge.hpp"

namespace ti {
namespace {

constexpr std::uint64_t kPiece = 16;
constexpr std::uint64_t kFirstRays = 32;  ///< before it is known how much work they are

/// One unit in the last place of `value` in the format.
double ulp_of(const Format& format, double value) {
  const double size = std::max(std::abs(value), format.least_normal());
  return std::ldexp(1.0, std::ilogb(size) - format.frac_bits);
}

/// A ray, its exact hit, and when it was asked for the sheet that no engine may pass.
struct ExactRay {
  Ray ray;
  ExactTracer::Hit hit;
  std::optional<CrackJudge::Sheet> sheet;
};

/// A ray of a model, and the triangle that it leaves, -1 for none.
struct Leaving {
  Ray ray;
  std::int32_t prim = -1;
};

/// Adds what became of one ray.
void judge(const Tracer& model, const CrackJudge& cracks, ExactRay& known, const Leaving& leaving,
           std::uint64_t index, HitErrors& errors) {
  using Clock = std::chrono::steady_clock;
  const Format& format = cracks.format();
  const Ray& ray = known.ray;
  const ExactTracer::Hit& truth = known.hit;
  const auto begin = Clock::now();
  const HitBits hit = model.trace(ray, errors.work);
  errors.seconds += std::chrono::duration<double>(Clock::now() - begin).count();
  // Of an engine that hits nothing nearer than `t`.
  const auto look_for_crack = [&](double t) {
    if (!known.sheet) known.sheet = cracks.sheet(ray, truth);
    const std::vector<std::int32_t>& sheet = known.sheet->triangles;
    if (sheet.empty() || t <= known.sheet->end + cracks.behind(ray)) return;
    if (std::binary_search(sheet.begin(), sheet.end(), hit.prim)) return;
    ++errors.cracks;
    errors.crack_places.push_back({index, glm::dvec3(ray.o) + truth.t * glm::dvec3(ray.d)});
  };
  ++errors.rays;
  if (truth.hit) ++errors.exact_hits;
  if (hit.status != Status::Ok) {
    ++errors.failed;
    return;
  }
  if (hit.prim < 0) {
    if (!truth.hit) return;
    ++errors.missed;
    look_for_crack(std::numeric_limits<double>::infinity());
    return;
  }
  if (hit.prim == leaving.prim) ++errors.self_hits;
  if (!truth.hit) {
    ++errors.false_hits;
    return;
  }
  const auto at = std::lower_bound(truth.prims.begin(), truth.prims.end(), hit.prim);
  if (at == truth.prims.end() || *at != hit.prim) {
    ++errors.wrong;
    const double t = value_of_bits(format, hit.t);
    if (t > truth.t + cracks.behind(ray)) {
      ++errors.through;
      look_for_crack(t);
    }
  } else if (errors.t_ulps.size() < kMostErrors) {
    const glm::dvec2 weights = truth.weights[static_cast<std::size_t>(at - truth.prims.begin())];
    const auto off = [&format](std::uint32_t bits, double value, double unit) {
      return static_cast<float>(std::abs(value_of_bits(format, bits) - value) / unit);
    };
    const double last_place = std::ldexp(1.0, -format.frac_bits - 1);
    errors.t_ulps.push_back(off(hit.t, truth.t, ulp_of(format, truth.t)));
    errors.u_ulps.push_back(off(hit.u, weights.x, last_place));
    errors.v_ulps.push_back(off(hit.v, weights.y, last_place));
  }
}

/// What a model traces for a number, if anything.
using RayOf = std::function<std::optional<Leaving>(const Tracer&, std::uint64_t)>;

/// Adds the errors of each model for numbers [begin, end).
void add_errors(std::span<const Tracer* const> models, const ExactTracer& exact,
                const CrackJudge& cracks, std::uint64_t begin, std::uint64_t end,
                const RayOf& ray_of, std::vector<HitErrors>& sums) {
  std::mutex mutex;
  parallel_pieces(end - begin, kPiece, [&](std::size_t first, std::size_t last) {
    std::vector<HitErrors> mine(models.size());
    std::vector<ExactRay> known;
    for (std::uint64_t i = begin + first; i < begin + last; ++i) {
      known.clear();
      for (std::size_t m = 0; m < models.size(); ++m) {
        const std::optional<Leaving> leaving = ray_of(*models[m], i);
        if (!leaving) continue;
        const Ray& ray = leaving->ray;
        auto same = std::find_if(known.begin(), known.end(), [&ray](const ExactRay& other) {
          return other.ray.o == ray.o && other.ray.d == ray.d;
        });
        if (same == known.end()) {
          known.push_back({ray, exact.trace(ray), {}});
          same = known.end() - 1;
        }
        judge(*models[m], cracks, *same, *leaving, i, mine[m]);
      }
    }
    const std::lock_guard lock(mutex);
    for (std::size_t m = 0; m < models.size(); ++m) sums[m] += mine[m];
  });
}

/// The errors of each model for the numbers of `most`: all of them, or as many as the work allows,
/// judged by those before.
std::vector<HitErrors> errors_of(std::span<const Tracer* const> models, const ExactTracer& exact,
                                 const CrackJudge& cracks, const MostRays& most,
                                 const RayOf& ray_of) {
  std::vector<HitErrors> sums(models.size());
  std::uint64_t done = 0;
  std::uint64_t next = std::min(most.count, kFirstRays);
  while (next > 0) {
    add_errors(models, exact, cracks, done, done + next, ray_of, sums);
    done += next;
    double work = 0.0;
    for (const HitErrors& sum : sums)
      work += static_cast<double>(sum.work.steps + sum.work.a_tests);
    const double a_ray = std::max(work, 1.0) / static_cast<double>(done);
    const double allowed = std::max(0.0, most.work - work) / a_ray;
    next = std::min(most.count - done, 8 * done);
    if (allowed < static_cast<double>(next)) next = static_cast<std::uint64_t>(allowed);
    if (next < done / 64 && next < most.count - done) break;
  }
  for (HitErrors& sum : sums) sum.sort();
  return sums;
}

/// Puts errors of other rays behind those that are there, while there is room.
void append(std::vector<float>& errors, const std::vector<float>& more) {
  const std::size_t room = kMostErrors - std::min(kMostErrors, errors.size());
  const auto end = more.begin() + static_cast<std::ptrdiff_t>(std::min(room, more.size()));
  errors.insert(errors.end(), more.begin(), end);
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
  seconds += other.seconds;
  append(t_ulps, other.t_ulps);
  append(u_ulps, other.u_ulps);
  append(v_ulps, other.v_ulps);
  crack_places.insert(crack_places.end(), other.crack_places.begin(), other.crack_places.end());
  if (crack_places.size() > 16 * kMostPlaces) sort_places();
  return *this;
}

void HitErrors::sort_places() {
  std::sort(crack_places.begin(), crack_places.end(),
            [](const CrackPlace& a, const CrackPlace& b) { return a.ray < b.ray; });
  if (crack_places.size() > kMostPlaces) crack_places.resize(kMostPlaces);
}

void HitErrors::sort() {
  for (std::vector<float>* errors : {&t_ulps, &u_ulps, &v_ulps})
    std::sort(errors->begin(), errors->end());
  sort_places();
}

std::vector<HitErrors> hit_errors(std::span<const Tracer* const> models, const ExactTracer& exact,
                                  const Mesh& mesh, const Format& format, const AimedRays& rays,
                                  const MostRays& most) {
  return errors_of(
      models, exact, CrackJudge(mesh, format), most,
      [&rays](const Tracer&, std::uint64_t i) { return std::optional(Leaving{rays(i), -1}); });
}

std::vector<HitErrors> secondary_errors(std::span<const Tracer* const> models,
                                        const ExactTracer& exact, const Mesh& mesh,
                                        const ScaledFormat& format, const AimedRays& rays,
                                        const MostRays& most, std::uint64_t seed) {
  const auto spawn = [&](const Tracer& model, std::uint64_t i) -> std::optional<Leaving> {
    Work before;
    const Ray ray = rays(i);
    const Hit hit = hit_of(format.numbers, model.trace(ray, before));
    if (!hit.is_hit()) return {};
    return Leaving{diffuse_rays(mesh, format, {&ray, 1}, {&hit, 1}, seed ^ i).front(), hit.prim};
  };
  return errors_of(models, exact, CrackJudge(mesh, format.numbers), most, spawn);
}

}  // namespace ti
