// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace ti {

/// SplitMix64 (Steele, Lea, Flood 2014), one independent stream an index: sample i does not depend
/// on how many numbers the samples before it drew. Only integer arithmetic, exact conversions and
/// square roots, so that every machine draws the same.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t index) : state_(mix(mix(seed + kStep) ^ mix(index))) {}

  /// A multiple of 2^-53 in [0, 1).
  [[nodiscard]] double uniform() {
    state_ += kStep;
    return static_cast<double>(mix(state_) >> 11) * 0x1p-53;
  }

  /// Uniform in the open unit disc, by rejection.
  [[nodiscard]] glm::dvec2 disc() {
    for (;;) {
      const double x = 2.0 * uniform() - 1.0;
      const double y = 2.0 * uniform() - 1.0;
      if (x * x + y * y < 1.0) return {x, y};
    }
  }

  /// Uniform in the open unit ball without its centre, by rejection.
  [[nodiscard]] glm::dvec3 ball() {
    for (;;) {
      const double x = 2.0 * uniform() - 1.0;
      const double y = 2.0 * uniform() - 1.0;
      const double z = 2.0 * uniform() - 1.0;
      const double r2 = x * x + y * y + z * z;
      if (r2 > 0.0 && r2 < 1.0) return {x, y, z};
    }
  }

  /// Cosine-distributed about the unit vector `n`: a uniform disc point lifted to the hemisphere
  /// (Malley's method), in the basis of Duff et al., "Building an Orthonormal Basis, Revisited",
  /// JCGT 6(1), 2017.
  [[nodiscard]] glm::dvec3 cosine(const glm::dvec3& n) {
    const double sign = std::copysign(1.0, n.z);
    const double a = -1.0 / (sign + n.z);
    const double b = n.x * n.y * a;
    const glm::dvec3 s(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    const glm::dvec3 t(b, sign + n.y * n.y * a, -n.y);
    const glm::dvec2 p = disc();
    return p.x * s + p.y * t + std::sqrt(1.0 - p.x * p.x - p.y * p.y) * n;
  }

 private:
  static constexpr std::uint64_t kStep = 0x9E3779B97F4A7C15U;

  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

/// 2^x for |x| < 1000 within three units in the last place, by the series of the exponential
/// function: the same on every machine, which `std::exp2` need not be.
[[nodiscard]] inline double portable_exp2(double x) {
  constexpr double kLn2 = 0.6931471805599453;
  constexpr int kTerms = 16;  // the next one is below 2^-70: |rest| <= ln 2 / 2
  const double whole = std::floor(x + 0.5);
  const double rest = (x - whole) * kLn2;
  double sum = 1.0;
  for (int k = kTerms; k > 0; --k) sum = 1.0 + rest / k * sum;
  return std::ldexp(sum, static_cast<int>(whole));
}

}  // namespace ti
