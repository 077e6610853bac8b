// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "base/format.hpp"
#include "scene/ray.hpp"
#include "scene/scene.hpp"

namespace ti {

/// The lights of a scene as points see them: those without an area one by one, all triangles whose
/// material emits as one light.
class Lights {
 public:
  explicit Lights(const Scene& scene);

  [[nodiscard]] std::size_t count() const { return scene_.lights.size(); }
  [[nodiscard]] bool has_area() const { return !triangles_.empty(); }

  /// How light `i` reaches a point.
  struct Toward {
    glm::dvec3 direction;   ///< unit, from the point to the light
    glm::dvec3 irradiance;  ///< on a surface that faces it; not black
  };
  /// None where the light gives nothing: out of its range or its cone, or at the light itself.
  [[nodiscard]] std::optional<Toward> toward(std::size_t i, const glm::dvec3& from) const;

  /// A ray's direction and end from `origin` to light `i`, up to the light but for the error of
  /// both ends in the format of the engine, so that a light that lies on a wall is not hidden by
  /// it.
  struct End {
    glm::vec3 d;
    float tmax;
  };
  [[nodiscard]] End end_of(std::size_t i, const glm::vec3& origin, Format format) const;

  /// A point of the emissive triangles.
  struct Point {
    Hit hit;               ///< triangle and barycentric coordinates
    glm::dvec3 direction;  ///< unit, from the point that asked
    glm::dvec3 emission;   ///< radiance towards it
    double density = 0.0;  ///< a steradian
  };
  /// A triangle by its power, then a uniform point of it. None where the point is in the triangle's
  /// plane. `has_area()` must hold. The first number chooses the triangle, and where in the
  /// triangle's share it lies is used for the point: so numbers that are spread over the square are
  /// spread over all lamps, and over a lamp of several triangles.
  [[nodiscard]] std::optional<Point> sample(const glm::dvec3& from, const glm::dvec2& u) const;

  /// The density, a steradian, with which `sample` gives the point `at` of triangle `prim`; 0 for a
  /// triangle that does not emit.
  [[nodiscard]] double density(std::size_t prim, const glm::dvec3& from,
                               const glm::dvec3& at) const;

 private:
  const Scene& scene_;
  std::vector<std::uint32_t> triangles_;  ///< those that emit, by number
  std::vector<double> powers_;            ///< of the triangles up to this one; the last is all
};

/// Neither lights nor emissive triangles nor a background: such a scene is lit from the eye.
[[nodiscard]] bool is_unlit(const Scene& scene);

}  // namespace ti
