// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/format.hpp"
#include "model/tracer.hpp"
#include "scene/aimed_rays.hpp"
#include "truth/exact_tracer.hpp"

namespace ti {

/// How far closest hits of an engine are from the exact ones; counts of rays.
struct HitErrors {
  std::uint64_t rays = 0;
  std::uint64_t exact_hits = 0;
  std::uint64_t missed = 0;      ///< the exact ray hits, the engine has none
  std::uint64_t cracks = 0;      ///< of these, those that no silhouette excuses (`is_crack`)
  std::uint64_t false_hits = 0;  ///< the other way round
  std::uint64_t wrong = 0;       ///< another triangle than one of the least exact t
  std::uint64_t self_hits = 0;   ///< of rays from a hit: of the triangle that they leave
  std::uint64_t failed = 0;      ///< with a status that is not Ok
  /// |t - exact t| in units in the last place of the exact t, of right hits of the first
  /// `kMostErrors` rays of a thread's share.
  std::vector<float> t_ulps;
  Work work;  ///< of the rays

  HitErrors& operator+=(const HitErrors& other);
};

constexpr std::size_t kMostErrors = std::size_t{1} << 20;

/// Whether a miss of `ray`, whose exact hit has distance t, is a crack: the exact ray hits, and so
/// does every one of 56 rays moved sideways, in 8 directions by up to (8 u + 2 r) A, u the
/// error of an operation and r that of a reciprocal: so far the test may
/// see a corner moved, and with it the outline of the mesh. A is the distance of the farthest
/// corner of the box of `mesh` from the origin of the ray. Between the 56 an outline may be
/// overlooked, so there may be fewer cracks than are counted, and not more.
[[nodiscard]] bool is_crack(const ExactTracer& exact, const Mesh& mesh, const Format& format,
                            const Ray& ray);

/// Errors of the model for rays [0, count) of `rays`, on all processors.
[[nodiscard]] HitErrors hit_errors(const Tracer& model, const ExactTracer& exact, const Mesh& mesh,
                                   const Format& format, const AimedRays& rays,
                                   std::uint64_t count);

/// The same for one cosine-distributed ray from each hit of those rays, where `departure` has it
/// begin.
[[nodiscard]] HitErrors secondary_errors(const Tracer& model, const ExactTracer& exact,
                                         const Mesh& mesh, const Format& format,
                                         const AimedRays& rays, std::uint64_t count,
                                         std::uint64_t seed);

}  // namespace ti
