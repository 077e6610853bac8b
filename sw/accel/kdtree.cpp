// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <exception>
#include <limits>
#include <string>
#include <utility>

#include "accel/image.hpp"
#include "accel/kd_builder.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"

namespace ti {
namespace {

/// Hard end of the depth of a tree whose leaves would hold more than `kMaxLeafCount` triangles.
constexpr int kDepthEnd = 96;
/// The upper part of a cell is a task of its own when it has at least this many triangles.
constexpr std::size_t kForkSize = 20000;
/// No new id.
constexpr std::uint32_t kNone = 0xFFFFFFFFU;

constexpr KdEvent kStart = KdEvent{1} << 31U;
constexpr KdEvent kIdMask = kStart - 1;

/// Maps floats to integers of the same order.
std::uint32_t ordered(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  return (bits >> 31U) != 0 ? ~bits : bits | 0x80000000U;
}

float from_ordered(std::uint32_t key) {
  return std::bit_cast<float>((key >> 31U) != 0 ? key & 0x7FFFFFFFU : ~key);
}

KdEvent start_event(float x, std::size_t id) { return KdEvent{ordered(x)} << 32U | kStart | id; }
KdEvent end_event(float x, std::size_t id) { return KdEvent{ordered(x)} << 32U | id; }

}  // namespace

void append(KdTree& tree, const KdTree& part) {
  const auto nodes = static_cast<std::uint32_t>(tree.nodes.size());
  const auto references = static_cast<std::uint32_t>(tree.references.size());
  for (KdNode node : part.nodes) {
    node.first += node.is_leaf() ? references : nodes;
    if (!node.is_leaf()) node.second += nodes;
    tree.nodes.push_back(node);
  }
  tree.references.insert(tree.references.end(), part.references.begin(), part.references.end());
}

Fragment whole_fragment(std::span<const Corners> triangles, std::uint32_t number,
                        const KdRules& rules) {
  Fragment fragment{.triangle = number, .before = {}, .after = {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = [&](std::size_t corner) {
      return double{triangles[number][corner][static_cast<int>(axis)]};
    };
    const auto [lo, hi] = std::minmax({at(0), at(1), at(2)});
    fragment.before[axis] = rules.grid.below(lo - rules.dilation);
    fragment.after[axis] = rules.grid.above(hi + rules.dilation);
  }
  return fragment;
}

Fragment clipped_fragment(std::span<const Corners> triangles, const Fragment& fragment,
                          const Box& box, const KdRules& rules) {
  Fragment part = fragment;
  Box bounds;
  if (!clipped_bounds(triangles[fragment.triangle], box.grown(rules.dilation), bounds)) return part;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    part.before[axis] =
        std::max(part.before[axis], rules.grid.below(bounds.lo[axis] - rules.dilation));
    part.after[axis] =
        std::min(part.after[axis], rules.grid.above(bounds.hi[axis] + rules.dilation));
  }
  return part;
}

void KdBuilder::sweep(const KdCell& cell, std::size_t axis, Split& best) const {
  const double lo = cell.box.lo[axis];
  const double hi = cell.box.hi[axis];
  const float first = rules_.grid.at_least(lo + rules_.min_cell);
  const float last = rules_.grid.at_most(hi - rules_.min_cell);
  if (!(first <= last) || !(first > lo) || !(last < hi)) return;

  const std::size_t total = cell.fragments.size();
  const std::size_t other = (axis + 1) % 3;
  const std::size_t another = (axis + 2) % 3;
  const double width = cell.box.hi[other] - cell.box.lo[other];
  const double height = cell.box.hi[another] - cell.box.lo[another];
  const double cap = width * height;
  const double around = width + height;
  const double scale = rules_.test_cost / (cap + around * (hi - lo));

  const auto try_plane = [&](float plane, std::size_t below, std::size_t above) {
    const double x = plane;
    const double share = (cap + around * (x - lo)) * static_cast<double>(below) +
                         (cap + around * (hi - x)) * static_cast<double>(above);
    double tests = scale * share;
    if (below == 0 || above == 0) tests *= 1.0 - rules_.empty_bonus;
    const double cost = rules_.step_cost + tests;
    if (cost < best.cost) best = {cost, axis, plane};
  };

  const std::vector<KdEvent>& events = cell.events[axis];
  const std::uint32_t first_key = ordered(first);
  const std::uint32_t last_key = ordered(last);
  std::size_t below = 0;
  std::size_t above = total;
  std::size_t i = 0;
  const auto pass_ends = [&](std::uint32_t key) {
    for (; i < events.size() && events[i] >> 32U == key && (events[i] & kStart) == 0; ++i) --above;
  };
  const auto pass_starts = [&](std::uint32_t key) {
    for (; i < events.size() && events[i] >> 32U == key; ++i) ++below;
  };

  // Planes nearer to a side of the cell than `min_cell` move to that distance.
  while (i < events.size() && events[i] >> 32U < first_key) {
    ((events[i] & kStart) != 0) ? void(++below) : void(--above);
    ++i;
  }
  if (i > 0) {
    pass_ends(first_key);
    try_plane(first, below, above);
    pass_starts(first_key);
  }
  while (i < events.size()) {
    const auto key = static_cast<std::uint32_t>(events[i] >> 32U);
    if (key > last_key) {
      try_plane(last, below, above);
      break;
    }
    pass_ends(key);
    try_plane(from_ordered(key), below, above);
    pass_starts(key);
  }
}

KdBuilder::Split KdBuilder::best_split(const KdCell& cell) const {
  Split best;
  for (std::size_t axis = 0; axis < 3; ++axis) sweep(cell, axis, best);
  return best;
}

void KdBuilder::make_leaf(const KdCell& cell) {
  KdNode leaf;
  leaf.first = static_cast<std::uint32_t>(tree_.references.size());
  leaf.second = static_cast<std::uint32_t>(cell.fragments.size());
  for (const Fragment& fragment : cell.fragments) tree_.references.push_back(fragment.triangle);
  std::sort(tree_.references.begin() + leaf.first, tree_.references.end());
  tree_.nodes.push_back(leaf);
}

/// Adds the events of the fragments from `first_new` on to the sorted ones of the others.
void KdBuilder::merge_events(KdCell& child, std::size_t first_new) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    fresh_.clear();
    for (std::size_t id = first_new; id < child.fragments.size(); ++id) {
      fresh_.push_back(start_event(child.fragments[id].before[axis], id));
      fresh_.push_back(end_event(child.fragments[id].after[axis], id));
    }
    std::sort(fresh_.begin(), fresh_.end());
    std::vector<KdEvent>& events = child.events[axis];
    std::size_t old_left = events.size();
    std::size_t new_left = fresh_.size();
    events.resize(old_left + new_left);
    // From the back, by position and kind: fragment numbers do not matter to the sweep.
    while (new_left > 0) {
      const bool take_old =
          old_left > 0 && events[old_left - 1] >> 31U > fresh_[new_left - 1] >> 31U;
      events[old_left + new_left - 1] = take_old ? events[old_left - 1] : fresh_[new_left - 1];
      --(take_old ? old_left : new_left);
    }
  }
}

