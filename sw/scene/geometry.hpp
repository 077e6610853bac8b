// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>

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

/// What a hit gives to whoever goes on from it. `hit.is_hit()` must hold; a primitive that the mesh
/// does not have throws `std::out_of_range`.
struct Surface {
  glm::dvec3 position;  ///< (1-u-v) p0 + u p1 + v p2
  glm::dvec3 normal;    ///< geometric, unit, on the side that the ray came from

  /// `position` moved along `normal` by 16 * 2^-23 * max(|position|, |t d|), largest components: no
  /// ray that leaves on that side meets its own triangle again (binary32; a narrower format needs
  /// its own step).
  glm::vec3 origin;
};
[[nodiscard]] Surface surface_at(const Mesh& mesh, const Ray& ray, const Hit& hit);

}  // namespace ti
