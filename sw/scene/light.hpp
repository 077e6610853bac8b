// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <string>

namespace ti {

enum class LightKind : std::uint8_t { Point, Spot, Directional };

/// A light without an area, after KHR_lights_punctual. Light of an area is a triangle whose
/// material emits (`Material::emission`).
struct Light {
  std::string name{};
  LightKind kind = LightKind::Point;
  glm::vec3 position{0.0F};                ///< not of a directional one
  glm::vec3 direction{0.0F, -1.0F, 0.0F};  ///< unit, the way that the light goes; not of a point
  /// Point and spot: W/sr, that is irradiance times squared distance. Directional: irradiance on a
  /// surface that faces it.
  glm::vec3 intensity{1.0F};
  /// Where the light ends: at this distance it is 0, by the window of KHR_lights_punctual.
  float range = std::numeric_limits<float>::infinity();
  float cos_inner = 1.0F;  ///< of a spot: full inside, none beyond the outer, smooth between
  float cos_outer = 0.0F;
};

}  // namespace ti
