// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/image.hpp"
#include "base/config_keys.hpp"
#include "model/rd.hpp"
#include "model/trv.hpp"
#include "model/work.hpp"

namespace ti::model {

/// How the walk of a ray ended.
struct Walked {
  Status status = Status::Ok;
  std::uint32_t steps = 0;  ///< nodes visited, leaves included
};

/// What the tests of a leaf leave behind.
template <class F>
struct LeafEnd {
  F best;       ///< least t of a hit so far, or the ray's tmax
  bool ended;   ///< the ray asks for no more
  bool failed;  ///< an entry of its list names no triangle; those after it were not tested
};

/// The list entries of a leaf, as far as the list goes.
struct LeafEntries {
  LeafEntries(std::span<const std::uint32_t> list, const ImageNode& leaf) {
    const std::size_t first = std::min<std::size_t>(leaf.value, list.size());
    entries = list.subspan(first, std::min<std::size_t>(leaf.count(), list.size() - first));
    cut = entries.size() != leaf.count();
  }
  std::span<const std::uint32_t> entries;
  bool cut;  ///< the leaf has more
};

/// Where a walk ends at the latest.
struct WalkLimits {
  std::size_t stack_depth;
  std::uint32_t watchdog_steps;
};

/// The kd-tree of an image and the walk of a ray through it: which leaves, in which order.
///
/// Bit-exact model of `ti_trv`: a short stack, and a restart at the root where it has dropped an
/// entry (Foley and Sugerman 2005; Horn et al. 2007).
template <class F>
class KdTree {
 public:
  static constexpr TreeKind kKind = TreeKind::Kd;
  static constexpr Traversal kTraversal = Traversal::kPlain;

  explicit KdTree(const Image& image)
      : root_(image.header().root), nodes_(image.reach_of_nodes()), list_(image.list()) {}

  /// Where the ray begins for this walk.
  [[nodiscard]] static Origins<F> origins(const Box<F>&, const FpRay<F>& ray) {
    return {ray.o, ray.o};
  }

  /// Calls `visit(records, entry, exit)` for each leaf, with the t at which the ray enters and
  /// leaves it; the walk ends when the best t is not beyond the exit, and where the tree is
  /// damaged.
  template <class Visit>
  [[nodiscard]] Walked walk(const Clipped<F>& clipped, const WalkLimits& limits, Work& work,
                            const StepLog* log, const Visit& visit) const;

 private:
  std::uint32_t root_;
  std::span<const ImageNode> nodes_;
  std::span<const std::uint32_t> list_;
};

template <class F>
template <class Visit>
Walked KdTree<F>::walk(const Clipped<F>& clipped, const WalkLimits& limits, Work& work,
                       const StepLog* log, const Visit& visit) const {
  ShortStack<F> stack(limits.stack_depth);
  F tmin = clipped.tmin;
  F tmax = clipped.tmax;
  std::uint32_t index = root_;
  std::uint32_t steps = 0;
  for (;;) {
    ++work.steps;
    if (steps >= limits.watchdog_steps) return {Status::Watchdog, steps};
    ++steps;
    if (index >= nodes_.size()) return {Status::MemoryError, steps};
    const ImageNode node = nodes_[index];
    if (!node.is_leaf()) {
      const F t = split_distance(node, clipped.origins.least, clipped.inv);
      const auto [near, far] = ordered(node, index, clipped.inv[node.axis()].signbit());
      const Side side = choose(t, tmin, tmax);
      if (log) (*log)(fmt::format("node {} t {:08x} {}", index, t.bits(), name(side)));
      index = side == Side::Far ? far : near;
      if (side == Side::Both) {
        stack.push({far, tmin, tmax});
        tmax = t;
      }
      continue;
    }

    if (node.count() > kMaxLeafCount) return {Status::MemoryError, steps};
    ++work.leaves;
    const F exit = tmax;
    if (log) (*log)(fmt::format("node {} leaf {} exit {:08x}", index, node.count(), exit.bits()));
    if (node.count() != 0) ++work.full_leaves;
    const LeafEntries leaf(list_, node);
    const LeafEnd<F> end = visit(leaf.entries, tmin, exit);
    if (end.failed || leaf.cut) return {Status::MemoryError, steps};
    if (end.ended || end.best <= exit) return {Status::Ok, steps};
    if (!stack.empty()) {
      const auto top = stack.pop();
      index = top.node;
      tmin = exit;
      tmax = top.tmax;
    } else if (stack.dropped() && !(exit == clipped.tmax)) {
      ++work.restarts;
      stack.forget_dropped();
      index = root_;
      tmin = exit;
      tmax = clipped.tmax;
    } else {
      return {Status::Ok, steps};
    }
  }
}

}  // namespace ti::model
