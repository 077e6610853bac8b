// SPDX-License-Identifier: Apache-2.0
#include "truth/exact_tracer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "accel/build.hpp"
#include "accel/image.hpp"
#include "model/fp.hpp"
#include "model/kd_tree.hpp"
#include "model/padded_kd_tree.hpp"
#include "model/rd.hpp"
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

/// Where a ray meets a triangle: t in [low, high], without a gap where integers have found it.
struct Meeting {
  double low, high, t;
  std::optional<mpq_class> exact;
};

Meeting exactly(const mpq_class& t) {
  const double near = to_double(t);
  const double error = 0x1p-50 * std::abs(near);
  return {near - error, near + error, near, t};
}

/// How a t stands to all of [low, high]; Open: integers must say.
enum class Order : std::uint8_t { Less, More, Open };
Order order(const Meeting& a, double low, double high) {
  if (a.high < low) return Order::Less;
  return a.low > high ? Order::More : Order::Open;
}

}  // namespace

struct ExactTracer::Impl {
  Impl(const Mesh& mesh, Format number_format)
      : format(number_format), image(image_of(mesh, number_format)), tree(image) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lo[axis] = F::from_bits(image.header().box_lo[axis]);
      box.hi[axis] = F::from_bits(image.header().box_hi[axis]);
    }
    for (std::uint32_t i = 0; i < image.parts().triangle_count; ++i) {
      const ImageCorners packed = image.corners(i);
      Corners& corners = triangles.emplace_back();
      for (std::size_t k = 0; k < 9; ++k)
        corners[k / 3][static_cast<int>(k % 3)] = F::from_bits(packed.p[k / 3][k % 3]).to_float();
    }
  }

  /// Where the ray meets a triangle in its interval.
  [[nodiscard]] std::optional<Meeting> meeting(const Ray& ray, std::uint32_t record) const;
  /// The exact t of a meeting.
  [[nodiscard]] const mpq_class& exact_t(const Ray& ray, std::uint32_t record,
                                         Meeting& meeting) const;
  /// The weights of the second and third corner where the ray meets a triangle.
  [[nodiscard]] glm::dvec2 weights(const Ray& ray, std::uint32_t record) const;
  /// Walks the ray from the box on; `visit` as in `PaddedKdTree::walk`. Nothing for a ray that
  /// passes the box.
  template <typename Visit>
  void walk(const Ray& ray, F tmax, const Visit& visit) const;

  Format format;
  Image image;
  model::PaddedKdTree<F> tree;
  model::Box<F> box;
  std::vector<Corners> triangles;
};

std::optional<Meeting> ExactTracer::Impl::meeting(const Ray& ray, std::uint32_t record) const {
  const QuickMeeting quick = quick_meeting(ray, triangles[record]);
  if (quick.answer == QuickMeeting::Answer::Misses) return std::nullopt;
  if (quick.answer == QuickMeeting::Answer::Meets) {
    const Meeting met{quick.t - quick.error, quick.t + quick.error, quick.t, std::nullopt};
    const double least = std::max(0.0, double{ray.tmin});
    const Order begin = order(met, least, least);
    const Order end = order(met, ray.tmax, ray.tmax);
    if (begin == Order::Less || end == Order::More) return std::nullopt;
    if (begin == Order::More && end == Order::Less) return met;
  }
  const auto met = exact_meeting(ray, triangles[record]);
  if (!met || !in_interval(ray, met->t)) return std::nullopt;
  return exactly(met->t);
}

const mpq_class& ExactTracer::Impl::exact_t(const Ray& ray, std::uint32_t record,
                                            Meeting& meeting) const {
  if (!meeting.exact) meeting = exactly(exact_meeting(ray, triangles[record])->t);
  return *meeting.exact;
}

glm::dvec2 ExactTracer::Impl::weights(const Ray& ray, std::uint32_t record) const {
  const QuickMeeting quick = quick_meeting(ray, triangles[record]);
  if (quick.answer == QuickMeeting::Answer::Meets && quick.weight_error < 0x1p-40)
    return {quick.u, quick.v};
  const auto met = exact_meeting(ray, triangles[record]);
  return {met->u, met->v};
}

template <typename Visit>
void ExactTracer::Impl::walk(const Ray& ray, F tmax, const Visit& visit) const {
  model::FpRay<F> walked;
  for (int axis = 0; axis < 3; ++axis) {
    walked.o[static_cast<std::size_t>(axis)] = F::from_double(ray.o[axis]);
    walked.d[static_cast<std::size_t>(axis)] = F::from_double(ray.d[axis]);
  }
  walked.tmin = F::from_double(ray.tmin);
  walked.tmax = tmax;
  const model::Clipped<F> clipped = clip(box, walked, model::PaddedKdTree<F>::origins(box, walked));
  if (clipped.miss) return;
  Work work;
  const model::WalkLimits limits{model::kMaxStackDepth, std::numeric_limits<std::uint32_t>::max()};
  (void)tree.walk(clipped, limits, work, nullptr, visit);
}

ExactTracer::ExactTracer(const Mesh& mesh, Format format)
    : impl_(std::make_unique<Impl>(mesh, format)) {}

ExactTracer::~ExactTracer() = default;

ExactTracer::Hit ExactTracer::trace(const Ray& given) const {
  Hit best;
  const Ray ray = round_ray(given, impl_->format);
  if (!valid_ray(ray, impl_->format)) return best;
  std::vector<std::uint32_t> records;  // all of least t
  Meeting least{};
  F bound = F::from_double(ray.tmax);
  impl_->walk(ray, bound, [&](std::span<const std::uint32_t> leaf, F, F) {
    for (const std::uint32_t record : leaf) {
      if (std::find(records.begin(), records.end(), record) != records.end()) continue;
      auto met = impl_->meeting(ray, record);
      if (!met) continue;
      Order place = records.empty() ? Order::Less : order(*met, least.low, least.high);
      if (place == Order::More) continue;
      if (place == Order::Open) {
        const int sign =
            cmp(impl_->exact_t(ray, record, *met), impl_->exact_t(ray, records.front(), least));
        if (sign > 0) continue;
        if (sign < 0) place = Order::Less;
      }
      if (place == Order::Less) {
        records.clear();
        least = *met;
        bound = F::from_double(least.high).ulps_up(2);
      }
      records.push_back(record);
    }
    return model::LeafEnd<F>{bound, false, false};
  });
  best.hit = !records.empty();
  if (!best.hit) return best;
  if (least.high - least.low > 0x1p-40 * std::abs(least.t))
    (void)impl_->exact_t(ray, records.front(), least);
  best.t = least.t;
  const auto prim = [this](std::uint32_t record) {
    return static_cast<std::int32_t>(impl_->image.prim(record));
  };
  std::sort(records.begin(), records.end(),
            [&prim](std::uint32_t a, std::uint32_t b) { return prim(a) < prim(b); });
  for (const std::uint32_t record : records) {
    best.prims.push_back(prim(record));
    best.weights.push_back(impl_->weights(ray, record));
  }
  return best;
}

}  // namespace ti
