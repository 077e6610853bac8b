// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "scene/scene.hpp"

namespace ti {

/// The most radiance that a ray can find in a scene, by the scatterings that its path has left.
///
///   A(0) = max(Le, Lb),  A(k) = max(Lb, Le + E F + r A(k - 1))
///
/// with Le, Lb the brightest emission and background; E the irradiance of all lights without an
/// area on a surface that faces them at the triangle nearest to each; F the most that a material
/// makes of irradiance, albedo / pi + s / (2 pi alpha^3) (GGX: its density is at most
/// 1 / (pi alpha^2), masking over the cosine at most 2 / alpha); r the largest albedo, of glass its
/// tint times ior^2, as radiance is squeezed on the way in. Brightest of three channels each.
class LightBound {
 public:
  LightBound(const Scene& scene, int scatterings);

  /// Infinite where a light lies on a triangle.
  [[nodiscard]] double arriving(int scatterings) const {
    return arriving_.at(static_cast<std::size_t>(scatterings));
  }

 private:
  std::vector<double> arriving_;
};

/// Distance from a point to a triangle, all of its points.
[[nodiscard]] double distance_to(const Corners& triangle, const glm::dvec3& point);

/// A step of the output: of 8 bits of sRGB near black, where steps are the smallest, in units of
/// exposed radiance.
constexpr double kOutputStep = 1.0 / (255.0 * 12.92);

}  // namespace ti
