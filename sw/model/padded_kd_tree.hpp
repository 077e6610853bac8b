// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/core.h>

#include <bit>
#include <cstdint>
#include <span>

#include "accel/image.hpp"
#include "base/config_keys.hpp"
#include "model/kd_tree.hpp"
#include "model/rd.hpp"
#include "model/trv.hpp"
#include "model/work.hpp"

namespace ti::model {

/// Levels of a tree that the restart trail has a bit for.
constexpr int kTrailLevels = 64;

/// Which of a ray's choices on its way down are done: a bit for each level, 1 where nothing is left
/// to do behind the child that the ray has gone to (Laine 2010, restart trail).
///
/// Read as a number with the root as its highest digit it grows with each leaf, so a walk ends.
class Trail {
 public:
  [[nodiscard]] bool done(int level) const { return (bits_ >> level & 1U) != 0U; }
  void set_done(int level) { bits_ |= std::uint64_t{1} << level; }

  /// The lowest level above `depth` with something left to do, which is marked as done and what was
  /// below it as new; -1 when there is none.
  [[nodiscard]] int next(int depth) {
    const std::uint64_t above =
        depth == kTrailLevels ? ~std::uint64_t{0} : (std::uint64_t{1} << depth) - 1;
    const std::uint64_t left = ~bits_ & above;
    if (left == 0) return -1;
    const int level = 63 - std::countl_zero(left);
    bits_ &= (std::uint64_t{1} << level) - 1;
    set_done(level);
    return level;
  }

 private:
  std::uint64_t bits_ = 0;
};

/// The kd-tree of an image and the walk of a thick ray through it (`thick_origins`): no cell that
/// can hold its hit is left out, whatever the format.
///
/// Bit-exact model of `ti_trv` with `Padded`. The intervals of the two children of a node overlap,
/// so an entry of the stack has its own tmin, which is at most that of each entry below it: the
/// least t at which anything left may be hit. The walk ends when the best t is less. Where the
/// short stack has dropped an entry, the ray goes down again from the root along its trail, with
/// the same comparisons as before.
template <class F>
class PaddedKdTree {
 public:
  static constexpr TreeKind kKind = TreeKind::Kd;
  static constexpr Traversal kTraversal = Traversal::kPadded;

  explicit PaddedKdTree(const Image& image)
      : root_(image.header().root), nodes_(image.reach_of_nodes()), list_(image.list()) {}

  [[nodiscard]] static Origins<F> origins(const Box<F>& box, const FpRay<F>& ray) {
    return thick_origins(box, ray.o, ray.d);
  }

  /// As `KdTree::walk`; leaves may overlap.
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
Walked PaddedKdTree<F>::walk(const Clipped<F>& clipped, const WalkLimits& limits, Work& work,
                             const StepLog* log, const Visit& visit) const {
  const F infinity = F::from_bits(F::kInfBits);
  ShortStack<F> stack(limits.stack_depth);
  Trail trail;
  F dropped_from = infinity;  // least t of the entries that the stack has dropped
  F tmin = clipped.tmin;
  F tmax = clipped.tmax;
  std::uint32_t index = root_;
  int level = 0;
  std::uint32_t steps = 0;
  for (;;) {
    ++work.steps;
    if (steps >= limits.watchdog_steps) return {Status::Watchdog, steps};
    ++steps;
    if (index >= nodes_.size()) return {Status::MemoryError, steps};
    const ImageNode node = nodes_[index];
    if (node.is_leaf() ? node.count() > kMaxLeafCount : level == kTrailLevels)
      return {Status::MemoryError, steps};
    const F left_from = stack.empty() ? dropped_from : stack.top().tmin;
    if (!node.is_leaf()) {
      const Crossing<F> t{split_distance(node, clipped.origins.least, clipped.inv),
                          split_distance(node, clipped.origins.most, clipped.inv)};
      const auto [near, far] = ordered(node, index, clipped.inv[node.axis()].signbit());
      Side side = choose(t, tmin, tmax);
      if (log) {
        (*log)(fmt::format("node {} t {:08x} {:08x} {}", index, t.least.bits(), t.most.bits(),
                           name(side)));
      }
      F far_tmin = tmin < t.least ? t.least : tmin;
      if (left_from < far_tmin) far_tmin = left_from;
      if (side == Side::Both && !trail.done(level)) {
        if (const auto dropped = stack.push({far, far_tmin, tmax})) dropped_from = dropped->tmin;
        if (t.most < tmax) tmax = t.most;
        index = near;
      } else {
        if (side == Side::Both) tmin = far_tmin;
        index = side == Side::Near ? near : far;
        trail.set_done(level);
      }
      ++level;
      continue;
    }

    ++work.leaves;
    if (log) (*log)(fmt::format("node {} leaf {} exit {:08x}", index, node.count(), tmax.bits()));
    if (node.count() != 0) ++work.full_leaves;
    const LeafEntries leaf(list_, node);
    const LeafEnd<F> end = visit(leaf.entries, tmin, tmax);
    if (end.failed || leaf.cut) return {Status::MemoryError, steps};
    if (end.ended || end.best < left_from) return {Status::Ok, steps};
    level = trail.next(level) + 1;
    if (level == 0) return {Status::Ok, steps};
    if (!stack.empty()) {
      const auto top = stack.pop();
      index = top.node;
      tmin = top.tmin;
      tmax = top.tmax;
    } else {
      ++work.restarts;
      dropped_from = infinity;
      index = root_;
      level = 0;
      tmin = clipped.tmin;
      tmax = clipped.tmax;
    }
  }
}

}  // namespace ti::model