void KdBuilder::divide(const KdCell& cell, const Split& split, KdCell& below, KdCell& above) {
  below.clear();
  above.clear();
  below.box = above.box = cell.box;
  below.box.hi[split.axis] = above.box.lo[split.axis] = split.plane;

  const std::size_t count = cell.fragments.size();
  renamed_.resize(count);
  for (std::size_t id = 0; id < count; ++id) {
    const Fragment& fragment = cell.fragments[id];
    renamed_[id] = {kNone, kNone};
    if (split.plane >= fragment.after[split.axis]) {
      renamed_[id][0] = static_cast<std::uint32_t>(below.fragments.size());
      below.fragments.push_back(fragment);
    } else if (split.plane <= fragment.before[split.axis]) {
      renamed_[id][1] = static_cast<std::uint32_t>(above.fragments.size());
      above.fragments.push_back(fragment);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    below.events[axis].reserve(2 * below.fragments.size());
    above.events[axis].reserve(2 * above.fragments.size());
    for (const KdEvent event : cell.events[axis]) {
      const auto& names = renamed_[event & kIdMask];
      if (names[0] != kNone) below.events[axis].push_back((event & ~kIdMask) | names[0]);
      if (names[1] != kNone) above.events[axis].push_back((event & ~kIdMask) | names[1]);
    }
  }
  const std::size_t first_below = below.fragments.size();
  const std::size_t first_above = above.fragments.size();
  for (std::size_t id = 0; id < count; ++id) {
    const Fragment& fragment = cell.fragments[id];
    if (fragment.before[split.axis] < split.plane && split.plane < fragment.after[split.axis]) {
      below.fragments.push_back(clipped_fragment(triangles_, fragment, below.box, rules_));
      above.fragments.push_back(clipped_fragment(triangles_, fragment, above.box, rules_));
    }
  }
  merge_events(below, first_below);
  merge_events(above, first_above);
}

double KdBuilder::build(KdCell& cell, int depth, int bad_splits) {
  const std::size_t count = cell.fragments.size();
  const bool too_many = count > kMaxLeafCount;
  const double tests_cost = rules_.test_cost * static_cast<double>(count);
  const double leaf_cost = rules_.leaf_cost + tests_cost;
  Split split;
  if (count > 0 && depth < (too_many ? kDepthEnd : rules_.depth_limit)) split = best_split(cell);
  const bool pays = split.cost < tests_cost;
  if (!pays) ++bad_splits;
  if (split.axis == 3 || (!too_many && bad_splits > rules_.bad_splits)) {
    if (too_many) {
      throw Error("mesh: " + std::to_string(count) + " triangles overlap near (" +
                  std::to_string(cell.box.lo[0]) + ", " + std::to_string(cell.box.lo[1]) + ", " +
                  std::to_string(cell.box.lo[2]) + "), a leaf holds " +
                  std::to_string(kMaxLeafCount) + ": remove repeated triangles");
    }
    make_leaf(cell);
    return leaf_cost;
  }

  const auto level = static_cast<std::size_t>(depth);
  while (levels_.size() <= level) levels_.emplace_back();
  auto& [below, above] = levels_[level];
  divide(cell, split, below, above);

  const std::size_t node = tree_.nodes.size();
  const std::size_t references = tree_.references.size();
  tree_.nodes.push_back({split.plane, static_cast<std::uint32_t>(split.axis), 0, 0});
  const double below_share = below.box.half_area() / cell.box.half_area();
  const double above_share = above.box.half_area() / cell.box.half_area();
  double below_cost = 0.0;
  double above_cost = 0.0;
  tree_.nodes[node].first = static_cast<std::uint32_t>(tree_.nodes.size());
  if (above.fragments.size() >= kForkSize) {
    KdBuilder other(triangles_, rules_);
    std::exception_ptr failure;  // the lower part's is thrown where both fail, as without tasks
    parallel_both([&] { below_cost = build(below, depth + 1, bad_splits); },
                  [&] {
                    try {
                      above_cost = other.build(above, depth + 1, bad_splits);
                    } catch (...) {
                      failure = std::current_exception();
                    }
                  });
    if (failure) std::rethrow_exception(failure);
    tree_.nodes[node].second = static_cast<std::uint32_t>(tree_.nodes.size());
    append(tree_, other.tree());
  } else {
    below_cost = build(below, depth + 1, bad_splits);
    tree_.nodes[node].second = static_cast<std::uint32_t>(tree_.nodes.size());
    above_cost = build(above, depth + 1, bad_splits);
  }
  const double cost = rules_.step_cost + below_share * below_cost + above_share * above_cost;
  if (cost >= leaf_cost && !too_many) {
    tree_.nodes.resize(node);
    tree_.references.resize(references);
    make_leaf(cell);
    return leaf_cost;
  }
  return cost;
}

KdTree build_kd_tree(std::span<const Corners> triangles, const KdRules& rules) {
  KdCell root;
  root.box = rules.box;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    root.fragments.push_back(whole_fragment(triangles, static_cast<std::uint32_t>(i), rules));
  KdBuilder builder(triangles, rules);
  builder.make_events(root);
  builder.build(root, 0, 0);
  return std::move(builder.tree());
}

}  // namespace ti
