// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "accel/kdtree.hpp"

namespace ti {

/// What `update_kd_tree` did.
struct KdUpdate {
  std::uint32_t cells = 0;       ///< built anew
  std::uint32_t references = 0;  ///< of the leaves in them
};

/// The tree of triangles of which some moved since `old` was built: where no moved triangle was or
/// is, subtrees are taken over as they are; split planes are kept down to cells of which an eighth
/// of the references moved, and these, or leaves, are built anew.
///
/// `triangles` are those of now; `moved[i]` says that triangle i is not where it was. `rules` are
/// those of `old`, so its box must hold the triangles of now too. Every cell has the triangles that
/// it must have; split planes that are kept were the best for where the triangles were.
[[nodiscard]] KdTree update_kd_tree(const KdTree& old, std::span<const Corners> triangles,
                                    const std::vector<std::uint8_t>& moved, const KdRules& rules,
                                    KdUpdate& update);

}  // namespace ti
