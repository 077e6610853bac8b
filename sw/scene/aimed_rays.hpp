// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "scene/mesh.hpp"
#include "scene/ray.hpp"

namespace ti {

/// What a ray is aimed at, and from where.
enum class Aim : std::uint8_t {
  Uniform,   ///< any direction, from within 1.2 radii of the middle of the mesh
  Edges,     ///< a point of an edge, from there
  Vertices,  ///< a vertex, from there
  Grazing,   ///< a point of a triangle, along it: the slope is 2^-2 to 2^-16 of the direction
  Far,       ///< an edge or a vertex, from 1 to 1,000 radii away, alike on a logarithmic scale
};
constexpr std::array<const char*, 5> kAimNames{"uniform", "edges", "vertices", "grazing", "far"};

/// Ray `index` of those of `seed` aimed at a triangle of `mesh` chosen at random; o and d = p - o
/// are rounded to binary32, d is not of unit length. The mesh has a triangle. Any ray can be made
/// without those before it, so volumes need no memory.
class AimedRays {
 public:
  AimedRays(const Mesh& mesh, Aim aim, std::uint64_t seed);
  [[nodiscard]] Ray operator()(std::uint64_t index) const;

 private:
  const Mesh& mesh_;
  Aim aim_;
  std::uint64_t seed_;
  glm::dvec3 centre_;
  double radius_;
};

}  // namespace ti
