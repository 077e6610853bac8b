// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace ti {

/// The three corners of a triangle.
using Corners = std::array<glm::vec3, 3>;

/// Triangles in the order of the mesh file; `triangles[i]` indexes `vertices` and is primitive i.
struct Mesh {
  std::vector<glm::vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint16_t> material;  ///< one a triangle, or empty when there is one material

  [[nodiscard]] glm::vec3 vertex(std::size_t triangle, int corner) const {
    return vertices[triangles[triangle][static_cast<std::size_t>(corner)]];
  }
  [[nodiscard]] Corners corners(std::size_t triangle) const {
    return {vertex(triangle, 0), vertex(triangle, 1), vertex(triangle, 2)};
  }
};

}  // namespace ti
