// SPDX-License-Identifier: Apache-2.0
#include "accel/tree_bounds.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace ti {
namespace {

/// Of the path to a node.
struct Path {
  std::array<std::array<int, 2>, 3> turns{};  ///< to the lower and the upper child, of each axis
  int depth = 0;
  bool reached = false;

  [[nodiscard]] int entries() const {
    int sum = 0;
    for (const auto& [lower, upper] : turns) sum += std::max(lower, upper);
    return sum;
  }
};

}  // namespace

std::optional<TreeBounds> tree_bounds(const Image& image) {
  const auto nodes = image.nodes();
  const std::uint32_t root = image.header().root;
  std::vector<Path> paths(nodes.size());
  paths[root].reached = true;
  TreeBounds bounds;
  std::uint64_t leaves = 0;
  int depth = 0;
  for (std::uint32_t i = root; i < nodes.size(); ++i) {  // children stand after their parent
    const ImageNode& node = nodes[i];
    const Path& path = paths[i];
    if (!path.reached) continue;
    ++bounds.nodes;
    bounds.stack = std::max(bounds.stack, path.entries());
    depth = std::max(depth, path.depth);
    if (node.is_leaf()) {
      ++leaves;
      continue;
    }
    for (const bool upper : {false, true}) {
      const std::uint32_t number = upper == node.reorder() ? i + 1 : node.other();
      if (number <= i || number >= nodes.size() || paths[number].reached) return std::nullopt;
      Path& child = paths[number];
      child = path;
      ++child.turns[node.axis()][upper ? 1 : 0];
      ++child.depth;
    }
  }
  bounds.steps = leaves * (static_cast<std::uint64_t>(depth) + 1);
  return bounds;
}

int tree_depth(const Image& image) {
  const auto nodes = image.nodes();
  std::vector<int> depths(nodes.size());
  int deepest = 0;
  for (std::uint32_t i = image.header().root; i < nodes.size(); ++i) {
    if (nodes[i].is_leaf()) {
      deepest = std::max(deepest, depths[i]);
      continue;
    }
    for (const std::uint32_t child : {i + 1, nodes[i].other()}) {
      if (child > i && child < nodes.size()) depths[child] = std::max(depths[child], depths[i] + 1);
    }
  }
  return deepest;
}

}  // namespace ti
