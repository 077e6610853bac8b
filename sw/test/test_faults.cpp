// SPDX-License-Identifier: Apache-2.0
// The volume tests can fail: each guard that keeps a walk or a test right is taken away, and rays
// of the same kinds that find nothing wrong in the engine find that.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "accel/build.hpp"
#include "accel/tree_bounds.hpp"
#include "cull_claim.hpp"
#include "model/fp.hpp"
#include "model/kd_tree.hpp"
#include "model/padded_kd_tree.hpp"
#include "model/plane_test.hpp"
#include "model/tracer_of.hpp"
#include "model/woop_test.hpp"
#include "reference_test.hpp"
#include "scene/aimed_rays.hpp"
#include "tree_walk.hpp"
#include "truth/accuracy.hpp"
#include "truth/exact_tracer.hpp"

namespace ti {
namespace {

/// Numbers of (E, M) of a type of their own for each fault, whose specializations below are the
/// fault.
template <int E, int M, int kFault>
struct Tagged : FixedFormat<E, M, Modes{}> {};
template <int kFault>
using Number = FpNumber<Tagged<8, 23, kFault>>;
constexpr int kNone = 0;
constexpr int kStrict = 1;                // `<` for `<=`: a plane at t == tmin keeps the near side
constexpr int kFused = 2;                 // a product of an edge function is not rounded
constexpr int kSharp = 3;                 // the cull of pass (a) without its guard
using Thin = FpNumber<Tagged<8, 13, 4>>;  // a ray without the thickness
using Bare = FpNumber<Tagged<4, 3, kSharp>>;

}  // namespace

namespace model {

template <>
Side choose(Number<kStrict> t, Number<kStrict> tmin, Number<kStrict> tmax) {
  if (!(t < tmax)) return Side::Near;
  return t < tmin ? Side::Far : Side::Both;
}

template <>
Number<kFused> difference_of_products(Number<kFused> a, Number<kFused> b, Number<kFused> c,
                                      Number<kFused> d) {
  const float cd = (c * d).to_float();
  return Number<kFused>::from_double(std::fma(a.to_float(), b.to_float(), -cd));
}

template <>
std::uint32_t thickness_places<Thin>() {
  return thickness_places<Fp<8, 13>>() + 8;
}
template <>
std::uint32_t cull_ulps<Number<kSharp>>() {
  return 0;
}
template <>
std::uint32_t cull_ulps<Bare>() {
  return 0;
}

}  // namespace model

namespace {

Image image_of(const Mesh& mesh, BuildOptions options) {
  BuildStats stats;
  return build_image(mesh, options, stats);
}

/// The tree that is one leaf: each ray tests all triangles.
BuildOptions one_leaf(BuildOptions options) {
  options.depth_base = options.depth_factor = 0.0;
  return options;
}

std::vector<Ray> aimed(const Mesh& mesh, std::initializer_list<Aim> aims, std::uint64_t each) {
  std::vector<Ray> rays;
  for (const Aim aim : aims) {
    const AimedRays source(mesh, aim, 3);
    for (std::uint64_t i = 0; i < each; ++i) rays.push_back(source(i));
  }
  return rays;
}

/// Rays of which the engine finds another triangle than the same test does without a tree.
std::uint64_t lost(const Tracer& engine, const Tracer& all, const std::vector<Ray>& rays) {
  Work work;
  const auto got = engine.trace(rays, work);
  const auto want = all.trace(rays, work);
  std::uint64_t lost = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) lost += got[i].prim != want[i].prim ? 1 : 0;
  return lost;
}

template <int kFault>
using Plain = TracerOf<Number<kFault>, model::KdTree<Number<kFault>>,
                       model::PlaneTest<Number<kFault>, TestKind::Local>>;
template <int kFault>
using Padded =
    TracerOf<Number<kFault>, model::PaddedKdTree<Number<kFault>>, model::WoopTest<Number<kFault>>>;

TEST_CASE("faults: without the guards of the cull hits in a plane are lost") {
  const Mesh mesh = soup(500, 0.2F, 4);
  const Image image = image_of(mesh, {.format = {}, .dilation = 0.0});
  const Image leaf = image_of(mesh, one_leaf({}));
  const auto rays = aimed(mesh, {Aim::Edges}, 20000);
  const Plain<kNone> all(leaf, {});
  CHECK(lost(Plain<kNone>(image, {}), all, rays) == 0);
  CHECK(lost(Plain<kSharp>(image, {.interval_guard = 0}), all, rays) > 0);
}

TEST_CASE("faults: pass (a) without its guard drops a test that counts") {
  CHECK(wrong_drops<Fp<4, 3>>().wrong == 0);
  CHECK(wrong_drops<Bare>().wrong > 0);
}

TEST_CASE("faults: without the dilation of the builder hits beside a plane are lost") {
  const Mesh mesh = soup(1000, 0.05F, 4);
  const Image leaf = image_of(mesh, one_leaf({}));
  const auto rays = aimed(mesh, {Aim::Vertices}, 5000);
  const Plain<kNone> all(leaf, {});
  const auto lost_with = [&](double dilation) {
    const Image image = image_of(mesh, {.format = {}, .dilation = dilation});
    return lost(Plain<kNone>(image, {}), all, rays);
  };
  CHECK(lost_with(BuildOptions{}.dilation) == 0);
  CHECK(lost_with(0.0) > 0);
}

std::uint64_t watchdogs(const Tracer& engine, const std::vector<Ray>& rays) {
  Work work;
  std::uint64_t ended = 0;
  for (const HitBits& hit : engine.trace(rays, work))
    ended += hit.status == Status::Watchdog ? 1 : 0;
  return ended;
}

TEST_CASE("faults: < for <= at tmin has restarts that do not advance") {
  const Mesh mesh = soup(500, 0.2F, 4);
  const Image image = image_of(mesh, {});
  const auto rays = aimed(mesh, {Aim::Uniform, Aim::Edges}, 500);
  const int most = static_cast<int>(tree_bounds(image)->steps);
  const Tracer::Options options{.stack_depth = 0, .watchdog_steps = most};
  CHECK(watchdogs(Plain<kNone>(image, options), rays) == 0);
  CHECK(watchdogs(Plain<kStrict>(image, options), rays) > 0);
}

TEST_CASE("faults: a fused product in the sign of an edge lets rays through") {
  const Mesh mesh = reference::sphere(3);
  const Image image = image_of(mesh, {.format = {}, .test = TestKind::Woop});
  const ExactTracer exact(mesh, {});
  const AimedRays rays(mesh, Aim::Edges, 3);
  const auto cracks = [&](const Tracer& engine) {
    const std::array<const Tracer*, 1> only{&engine};
    return hit_errors(only, exact, mesh, {}, rays, 10000).front().cracks;
  };
  CHECK(cracks(Padded<kNone>(image, {})) == 0);
  CHECK(cracks(Padded<kFused>(image, {})) > 0);
}

TEST_CASE("faults: a ray without thickness misses cells from afar") {
  const Mesh mesh = reference::sphere(3);
  const BuildOptions options{.format = {8, 13}, .test = TestKind::Woop, .dilation = 0.0};
  const Image image = image_of(mesh, options);
  const Image leaf = image_of(mesh, one_leaf(options));
  const auto rays = aimed(mesh, {Aim::Far}, 8000);
  const Tracer::Options padded{.traversal = Traversal::kPadded};
  const auto all = Tracer::create(leaf, padded);
  const TracerOf<Thin, model::PaddedKdTree<Thin>, model::WoopTest<Thin>> thin(image, padded);
  CHECK(lost(*Tracer::create(image, padded), *all, rays) == 0);
  CHECK(lost(thin, *all, rays) > 0);
}

}  // namespace
}  // namespace ti
