// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>

namespace ti {

/// What a random number is for.
enum class Purpose : std::uint32_t {
  Pixel,
  Lens,
  Light,
  LobeChoice,
  Roulette,
  Diffuse,
  Glossy,
  Glass,
  Occlusion,
};

/// A random number of a sample, or a pair of them: what it is for, at which scattering.
struct Dimension {
  int bounce = 0;
  Purpose purpose = Purpose::Pixel;
};

/// Random numbers that belong to (seed, pixel, sample, dimension) and to nothing else, so that a
/// picture does not depend on which rays are traced, nor in which order.
///
/// Of each dimension the samples of a pixel are a (0,2)-sequence: Sobol's first two dimensions,
/// Owen scrambled and in an order of its own, so that dimensions are padded and not correlated.
/// Scrambling by hashing after Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020, with
/// the permutation of Vegdahl, Building a Better LK Hash, 2021. Integers alone: every machine draws
/// the same numbers, multiples of 2^-32 in [0, 1).
class Sampler {
 public:
  Sampler(std::uint64_t seed, std::uint32_t pixel, std::uint32_t sample);

  [[nodiscard]] double get1(Dimension dimension) const;
  [[nodiscard]] glm::dvec2 get2(Dimension dimension) const;

 private:
  std::uint64_t pixel_;  ///< hash of seed and pixel
  std::uint32_t sample_;
};

/// The point of the unit disc that belongs to one of the unit square, area for area and without
/// folds (Shirley and Chiu, A Low Distortion Map Between Disk and Square, JGT 2(3), 1997).
[[nodiscard]] glm::dvec2 disc(const glm::dvec2& u);

}  // namespace ti
