// SPDX-License-Identifier: Apache-2.0
//
// The parts of `build_kd_tree` that `update_kd_tree` takes too.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <limits>
#include <span>
#include <vector>

#include "accel/kdtree.hpp"

namespace ti {

/// The part of a triangle in a cell, as the planes that just miss it on each axis:
/// a plane s has some of it below when s > before, and some of it above when s < after.
struct Fragment {
  std::uint32_t triangle;
  std::array<float, 3> before;
  std::array<float, 3> after;
};

/// The whole of triangle `number`.
[[nodiscard]] Fragment whole_fragment(std::span<const Corners> triangles, std::uint32_t number,
                                      const KdRules& rules);

/// The part of `fragment` in `box`.
[[nodiscard]] Fragment clipped_fragment(std::span<const Corners> triangles,
                                        const Fragment& fragment, const Box& box,
                                        const KdRules& rules);

/// Where a fragment starts or ends: position, then ends before starts, then the fragment, in one
/// sortable word.
using KdEvent = std::uint64_t;

/// The triangles of a cell.
struct KdCell {
  Box box;
  std::vector<Fragment> fragments;
  std::array<std::vector<KdEvent>, 3> events;  ///< sorted

  void clear() {
    fragments.clear();
    for (auto& axis : events) axis.clear();
  }
};

class KdBuilder {
 public:
  KdBuilder(std::span<const Corners> triangles, const KdRules& rules)
      : triangles_(triangles), rules_(rules) {}

  /// Sorts the events of all fragments of `cell`.
  void make_events(KdCell& cell) { merge_events(cell, 0); }

  /// Builds the tree of `cell` into `tree()`; the root of it is the first node added. Returns what
  /// a ray through the cell costs, all nodes and tests counted: where that is no less than the cost
  /// of a leaf, a leaf takes its place.
  double build(KdCell& cell, int depth, int bad_splits);

  [[nodiscard]] KdTree& tree() { return tree_; }

 private:
  struct Split {
    double cost = std::numeric_limits<double>::infinity();
    std::size_t axis = 3;
    float plane = 0.0F;
  };

  [[nodiscard]] Split best_split(const KdCell& cell) const;
  void sweep(const KdCell& cell, std::size_t axis, Split& best) const;
  void make_leaf(const KdCell& cell);
  void divide(const KdCell& cell, const Split& split, KdCell& below, KdCell& above);
  void merge_events(KdCell& child, std::size_t first_new);

  std::span<const Corners> triangles_;
  const KdRules& rules_;
  KdTree tree_;
  // Children of the cell being divided, by depth; reused.
  std::deque<std::array<KdCell, 2>> levels_;
  // New ids of the fragments of a cell in its children.
  std::vector<std::array<std::uint32_t, 2>> renamed_;
  std::vector<KdEvent> fresh_;
};

}  // namespace ti
