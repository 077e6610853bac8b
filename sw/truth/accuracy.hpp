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
  std::uint64_t cracks = 0;      ///< of both, those that pass a sheet without a gap (`CrackJudge`)
  std::uint64_t false_hits = 0;  ///< the other way round
  std::uint64_t wrong = 0;      ///< another triangle than one of the least exact t, at any distance
  std::uint64_t self_hits = 0;  ///< of rays from a hit: of the triangle that they leave
  std::uint64_t failed = 0;     ///< with a status that is not Ok; in none of the others
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
