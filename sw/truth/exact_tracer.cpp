// SPDX-License-Identifier: Apache-2.0
#include "truth/exact_tracer.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "accel/build.hpp"
#include "accel/image.hpp"
#include "model/fp.hpp"
#include "model/kd_tree.hpp"
#include "model/padded_kd_tree.hpp"
#include "model/rd.hpp"
#include "truth/bounds.hpp"
#include "truth/exact.hpp"
#include "truth/impl.hpp"

namespace ti {
namespace {

using F = Fp<8, 23>;
constexpr Format kBinary32{8, 23};

Image image_of(const Mesh& mesh, Format format) {
  Mesh rounded;
  rounded.triangles = mesh.triangles;
  rounded.vertices.reserve(mesh.vertices.size());
  for (const glm::vec3& p : mesh.vertices) {
    const auto in_format = [format](float x) { return static_cast<float>(round_to(format, x)); };
    rounded.vertices.emplace_back(in_format(p.x), in_format(p.y), in_format(p.z));
  }
  BuildOptions options;
  options.format = kBinary32;
  options.test = TestKind::Woop;
  BuildStats stats;
  return build_image(rounded, options, stats);
}

}  // namespace

struct ExactTracer::Impl {
  Impl(const Mesh& mesh, Format number_format)
      : format(number_format), ops(kBinary32), image(image_of(mesh, number_format)), tree(image) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lo[axis] = F::from_bits(image.header().box_lo[axis]);
      box.hi[axis] = F::from_bits(image.header().box_hi[axis]);
    }
    for (std::uint32_t i = 0; i < image.parts().triangle_count; ++i) {
      const ImageCorners packed = image.corners(i);
      TestConstants constants;
      constants.test = TestKind::Woop;
      for (std::size_t k = 0; k < 9; ++k) {
        constants.corners[k / 3][static_cast<int>(k % 3)] =
            F::from_bits(packed.p[k / 3][k % 3]).to_float();
      }
      triangles.push_back(constants);
    }
  }

  Format format;
  BoundedOps ops;
  Image image;
  model::PaddedKdTree<F> tree;
  model::Box<F> box;
  std::vector<TestConstants> triangles;
};

ExactTracer::ExactTracer(const Mesh& mesh, Format format)
    : impl_(std::make_unique<Impl>(mesh, format)) {}

ExactTracer::~ExactTracer() = default;

ExactTracer::Hit ExactTracer::trace(const Ray& given) const {
  Hit best;
  const Ray ray = round_ray(given, impl_->format);
  if (!valid_ray(ray, impl_->format)) return best;
  model::FpRay<F> walked;
  for (int axis = 0; axis < 3; ++axis) {
    walked.o[static_cast<std::size_t>(axis)] = F::from_double(ray.o[axis]);
    walked.d[static_cast<std::size_t>(axis)] = F::from_double(ray.d[axis]);
  }
  walked.tmin = F::from_double(ray.tmin);
  walked.tmax = F::from_double(ray.tmax);
  const model::Clipped<F> clipped =
      clip(impl_->box, walked, model::PaddedKdTree<F>::origins(impl_->box, walked));
  if (clipped.miss) return best;

  mpq_class least;
  std::vector<std::uint32_t> looked;
  F bound = walked.tmax;
  Work work;
  const auto visit = [&](std::span<const std::uint32_t> records, F, F) {
    for (const std::uint32_t record : records) {
      const TestConstants& triangle = impl_->triangles[record];
      if (!may_meet(impl_->ops, triangle, ray)) continue;
      if (std::find(looked.begin(), looked.end(), record) != looked.end()) continue;
      looked.push_back(record);
      const auto meeting = exact_meeting(ray, triangle.corners);
      if (!meeting || !in_interval(ray, meeting->t) || (best.hit && meeting->t > least)) continue;
      if (!best.hit || meeting->t < least) {
        best.prims.clear();
        best.weights.clear();
        least = meeting->t;
        best.hit = true;
        best.t = to_double(least);
        bound = F::from_double(best.t).ulps_up(2);
      }
      const auto prim = static_cast<std::int32_t>(impl_->image.prim(record));
      const auto at = std::lower_bound(best.prims.begin(), best.prims.end(), prim);
      best.weights.insert(best.weights.begin() + (at - best.prims.begin()),
                          {meeting->u, meeting->v});
      best.prims.insert(at, prim);
    }
    return model::LeafEnd<F>{bound, false};
  };
  const model::WalkLimits limits{model::kMaxStackDepth, std::numeric_limits<std::uint32_t>::max()};
  (void)impl_->tree.walk(clipped, limits, work, nullptr, visit);
  return best;
}

}  // namespace ti
