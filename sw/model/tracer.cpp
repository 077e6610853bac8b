// SPDX-License-Identifier: Apache-2.0
#include "model/tracer.hpp"

#include <fmt/core.h>

#include <array>
#include <mutex>
#include <optional>
#include <span>
#include <utility>

#include "accel/tree_bounds.hpp"
#include "base/config_keys.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "model/fp.hpp"
#include "model/kd_tree.hpp"
#include "model/padded_kd_tree.hpp"
#include "model/plane_test.hpp"
#include "model/tracer_of.hpp"
#include "model/woop_test.hpp"

namespace ti {
namespace {

struct Maker {
  TreeKind tree;
  Traversal traversal;
  TestKind test;
  std::unique_ptr<Tracer> (*make)(const Image&, const Tracer::Options&);
};

template <class T>
constexpr Maker kMaker{T::kTree, T::kTraversal, T::kTest,
                       [](const Image& image, const Tracer::Options& options) {
                         return std::unique_ptr<Tracer>(std::make_unique<T>(image, options));
                       }};

/// The engines of a number format: each walk with each test.
template <class F, template <class> class... Trees>
constexpr auto makers_of() {
  return std::array{kMaker<TracerOf<F, Trees<F>, model::PlaneTest<F, TestKind::Local>>>...,
                    kMaker<TracerOf<F, Trees<F>, model::PlaneTest<F, TestKind::Np>>>...,
                    kMaker<TracerOf<F, Trees<F>, model::WoopTest<F>>>...};
}

constexpr auto kMakers = []<std::size_t... I>(std::index_sequence<I...>) {
  return std::array{makers_of<Fp<kModelFormats[I].exp_bits, kModelFormats[I].frac_bits>,
                              model::KdTree, model::PaddedKdTree>()...};
}(std::make_index_sequence<std::size(kModelFormats)>{});

/// The one of `makers` for an image and options.
template <std::size_t N>
std::unique_ptr<Tracer> make(const std::array<Maker, N>& makers, const Image& image,
                             const Tracer::Options& options) {
  for (const Maker& maker : makers) {
    if (maker.tree == image.header().tree && maker.traversal == options.traversal &&
        maker.test == image.header().test) {
      return maker.make(image, options);
    }
  }
  throw Error("the model has no such tree and triangle test");  // no image passes its checks so
}

/// Traces in a format that the model is not compiled for.
class AnyTracer final : public Tracer {
 public:
  AnyTracer(const Image& image, const Options& options) : rules_(image.format()) {
    const FormatScope scope(rules_);
    constexpr auto kAny = makers_of<AnyFp, model::KdTree, model::PaddedKdTree>();
    tracer_ = make(kAny, image, options);
  }
  using Tracer::trace;
  [[nodiscard]] HitBits trace(const Ray& ray, Work& work, const Log* log) const override {
    const FormatScope scope(rules_);
    return tracer_->trace(ray, work, log);
  }

 private:
  FpRules rules_;
  std::unique_ptr<Tracer> tracer_;
};

/// Throws `Error` for a tree that may ask for more entries than a stack has.
void check_stack(const Image& image, int stack_depth) {
  const std::optional<TreeBounds> bounds = tree_bounds(image);
  if (!bounds)
    throw Error("restart is false, and the nodes of the image share children: set it to true");
  if (bounds->stack <= stack_depth) return;
  throw Error(
      fmt::format("restart is false, and a ray through this tree may have {} entries on its stack, "
                  "but stack_depth is {}: set restart to true, or stack_depth to {}",
                  bounds->stack, stack_depth, bounds->stack));
}

}  // namespace

Work& Work::operator+=(const Work& other) {
  steps += other.steps;
  leaves += other.leaves;
  full_leaves += other.full_leaves;
  restarts += other.restarts;
  a_tests += other.a_tests;
  b_tests += other.b_tests;
  c_tests += other.c_tests;
  return *this;
}

std::unique_ptr<Tracer> Tracer::create(const Image& image, const Options& options) {
  if (options.stack_depth < 0 || options.stack_depth > model::kMaxStackDepth) {
    throw Error(
        fmt::format("the model has no short stack of {} entries: set `stack_depth`, 0 to {}",
                    options.stack_depth, model::kMaxStackDepth));
  }
  if (!options.restart) check_stack(image, options.stack_depth);
  if (const int depth = tree_depth(image);
      options.traversal == Traversal::kPadded && depth > model::kTrailLevels) {
    throw Error(
        fmt::format("the tree is {} levels deep, and the trail of a padded walk has {}: "
                    "build it anew, or set `traversal` to plain",
                    depth, model::kTrailLevels));
  }
  for (std::size_t i = 0; i < kMakers.size(); ++i) {
    if (kModelFormats[i] == image.format()) return make(kMakers[i], image, options);
  }
  return std::make_unique<AnyTracer>(image, options);
}

std::vector<HitBits> Tracer::trace(std::span<const Ray> rays, Work& work) const {
  std::vector<HitBits> hits(rays.size());
  std::mutex mutex;
  parallel_pieces(rays.size(), 1024, [&](std::size_t first, std::size_t last) {
    Work mine;
    for (std::size_t i = first; i < last; ++i) hits[i] = trace(rays[i], mine);
    const std::lock_guard lock(mutex);
    work += mine;
  });
  return hits;
}

Hit hit_of(Format format, const HitBits& bits) {
  Hit hit;
  hit.t = static_cast<float>(value_of_bits(format, bits.t));
  hit.u = static_cast<float>(value_of_bits(format, bits.u));
  hit.v = static_cast<float>(value_of_bits(format, bits.v));
  hit.prim = bits.prim;
  hit.status = bits.status;
  hit.steps = bits.steps;
  return hit;
}

}  // namespace ti
