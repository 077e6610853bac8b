// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "base/format.hpp"
#include "model/tracer.hpp"
#include "scene/aimed_rays.hpp"
#include "truth/exact_tracer.hpp"

namespace ti {

/// Where the exact ray of a crack meets the mesh.
struct CrackPlace {
  std::uint64_t ray = 0;
  glm::dvec3 point{0.0};
};

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
  /// `kMostErrors` rays of a thread's share; ascending.
  std::vector<float> t_ulps;
  /// |u - exact u| and |v - exact v| of the same hits in units of 2^-(M+1), the last place of the
  /// largest weights, which are in [1/2, 1); ascending.
  std::vector<float> u_ulps, v_ulps;
  std::vector<CrackPlace> crack_places;  ///< of the first `kMostPlaces` cracks, by ray
  Work work;                             ///< of the rays
  double seconds = 0.0;                  ///< of the engine, all threads added up

  HitErrors& operator+=(const HitErrors& other);
  /// Puts all lists in order.
  void sort();

 private:
  void sort_places();
};

constexpr std::size_t kMostErrors = std::size_t{1} << 20;
constexpr std::size_t kMostPlaces = 500;

/// Tells a crack from an outline. A is the distance of the farthest corner of the box of the mesh
/// from the origin of a ray, u the error of an operation and r that of a reciprocal. Keeps
/// references to what it is given.
class CrackJudge {
 public:
  CrackJudge(const ExactTracer& exact, const Mesh& mesh, const Format& format);

  /// How far behind the exact hit, in units of t, another one lies that cannot be the same: a
  /// thousandth of the diagonal of the mesh, or 64 u A.
  [[nodiscard]] double behind(const Ray& ray) const;

  /// Whether an engine that has no hit at the exact distance t, or one behind it, has a crack: rays
  /// that are moved sideways hit there too, to the corners of polygons around a disc of (8 u + 2 r)
  /// A and six smaller ones, first of octagons, then of 32 corners. So far the test may see a
  /// corner moved, and with it the outline of the mesh. A slit between two outlines that is
  /// narrower than the way from one corner to the next is overlooked. Where numbers of the format
  /// lie farther apart than that at the origin, the direction is turned in its place.
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

/// How many rays are traced at most, and how many steps and tests all models together may take for
/// them. Where rays are as thick as the scene, each is a test of every triangle.
struct MostRays {
  MostRays(std::uint64_t rays, double steps_and_tests = 1e18)
      : count(rays), work(steps_and_tests) {}

  std::uint64_t count;
  double work;
};

/// Errors of each of `models`, which have one format, for the first of `rays`, the same number for
/// all, on all processors. What is exact is computed once for all.
[[nodiscard]] std::vector<HitErrors> hit_errors(std::span<const Tracer* const> models,
                                                const ExactTracer& exact, const Mesh& mesh,
                                                const Format& format, const AimedRays& rays,
                                                const MostRays& most);

/// The same for one cosine-distributed ray from each hit of those rays on the model itself, where
/// `departure` has it begin; mesh and rays are in the space of the engine, so the scale of `format`
/// is 0.
[[nodiscard]] std::vector<HitErrors> secondary_errors(std::span<const Tracer* const> models,
                                                      const ExactTracer& exact, const Mesh& mesh,
                                                      const ScaledFormat& format,
                                                      const AimedRays& rays, const MostRays& most,
                                                      std::uint64_t seed);

}  // namespace ti
