// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "scene/ray.hpp"
#include "scene/scene.hpp"

namespace ti {

/// Rays of a camera through places of a picture.
class CameraRays {
 public:
  /// Throws `Error` for a camera without a direction or an angle, and for a picture of no size.
  CameraRays(const Camera& camera, int width, int height);

  /// The ray through `place` of the picture, pixels from its upper left corner, from the point
  /// `lens` of the lens, in the unit disc. Of unit length; from the eye where there is no aperture.
  [[nodiscard]] Ray at(const glm::dvec2& place, const glm::dvec2& lens = {0.0, 0.0}) const;

  /// Where `point` is seen from the middle of the lens, in pixels as above, perhaps beside the
  /// picture; nothing when it does not lie in front.
  [[nodiscard]] std::optional<glm::dvec2> place_of(const glm::dvec3& point) const;

 private:
  glm::dvec3 eye_;
  glm::dvec3 right_, up_, forward_;  ///< unit
  glm::dvec2 half_;                  ///< of the picture at distance 1
  glm::dvec2 size_;                  ///< in pixels
  double radius_;                    ///< of the lens
  double focus_;                     ///< distance along the view
};

/// The pixels of a picture, y * width + x, along the Morton curve, so that neighbours in the list
/// are neighbours in the picture.
[[nodiscard]] std::vector<std::uint32_t> morton_order(int width, int height);

}  // namespace ti
