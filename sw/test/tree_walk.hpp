// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

#include "accel/build.hpp"
#include "accel/clip.hpp"
#include "accel/image.hpp"
#include "portable_random.hpp"
#include "scene/mesh.hpp"

namespace ti {

/// Mesh of separate triangles, three vertices each.
inline Mesh mesh_of(const std::vector<glm::vec3>& corners) {
  Mesh mesh;
  mesh.vertices = corners;
  for (std::uint32_t i = 0; i + 2 < corners.size(); i += 3) {
    mesh.triangles.push_back({i, i + 1, i + 2});
  }
  return mesh;
}

/// `count` triangles of about `size` around points of the unit cube; every fourth one is flat on an
/// axis, with the plane on a coarse grid so that planes repeat.
inline Mesh soup(std::size_t count, float size, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto unit = [&random] { return test::unit_random(random); };
  std::vector<glm::vec3> corners;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::vec3 middle{unit(), unit(), unit()};
    const int flat = i % 4 == 0 ? static_cast<int>(i / 4 % 3) : -1;
    for (int corner = 0; corner < 3; ++corner) {
      glm::vec3 vertex;
      for (int axis = 0; axis < 3; ++axis) {
        vertex[axis] = middle[axis] + size * (unit() - 0.5F);
        if (axis == flat) vertex[axis] = std::round(middle[axis] * 8.0F) / 8.0F;
      }
      corners.push_back(vertex);
    }
  }
  return mesh_of(corners);
}

/// A leaf of an image with its cell; `prims` are triangle numbers of the mesh.
struct Leaf {
  Box cell;
  std::vector<std::uint32_t> prims;
};

/// Node and cell of every node, by the traversal's own reading of `link`.
struct Visit {
  std::uint32_t node;
  Box cell;
};

inline double number(const Image& image, std::uint32_t bits) {
  return value_of_bits(image.format(), bits);
}

inline Box scene_box(const Image& image) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lo[axis] = number(image, image.header().box_lo[axis]);
    box.hi[axis] = number(image, image.header().box_hi[axis]);
  }
  return box;
}

/// Every node of the tree with its cell, lower children first.
inline std::vector<Visit> visits(const Image& image) {
  std::vector<Visit> found;
  std::vector<Visit> open{{image.header().root, scene_box(image)}};
  while (!open.empty()) {
    const Visit here = open.back();
    open.pop_back();
    found.push_back(here);
    const ImageNode node = image.nodes()[here.node];
    if (node.is_leaf()) continue;
    Visit lower{node.reorder() ? node.other() : here.node + 1, here.cell};
    Visit upper{node.reorder() ? here.node + 1 : node.other(), here.cell};
    lower.cell.hi[node.axis()] = upper.cell.lo[node.axis()] = number(image, node.value);
    open.push_back(upper);
    open.push_back(lower);
  }
  return found;
}

inline std::vector<Leaf> leaves(const Image& image) {
  std::vector<Leaf> found;
  for (const Visit& visit : visits(image)) {
    const ImageNode node = image.nodes()[visit.node];
    if (!node.is_leaf()) continue;
    Leaf leaf{visit.cell, {}};
    for (std::uint32_t i = 0; i < node.count(); ++i) {
      leaf.prims.push_back(image.planes()[image.list()[node.value + i]].prim);
    }
    std::sort(leaf.prims.begin(), leaf.prims.end());
    found.push_back(leaf);
  }
  return found;
}

/// True when the triangle and the closed box share a point: separating axes (Akenine-Moller 2001)
/// in double.
inline bool overlap(const Corners& triangle, const Box& box) {
  const auto separated = [&](const Point& axis) {
    double lo = INFINITY;
    double hi = -INFINITY;
    for (const glm::vec3& place : triangle) {
      const Point corner = point_of(place);
      const double x = axis[0] * corner[0] + axis[1] * corner[1] + axis[2] * corner[2];
      lo = std::min(lo, x);
      hi = std::max(hi, x);
    }
    double box_lo = 0.0;
    double box_hi = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      box_lo += std::min(axis[i] * box.lo[i], axis[i] * box.hi[i]);
      box_hi += std::max(axis[i] * box.lo[i], axis[i] * box.hi[i]);
    }
    return lo > box_hi || hi < box_lo;
  };
  const auto cross = [](const Point& a, const Point& b) {
    return Point{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const std::array<Point, 3> units{Point{1, 0, 0}, Point{0, 1, 0}, Point{0, 0, 1}};
  std::array<Point, 3> edges{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      edges[i][axis] = point_of(triangle[(i + 1) % 3])[axis] - point_of(triangle[i])[axis];
    }
  }
  if (separated(cross(edges[0], edges[1]))) return false;
  for (const Point& unit : units) {
    if (separated(unit)) return false;
    for (const Point& edge : edges) {
      if (separated(cross(unit, edge))) return false;
    }
  }
  return true;
}

/// Every leaf has exactly the triangles that it must: all that meet the cell, none farther away
/// than the dilation allows.
inline void check_membership(const Mesh& mesh, const Image& image) {
  const Box box = scene_box(image);
  const double diagonal =
      std::hypot(box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]);
  const double slack = 3.0 * BuildOptions{}.dilation * diagonal;
  for (const Leaf& leaf : leaves(image)) {
    const Box wide = leaf.cell.grown(slack);
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const Corners corners = mesh.corners(i);
      const bool listed = std::binary_search(leaf.prims.begin(), leaf.prims.end(), i);
      if (listed != overlap(corners, leaf.cell)) {
        CAPTURE(i);
        CHECK(listed);
        CHECK(overlap(corners, wide));
      }
    }
    CHECK(std::adjacent_find(leaf.prims.begin(), leaf.prims.end()) == leaf.prims.end());
  }
}

}  // namespace ti
