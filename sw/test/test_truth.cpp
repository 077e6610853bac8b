// SPDX-License-Identifier: Apache-2.0
// Exact arithmetic gives the written results, and Embree runs beside it without disturbing it.
#include <doctest/doctest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cfenv>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "embree_devices.hpp"
#include "portable_random.hpp"
#include "reference_test.hpp"
#include "support.hpp"
#include "truth/exact.hpp"
#include "truth/truth.hpp"
#include "truth_test.hpp"

namespace {

using namespace ti;
using namespace ti::test;
using reference::sphere;

TEST_CASE("exact rationals come back as the nearest double") {
  CHECK(to_double(mpq_class(0)) == 0.0);
  CHECK(to_double(mpq_class(1, 3)) == 1.0 / 3.0);
  CHECK(to_double(mpq_class(-5)) == -5.0);
  CHECK(to_double(mpq_class(mpz_class(1) << 1000)) == std::ldexp(1.0, 1000));
  CHECK(to_double(mpq_class(1, mpz_class(1) << 1060)) == std::ldexp(1.0, -1060));
}

TEST_CASE("exact meeting handles subnormals and the largest values without rounding") {
  const Ray ray{{0, 0, 0}, 0.0F, {0, 0, 0x1p127F}, kInf, false};
  const auto met =
      exact_meeting(ray, {glm::vec3{-1, -1, 0x1p-149F}, {1, -1, 0x1p-149F}, {0, 1, 0x1p-149F}});
  REQUIRE(met);
  CHECK(met->t == mpq_class(1, mpz_class(1) << 276));
  CHECK_FALSE(met->boundary);
  CHECK_FALSE(exact_meeting(ray, {glm::vec3{0, 0, 1}, {0, 0, 2}, {0, 0, 3}}));
}

TEST_CASE("the interval is closed and never holds a negative t") {
  const auto holds = [](float tmin, float tmax, int t) {
    return in_interval({{0, 0, 0}, tmin, {0, 0, 1}, tmax, false}, mpq_class(t));
  };
  CHECK(holds(5, 5, 5));
  CHECK(holds(0, kInf, 0));
  CHECK(holds(-kInf, kInf, 5));
  CHECK_FALSE(holds(-9, 9, -5));
  CHECK_FALSE(holds(std::nextafter(5.0F, 6.0F), 9, 5));
  CHECK_FALSE(holds(0, std::nextafter(5.0F, 0.0F), 5));
  CHECK_FALSE(holds(kNan, 9, 5));
  CHECK_FALSE(holds(0, kNan, 5));
  CHECK_FALSE(holds(kInf, kInf, 5));
}

TEST_CASE("exact lists all ids of the least t and sees edges") {
  const Truth truth(two_squares(), kF32);
  const auto inner = truth.exact(up(1.5F, 0.5F));
  CHECK(inner.prims == std::vector<std::int32_t>{0});
  CHECK(inner.t == 1.0);
  CHECK_FALSE(inner.on_boundary);
  const auto edge = truth.exact(up(0.5F, 0.5F));
  CHECK(edge.prims == std::vector<std::int32_t>{0, 1});
  CHECK(edge.on_boundary);
  CHECK_FALSE(truth.exact(up(2.5F, 0.5F)).hit);
  Ray later = up(1.5F, 0.5F);
  later.tmin = 1.5F;
  CHECK(truth.exact(later).prims == std::vector<std::int32_t>{2});
}

TEST_CASE("triangles that the builder drops do not exist") {
  Mesh mesh = two_squares();
  mesh.vertices[1].x = kNan;            // drops 0
  mesh.triangles[1] = {0, 2, 2};        // no area
  mesh.triangles.push_back({4, 4, 6});  // no area
  const Truth truth(mesh, kF32, each_embree_device());
  const Ray ray = up(1.5F, 0.5F);
  CHECK(truth.exact(ray).prims == std::vector<std::int32_t>{2});
  CHECK(truth.trace(std::span(&ray, 1)).front().prim == 2);
  CHECK(judge(truth, ray, {1.0F, 0.5F, 0.25F, 0, Status::Ok, 0}) == Verdict::Unexplained);
}

TEST_CASE("an empty mesh misses everything") {
  const Truth truth(Mesh{}, kF32, each_embree_device());
  CHECK_FALSE(truth.exact(up(0, 0)).hit);
  CHECK(judge(truth, up(0, 0), {}) == Verdict::Agree);
  CHECK(judge(truth, up(0, 0), {1.0F, 0, 0, 0, Status::Ok, 0}) == Verdict::Unexplained);
}

TEST_CASE("a triangle that names a vertex beyond the mesh is an error") {
  Mesh mesh = two_squares();
  mesh.triangles[0][1] = 8;
  CHECK_THROWS_AS(Truth(mesh, kF32), Error);
}

TEST_CASE("Embree runs here with at least one instruction set, and leaves subnormals on") {
  std::string ran;
  for (const std::string& device : EmbreeScene::devices()) {
    ran += " " + device;
    const Truth truth(two_squares(), kF32, device);
    volatile float subnormal = 0x1p-140F;
    CHECK(subnormal * 0.5F == 0x1p-141F);
  }
  MESSAGE("Embree ran with" << ran);
  CHECK_FALSE(ran.empty());
}

TEST_CASE("tasks compute as the thread that starts them, and keep subnormals after Embree") {
  const Truth truth(sphere(5), kF32);
  std::atomic<int> others{0};
  std::fesetround(FE_UPWARD);
  parallel_pieces(1000, 1, [&](std::size_t, std::size_t) {
    volatile float subnormal = 0x1p-140F;
    for (int i = 0; i < 1000; ++i) subnormal = subnormal * 0.5F * 2.0F;
    if (subnormal != 0x1p-140F || std::fegetround() != FE_UPWARD) ++others;
  });
  std::fesetround(FE_TONEAREST);
  CHECK(others == 0);
}

TEST_CASE("disagreements beyond the limit are counted, the first ones are judged") {
  std::vector<Ray> rays;
  for (int i = 1; i <= 600; ++i) {  // every third on the edge that two triangles share
    const float x = 0.003F * static_cast<float>(i);
    rays.push_back(up(x, i % 3 == 0 ? x : x + 0.1F));
  }
  const Mesh mesh = two_squares();
  std::vector<Hit> hits = Truth(mesh, kF32).trace(rays);
  for (std::size_t i = 2; i < hits.size(); i += 3) hits[i] = {};
  const auto judged = [](const TruthReport& r) {
    return r.agree + r.edge + r.grazing + r.embree_wrong + r.tie + r.unexplained;
  };
  const TruthReport all = Truth(mesh, kF32).compare(rays, hits);
  CHECK(all.unjudged == 0);
  CHECK(judged(all) == 600);
  const TruthReport quick = Truth(mesh, kF32, "", 0).compare(rays, hits);
  CHECK(quick.unjudged > 100);
  CHECK(judged(quick) == 600 - quick.unjudged);
  for (const std::size_t threads : {1U, 4U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const TruthReport some = Truth(mesh, kF32, "", 4 * 50 + 3).compare(rays, hits);
    CHECK(some.unjudged == quick.unjudged - 50);
    CHECK(judged(some) == 600 - some.unjudged);
  }
}

TEST_CASE("too many rays that Embree does not take are refused in place of a long wait") {
  const std::vector<Ray> rays(3, Ray{.o = {0, 0, -1e19F}, .d = {0, 0, 1}});
  CHECK(Truth(two_squares(), kF32, "", 4 * 3).trace(rays).size() == 3);
  test::check_error([&] { (void)Truth(two_squares(), kF32, "", 4 * 2).trace(rays); },
                    {"3 rays", "2 of them", "1.844e18"});
  const std::vector<Hit> hits(3);
  CHECK(Truth(two_squares(), kF32, "", 4 * 2).compare(rays, hits).unjudged == 1);
}

}  // namespace
