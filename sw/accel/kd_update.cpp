// SPDX-License-Identifier: Apache-2.0
#include "accel/kd_update.hpp"

#include <algorithm>
#include <utility>

#include "accel/kd_builder.hpp"

namespace ti {
namespace {

/// A cell is built anew when this share of its references moved, 1 / kAnew.
constexpr std::uint64_t kAnew = 8;

class Updater {
 public:
  Updater(const KdTree& old, std::span<const Corners> triangles,
          const std::vector<std::uint8_t>& moved, const KdRules& rules)
      : old_(old), triangles_(triangles), moved_(moved), rules_(rules) {
    moved_before_.reserve(old.references.size() + 1);
    moved_before_.push_back(0);
    for (const std::uint32_t triangle : old.references)
      moved_before_.push_back(moved_before_.back() + moved[triangle]);
  }

  /// Adds the tree of the old node's cell; `here` are the moved triangles that are in it now.
  void visit(std::uint32_t node, const Box& box, const std::vector<Fragment>& here, int depth);

  KdTree tree;
  KdUpdate update;

 private:
  /// What belongs to a subtree stands together: nodes [node, end), references [first, last).
  struct Span {
    std::uint32_t end, first, last;
  };
  [[nodiscard]] Span span_of(std::uint32_t node) const;
  void copy(std::uint32_t node, const Span& span);
  void build(const Span& span, const Box& box, const std::vector<Fragment>& here, int depth);

  const KdTree& old_;
  std::span<const Corners> triangles_;
  const std::vector<std::uint8_t>& moved_;
  const KdRules& rules_;
  std::vector<std::uint32_t> moved_before_;  ///< of the old references, how many before each
};

Updater::Span Updater::span_of(std::uint32_t node) const {
  std::uint32_t left = node;
  while (!old_.nodes[left].is_leaf()) left = old_.nodes[left].first;
  std::uint32_t right = node;
  while (!old_.nodes[right].is_leaf()) right = old_.nodes[right].second;
  const KdNode& last = old_.nodes[right];
  return {right + 1, old_.nodes[left].first, last.first + last.second};
}

void Updater::copy(std::uint32_t node, const Span& span) {
  // Differences wrap around, as unsigned numbers do.
  const auto node_shift = static_cast<std::uint32_t>(tree.nodes.size()) - node;
  const auto reference_shift = static_cast<std::uint32_t>(tree.references.size()) - span.first;
  for (std::uint32_t i = node; i < span.end; ++i) {
    KdNode copied = old_.nodes[i];
    copied.first += copied.is_leaf() ? reference_shift : node_shift;
    if (!copied.is_leaf()) copied.second += node_shift;
    tree.nodes.push_back(copied);
  }
  tree.references.insert(tree.references.end(), old_.references.begin() + span.first,
                         old_.references.begin() + span.last);
}

void Updater::build(const Span& span, const Box& box, const std::vector<Fragment>& here,
                    int depth) {
  std::vector<std::uint32_t> still;
  for (std::uint32_t i = span.first; i < span.last; ++i)
    if (moved_[old_.references[i]] == 0) still.push_back(old_.references[i]);
  std::sort(still.begin(), still.end());
  still.erase(std::unique(still.begin(), still.end()), still.end());

  KdCell cell{.box = box, .fragments = {}, .events = {}};
  for (const std::uint32_t triangle : still)
    cell.fragments.push_back(
        clipped_fragment(triangles_, whole_fragment(triangles_, triangle, rules_), box, rules_));
  cell.fragments.insert(cell.fragments.end(), here.begin(), here.end());
  KdBuilder builder(triangles_, rules_);
  builder.make_events(cell);
  builder.build(cell, depth, 0);
  ++update.cells;
  update.references += static_cast<std::uint32_t>(builder.tree().references.size());
  append(tree, builder.tree());
}

void Updater::visit(std::uint32_t node, const Box& box, const std::vector<Fragment>& here,
                    int depth) {
  const KdNode& from = old_.nodes[node];
  const Span span = span_of(node);
  const std::uint64_t left = moved_before_[span.last] - moved_before_[span.first];
  if (left == 0 && here.empty()) {
    copy(node, span);
    return;
  }
  const std::uint64_t references = span.last - span.first + here.size();
  if (from.is_leaf() || kAnew * (left + here.size()) >= references) {
    build(span, box, here, depth);
    return;
  }
  Box below = box;
  Box above = box;
  below.hi[from.axis] = above.lo[from.axis] = static_cast<double>(from.split);
  std::vector<Fragment> lower;
  std::vector<Fragment> upper;
  for (const Fragment& fragment : here) {
    if (from.split >= fragment.after[from.axis]) {
      lower.push_back(fragment);
    } else if (from.split <= fragment.before[from.axis]) {
      upper.push_back(fragment);
    } else {
      lower.push_back(clipped_fragment(triangles_, fragment, below, rules_));
      upper.push_back(clipped_fragment(triangles_, fragment, above, rules_));
    }
  }
  const std::size_t place = tree.nodes.size();
  tree.nodes.push_back({from.split, from.axis, static_cast<std::uint32_t>(place + 1), 0});
  visit(from.first, below, lower, depth + 1);
  tree.nodes[place].second = static_cast<std::uint32_t>(tree.nodes.size());
  visit(from.second, above, upper, depth + 1);
}

}  // namespace

KdTree update_kd_tree(const KdTree& old, std::span<const Corners> triangles,
                      const std::vector<std::uint8_t>& moved, const KdRules& rules,
                      KdUpdate& update) {
  std::vector<Fragment> here;
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    if (moved[i] != 0) here.push_back(whole_fragment(triangles, i, rules));
  Updater updater(old, triangles, moved, rules);
  updater.visit(0, rules.box, here, 0);
  update = updater.update;
  return std::move(updater.tree);
}

}  // namespace ti
