// SPDX-License-Identifier: Apache-2.0
#include "model/tracer.hpp"

#include <fmt/core.h>

#include <mutex>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "model/fp.hpp"
#include "model/ist1.hpp"
#include "model/ist2.hpp"
#include "model/rd.hpp"
#include "model/trv.hpp"

namespace ti {
namespace {

template <class F>
class TracerOf final : public Tracer {
 public:
  TracerOf(const Image& image, const Options& options)
      : options_(options),
        root_(image.header().root),
        nodes_(image.nodes()),
        list_(image.list()),
        planes_(image.planes()),
        barys_(image.barys()) {
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

    const model::Clipped<F> clipped = clip(box_, ray);
    if (clipped.miss) return miss(clipped.status, 0);
    return walk(ray, clipped, work, log);
  }

 private:
  struct Best {
    F t, u, v;
    std::uint32_t prim = kNoPrim;
  };
  static constexpr std::uint32_t kNoPrim = 0xffffffffU;

  [[nodiscard]] static HitBits miss(Status status, std::uint32_t steps) {
    HitBits hit;
    hit.t = F::kInfBits;
    hit.status = status;
    hit.steps = static_cast<std::uint16_t>(steps);
    return hit;
  }

  [[nodiscard]] HitBits walk(const model::FpRay<F>& ray, const model::Clipped<F>& clipped,
                             Work& work, const Log* log) const {
    model::ShortStack<F> stack(static_cast<std::size_t>(options_.stack_depth));
    F tmin = clipped.tmin;
    F tmax = clipped.tmax;
    Best best{ray.tmax, F{}, F{}};
    std::uint32_t index = root_;
    std::uint32_t steps = 0;

    for (;;) {
      ++work.steps;
      if (steps >= static_cast<std::uint32_t>(options_.watchdog_steps))
        return miss(Status::Watchdog, steps);
      ++steps;
      const ImageNode node = nodes_[index];
      if (!node.is_leaf()) {
        const F t = model::split_distance(node, ray.o, clipped.inv);
        const auto [near, far] = model::ordered(node, index, clipped.inv[node.axis()].signbit());
        const model::Side side = model::choose(t, tmin, tmax);
        if (log) (*log)(fmt::format("node {} t {:08x} {}", index, t.bits(), name(side)));
        index = side == model::Side::Far ? far : near;
        if (side == model::Side::Both) {
          stack.push({far, tmax});
          tmax = t;
        }
        continue;
      }

      ++work.leaves;
      const F exit = tmax;
      if (log) (*log)(fmt::format("node {} leaf {} exit {:08x}", index, node.count(), exit.bits()));
      if (node.count() != 0) {
        ++work.full_leaves;
        test_leaf(node, ray, best, work);
      }
      const bool has_hit = best.prim != kNoPrim;
      if (best.t <= exit || (ray.any && has_hit)) break;
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
        break;
      }
    }

    HitBits hit = miss(Status::Ok, steps);
    if (best.prim == kNoPrim) return hit;
    hit.t = ray.any ? 0 : best.t.bits();
    hit.u = ray.any ? 0 : best.u.bits();
    hit.v = ray.any ? 0 : best.v.bits();
    hit.prim = ray.any ? 0 : static_cast<std::int32_t>(best.prim);
    return hit;
  }

  /// All triangles of a leaf, each with the best t from before the leaf.
  void test_leaf(const ImageNode& leaf, const model::FpRay<F>& ray, Best& best, Work& work) const {
    const F tbest = best.t;
    for (std::uint32_t i = 0; i < leaf.count(); ++i) {
      const std::uint32_t record = list_[leaf.value + i];
      const ImagePlane& plane = planes_[record];
      ++work.a_tests;
      const auto a = model::pass_a(plane, ray.o, ray.d, tbest);
      if (!a) continue;
      ++work.b_tests;
      const auto b = model::pass_b(plane, barys_[record], ray.d, *a);
      if (!b) continue;
      ++work.c_tests;
      const auto c = model::pass_c(*b);
      if (!c || !(ray.tmin <= c->t)) continue;
      if (c->t < best.t || (c->t == best.t && plane.prim < best.prim))
        best = {c->t, c->u, c->v, plane.prim};
    }
  }

  [[nodiscard]] static const char* name(model::Side side) {
    return side == model::Side::Near ? "near" : side == model::Side::Far ? "far" : "both";
  }

  Options options_;
  std::uint32_t root_;
  std::span<const ImageNode> nodes_;
  std::span<const std::uint32_t> list_;
  std::span<const ImagePlane> planes_;
  std::span<const ImageBary> barys_;
  model::Box<F> box_;
};

struct Builder {
  Format format;
  std::unique_ptr<Tracer> (*create)(const Image&, const Tracer::Options&);
};

template <int E, int M>
constexpr Builder kBuilder{
    Format{E, M}, [](const Image& image, const Tracer::Options& options) {
      return std::unique_ptr<Tracer>(std::make_unique<TracerOf<Fp<E, M>>>(image, options));
    }};

constexpr std::array kBuilders{kBuilder<8, 23>, kBuilder<8, 20>, kBuilder<7, 16>, kBuilder<8, 16>,
                               kBuilder<8, 13>, kBuilder<5, 10>, kBuilder<8, 10>};

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
  for (const Builder& builder : kBuilders) {
    if (builder.format == image.format()) return builder.create(image, options);
  }
  throw Error(
      fmt::format("the model is not built for the number format ({},{}): use one of {}, or add it "
                  "to kBuilders in "
                  "sw/model/tracer.cpp",
                  image.format().exp_bits, image.format().frac_bits, tracer_formats()));
}

std::string tracer_formats() {
  std::string text;
  for (const Builder& builder : kBuilders) {
    text += fmt::format("{}({},{})", text.empty() ? "" : ", ", builder.format.exp_bits,
                        builder.format.frac_bits);
  }
  return text;
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
