// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "base/format.hpp"
#include "scene/mesh.hpp"
#include "scene/ray.hpp"

namespace ti {

/// Box of the triangles of a mesh, in scene units.
struct Bounds {
  glm::dvec3 low{0.0};
  glm::dvec3 high{0.0};

  [[nodiscard]] glm::dvec3 centre() const { return 0.5 * (low + high); }
  [[nodiscard]] double diagonal() const;
};

/// Box of all triangles whose vertices are finite; nothing when there is none.
[[nodiscard]] std::optional<Bounds> bounds_of(const Mesh& mesh);

/// Cross product of two edges of triangle `i`: twice its area long, not normalised.
[[nodiscard]] glm::dvec3 area_vector(const Mesh& mesh, std::size_t i);

/// What shading needs of a hit. `hit.is_hit()` must hold; a primitive that the mesh does not have
/// throws `std::out_of_range`.
struct Surface {
  glm::dvec3 position;  ///< (1-u-v) p0 + u p1 + v p2
  glm::dvec3 normal;    ///< geometric, unit, on the side that the ray came from
};
[[nodiscard]] Surface surface_at(const Mesh& mesh, const Ray& ray, const Hit& hit);

/// Rounding errors of an interpolated point, and those of the test of a triangle by which an origin
/// stands off its plane: 7 + 21, and the second order. `geometry.cpp` has the derivation,
/// `scripts/certify.py` the proof.
inline constexpr double kStandOffPoint = 7.0;
inline constexpr double kStandOffTest = 32.0;

/// Where rays leave a hit, for an engine that has the scene in `format`: on the triangle as that
/// engine has it, its vertices scaled and rounded.
///
/// No ray from `origin` to the side of `normal` meets its own triangle again, neither exactly nor
/// by the engine's test: `geometry.cpp` derives the distance. Holds for triangles whose longest
/// side is less than 2^(M-4) times their height.
struct Departure {
  glm::vec3 origin;  ///< numbers of the format, times 2^-scale
  glm::dvec3 normal;
};
[[nodiscard]] Departure departure(const Mesh& mesh, const Ray& ray, const Hit& hit,
                                  const ScaledFormat& format);

}  // namespace ti
