// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "accel/image.hpp"

namespace ti {

/// What no walk through a kd-tree exceeds, whatever the ray.
struct TreeBounds {
  int stack = 0;            ///< entries that wait on its stack at once
  std::uint64_t nodes = 0;  ///< nodes that it visits when it never restarts: each once
  std::uint64_t steps = 0;  ///< nodes that it visits when it restarts at will
};

/// The bounds of the tree of an image; none of one whose nodes share children, which `build_image`
/// does not make.
///
/// Stack: an entry waits while its ray is in the near child of the entry's node. The sign of the
/// direction on an axis says for all nodes of that axis which child is near. So a path to a node
/// has at most as many entries as it turns to one side, the same for all nodes of an axis; summed
/// over the axes, and the most over all nodes.
/// Steps: each leaf is visited once, as what lies up to its exit is passed by; on the way to it lie
/// at most as many nodes as the tree is deep.
[[nodiscard]] std::optional<TreeBounds> tree_bounds(const Image& image);

/// Inner nodes on the longest way from the root of an image to a leaf.
[[nodiscard]] int tree_depth(const Image& image);

}  // namespace ti
