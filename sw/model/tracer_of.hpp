// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/image.hpp"
#include "base/config_keys.hpp"
#include "model/ist1.hpp"
#include "model/rd.hpp"
#include "model/tracer.hpp"
#include "model/work.hpp"

namespace ti {

/// The engine of a number format, a walk of a tree and a triangle test; nothing of them is virtual.
template <class F, class Tree, class Test>
class TracerOf final : public Tracer {
 public:
  using Number = F;
  static constexpr TreeKind kTree = Tree::kKind;
  static constexpr Traversal kTraversal = Tree::kTraversal;
  static constexpr TestKind kTest = Test::kKind;

  TracerOf(const Image& image, const Options& options)
      : limits_{static_cast<std::size_t>(options.stack_depth),
                static_cast<std::uint32_t>(options.watchdog_steps)},
        interval_cull_(options.interval_cull),
        guard_(static_cast<std::uint32_t>(options.interval_guard)),
        any_hit_(options.any_hit),
        tree_(image),
        test_(image, options.early_exit) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box_.lo[axis] = F::from_bits(image.header().box_lo[axis]);
      box_.hi[axis] = F::from_bits(image.header().box_hi[axis]);
    }
  }

  [[nodiscard]] HitBits trace(const Ray& given, Work& work, const Log* log) const override {
    model::FpRay<F> ray;
    for (int axis = 0; axis < 3; ++axis) {
      ray.o[static_cast<std::size_t>(axis)] = F::from_double(given.o[axis]);
      ray.d[static_cast<std::size_t>(axis)] = F::from_double(given.d[axis]);
    }
    ray.tmin = F::from_double(given.tmin);
    ray.tmax = F::from_double(given.tmax);
    ray.any = given.any;
    if (ray.any && !any_hit_) return miss({Status::InvalidRay, 0});

    model::Clipped<F> clipped = clip(box_, ray, Tree::origins(box_, ray));
    if constexpr (kTest == TestKind::Woop) clipped.shear = model::shear_of(ray.d, clipped.inv);
    if (clipped.miss) return miss({clipped.status, 0});
    Best best{ray.tmax, F{}, F{}};
    const model::Walked walked = tree_.walk(
        clipped, limits_, work, log, [&](std::span<const std::uint32_t> records, F entry, F exit) {
          const bool whole =
              test_leaf(records, ray, clipped, range(entry, exit, best.t), best, work);
          return model::LeafEnd<F>{best.t, ray.any && best.prim != kNoPrim, !whole};
        });
    HitBits hit = miss(walked);
    if (walked.status != Status::Ok || best.prim == kNoPrim) return hit;
    hit.t = ray.any ? 0 : best.t.bits();
    hit.u = ray.any ? 0 : best.u.bits();
    hit.v = ray.any ? 0 : best.v.bits();
    hit.prim = ray.any ? 0 : static_cast<std::int32_t>(best.prim);
    return hit;
  }

 private:
  struct Best {
    F t, u, v;
    std::uint32_t prim = kNoPrim;
  };
  static constexpr std::uint32_t kNoPrim = 0xffffffffU;

  [[nodiscard]] static HitBits miss(const model::Walked& walked) {
    HitBits hit;
    hit.t = F::kInfBits;
    hit.status = walked.status;
    hit.steps = static_cast<std::uint16_t>(walked.steps);
    return hit;
  }

  /// Where the tests of a leaf count: in its interval, moved outward by the guard, and not beyond
  /// the best t from before the leaf.
  [[nodiscard]] model::TestRange<F> range(F entry, F exit, F tbest) const {
    if (!interval_cull_) return {F{}, tbest};
    return {entry.ulps_down(guard_), tbest <= exit ? tbest : exit.ulps_up(guard_)};
  }

  /// All triangles of a leaf, up to an entry that names none; whether there was no such.
  [[nodiscard]] bool test_leaf(std::span<const std::uint32_t> records, const model::FpRay<F>& ray,
                               const model::Clipped<F>& clipped, const model::TestRange<F>& range,
                               Best& best, Work& work) const {
    for (const std::uint32_t record : records) {
      if (record >= test_.size()) return false;
      const auto c = test_.test(record, ray, clipped, range, work);
      if (!c || !(ray.tmin <= c->t)) continue;
      const std::uint32_t prim = test_.prim(record);
      if (c->t < best.t || (c->t == best.t && prim < best.prim)) best = {c->t, c->u, c->v, prim};
    }
    return true;
  }

  model::WalkLimits limits_;
  bool interval_cull_;
  std::uint32_t guard_;
  bool any_hit_;
  Tree tree_;
  Test test_;
  model::Box<F> box_;
};

}  // namespace ti
