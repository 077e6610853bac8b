// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>

namespace ti {

/// A ray as it stands in `rays.npy`: o + t d for tmin <= t <= tmax; d need not be of unit length.
struct Ray {
  glm::vec3 o{0.0F};
  float tmin = 0.0F;
  glm::vec3 d{0.0F, 0.0F, 1.0F};
  float tmax = std::numeric_limits<float>::infinity();
  bool any = false;  ///< report hit or miss only
};

/// Why a ray retired.
enum class Status : std::uint8_t { Ok = 0, InvalidRay = 1, MemoryError = 2, Watchdog = 3 };

/// What comes back for a ray. A miss has t = inf, u = v = 0, prim = -1.
/// An any-hit ray that hits has t = u = v = 0 and prim = 0.
struct Hit {
  float t = std::numeric_limits<float>::infinity();
  float u = 0.0F;
  float v = 0.0F;
  std::int32_t prim = -1;  ///< triangle number in the order of the mesh file
  Status status = Status::Ok;
  std::uint16_t steps = 0;  ///< nodes visited, leaves included

  [[nodiscard]] bool is_hit() const { return prim >= 0; }
};

}  // namespace ti
