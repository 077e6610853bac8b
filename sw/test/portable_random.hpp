// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <glm/vec3.hpp>
#include <random>

namespace ti::test {

/// A multiple of 2^-24 in [0, 1). The generators of <random> are the same everywhere, its
/// distributions are not.
inline float unit_random(std::mt19937& rng) { return static_cast<float>(rng() >> 8) * 0x1p-24F; }

/// Uniform on the sphere of radius 1, by rejection.
inline glm::vec3 on_sphere(std::mt19937& rng) {
  for (;;) {
    const float x = 2.0F * unit_random(rng) - 1.0F;
    const float y = 2.0F * unit_random(rng) - 1.0F;
    const float z = 2.0F * unit_random(rng) - 1.0F;
    const float r2 = x * x + y * y + z * z;
    if (r2 > 0x1p-20F && r2 < 1.0F) {
      return glm::vec3(x, y, z) / std::sqrt(r2);
    }
  }
}

}  // namespace ti::test
