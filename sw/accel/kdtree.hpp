// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "accel/clip.hpp"
#include "base/format_grid.hpp"

namespace ti {

/// Node of a tree under construction. Inner: axis 0 to 2, `first` and `second` are the lower and
/// the upper child. Leaf: axis 3, `first` is the first entry in `KdTree::references`, `second` the
/// count.
struct KdNode {
  float split = 0.0F;
  std::uint32_t axis = 3;
  std::uint32_t first = 0;
  std::uint32_t second = 0;

  [[nodiscard]] bool is_leaf() const { return axis == 3; }
};

/// A parent stands before its children; the root is node 0.
struct KdTree {
  std::vector<KdNode> nodes;
  std::vector<std::uint32_t>
      references;  ///< triangle numbers of the leaves, ascending in each leaf
};

/// Puts `part` behind what `tree` has; numbers of nodes and references move along.
void append(KdTree& tree, const KdTree& part);

/// What `build_kd_tree` goes by; distances in units of the scene.
struct KdRules {
  FormatGrid grid;
  Box box;  ///< the root cell: values of the format, every triangle inside
  double step_cost;
  double test_cost;
  double leaf_cost;  ///< of a visit to a leaf, where a subtree is compared with one
  double empty_bonus;
  int bad_splits;  ///< splits on the way to a cell that may cost more than testing all, in the hope
                   ///< of better ones below
  int depth_limit;
  double min_cell;  ///< thinnest cell
  double dilation;  ///< a triangle belongs to every cell within this distance of it (per axis)
};

/// Builds a tree by the surface area heuristic in O(n log n): Wald and Havran, "On building fast
/// kd-trees for ray tracing, and on doing that in O(N log N)", 2006, with perfect splits.
///
/// Departures from the paper: a candidate plane is the first value of the format beyond the grown
/// extent of a triangle, so that no triangle touches the plane that it proposes, and events are of
/// two kinds only (a flat triangle starts and ends as any other). The same input gives the same
/// tree, whatever the number of threads. Throws `Error` when more than `kMaxLeafCount` triangles
/// overlap in one place.
[[nodiscard]] KdTree build_kd_tree(std::span<const Corners> triangles, const KdRules& rules);

}  // namespace ti
