// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
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
  std::uint64_t through = 0;     ///< a hit that cannot be the exact one, as it lies behind it
  std::uint64_t cracks = 0;      ///< of both, those that no outline excuses (`CrackJudge`)
  std::uint64_t false_hits = 0;  ///< the other way round
  std::uint64_t wrong = 0;      ///< another triangle than one of the least exact t, at any distance
  std::uint64_t self_hits = 0;  ///< of rays from a hit: of the triangle that they leave
  std::uint64_t failed = 0;     ///< with a status that is not Ok
  /// |t - exact t| in units in the last place of the exact t, of right hits of the first
  /// `kMostErrors` rays of a thread's share.
  std::vector<float> t_ulps;
  Work work;  ///< of the rays

  HitErrors& operator+=(const HitErrors& other);
};

constexpr std::size_t kMostErrors = std::size_t{1} << 20;

/// Tells a crack from an outline. A is the distance of the farthest corner of the box of the mesh
/// from the origin of a ray, u the error of an operation and r that of a reciprocal. Keeps
/// references to what it is given.
class CrackJudge {
 public:
  CrackJudge(const ExactTracer& exact, const Mesh& mesh, const Format& format);

  /// How far behind the exact hit, in units of t, another one lies that cannot be the same: a
  /// thousandth of the diagonal of the mesh, or 64 u A.
  [[nodiscard]] double behind(const Ray& ray) const;

  /// Whether an engine that has no hit at the exact distance t, or one behind it, has a crack: 56
  /// rays that are moved sideways hit there too, to the corners of octagons around a disc of
  /// (8 u + 2 r) A and six smaller ones. So far the test may see a corner moved, and with it the
  /// outline of the mesh. A bent outline may be overlooked between them.
  [[nodiscard]] bool is_crack(const Ray& ray, double t) const;

  [[nodiscard]] const ExactTracer& exact() const { return exact_; }
  [[nodiscard]] const Format& format() const { return format_; }

 private:
  [[nodiscard]] double farthest(const glm::dvec3& o) const;

  const ExactTracer& exact_;
  Format format_;
  glm::dvec3 low_{}, high_{};
  double diagonal_ = 0.0;
};

/// Errors of the model for rays [0, count) of `rays`, on all processors.
[[nodiscard]] HitErrors hit_errors(const Tracer& model, const ExactTracer& exact, const Mesh& mesh,
                                   const Format& format, const AimedRays& rays,
                                   std::uint64_t count);

/// The same for one cosine-distributed ray from each hit of those rays, where `departure` has it
/// begin; mesh and rays are in the space of the engine, so the scale of `format` is 0.
[[nodiscard]] HitErrors secondary_errors(const Tracer& model, const ExactTracer& exact,
                                         const Mesh& mesh, const ScaledFormat& format,
                                         const AimedRays& rays, std::uint64_t count,
                                         std::uint64_t seed);

}  // namespace ti
