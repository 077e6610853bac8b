// SPDX-License-Identifier: Apache-2.0
// A scene of any size is scaled to where the triangle test has room (`test_scale_window.cpp`): hits
// are those of the scene at another size, and all that leaves the engine is in units of the scene.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "accel/scene_scale.hpp"
#include "cli/hardcases.hpp"
#include "engine/session.hpp"
#include "engine/stored_image.hpp"
#include "io/file.hpp"
#include "scene/geometry.hpp"
#include "scene/rays.hpp"
#include "scene/scaling.hpp"
#include "test/support.hpp"
#include "test/tree_walk.hpp"

namespace ti {
namespace {

constexpr std::array<TestKind, 3> kTests{TestKind::Local, TestKind::Np, TestKind::Woop};

std::vector<Format> ladder() {
  return {{5, 10}, {6, 12, {.toward_zero = true, .flush = true}}, {7, 16}, {8, 13}, {8, 23}};
}

RunOptions options_of(const Format& format, TestKind test, bool truth = false) {
  RunOptions options;
  options.config.format = format;
  options.config.triangle_test = static_cast<TriangleTest>(static_cast<int>(test) - 1);
  options.config.traversal = Traversal::kPadded;
  options.config.json = "{}";
  options.engine = EngineKind::Model;
  options.truth = truth;
  return options;
}

Mesh times(Mesh mesh, int power) {
  for (glm::vec3& p : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) p[axis] = std::ldexp(p[axis], power);
  }
  return mesh;
}

std::vector<Ray> times(std::vector<Ray> rays, int power) {
  for (Ray& ray : rays) ray = scaled(ray, power);
  return rays;
}

Scene scene_of(Mesh mesh) {
  Scene scene;
  scene.materials.resize(1);
  scene.mesh = std::move(mesh);
  return scene;
}

TEST_CASE("scale: scene and rays times 2^k have the same hits, bit for bit, with t times 2^k") {
  constexpr int kSize = 1;  // of the soup
  const Mesh mesh = soup(400, 0.3F, 11);
  for (const Format& format : ladder()) {
    const Mesh given = scaled(times(mesh, 3), {format, -3});  // numbers of the format
    std::vector<Ray> rays = random_rays(mesh, 3000, 4);
    for (Ray& ray : rays) {
      for (int axis = 0; axis < 3; ++axis)
        ray.o[axis] = static_cast<float>(round_to(format, ray.o[axis]));
    }
    for (const TestKind test : kTests) {
      CAPTURE(name_of(format));
      CAPTURE(test_name(test));
      const ScaleWindow window = scale_window(format, test);
      const int middle = window.middle() - kSize;
      Session first(options_of(format, test), scene_of(times(given, middle)));
      REQUIRE(first.format().scale == 0);
      const std::vector<Hit> once = first.trace(times(rays, middle)).hits;
      CHECK(std::count_if(once.begin(), once.end(), [](const Hit& hit) { return hit.is_hit(); }) >
            300);
      int tried = 0;
      for (const int k : {-104, -60, -7, 5, 50, 110}) {
        const bool inside = window.low <= kSize + k && kSize + k <= window.high;
        if (inside && format.exp_bits < 7) continue;  // subnormal numbers on the way
        ++tried;
        CAPTURE(k);
        Session other(options_of(format, test), scene_of(times(given, k)));
        CHECK((other.format().scale == 0) == inside);
        const std::vector<Hit> again = other.trace(times(rays, k)).hits;
        std::size_t differ = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
          const Hit& a = once[i];
          const Hit& b = again[i];
          const float t = std::ldexp(a.t, k - middle);
          if (b.prim != a.prim || b.t != t || b.u != a.u || b.v != a.v) ++differ;
        }
        CHECK(differ == 0);
      }
      CHECK(tried > 3);
    }
  }
}

TEST_CASE("scale: the Cornell box in hundreds of units keeps its hits at (5,10) by being scaled") {
  Scene scene = load_scene(test::root() / "scenes/cornell.gltf");
  for (glm::vec3& p : scene.mesh.vertices) p *= 1000.0F;
  const std::vector<Ray> rays = inside_rays(scene.mesh, 4000, 3);
  const Format format{5, 10};
  const auto count = [](const std::vector<Hit>& hits) {
    return std::count_if(hits.begin(), hits.end(), [](const Hit& hit) { return hit.is_hit(); });
  };
  Session session(options_of(format, TestKind::Woop, true), scene);
  CHECK(session.format().scale == -6);
  const Wave wave = session.trace(rays);
  REQUIRE(wave.truth);
  CHECK(wave.truth->unexplained == 0);
  CHECK(wave.good());

  Session fine(options_of({8, 23}, TestKind::Woop), scene);
  const Wave exact = fine.trace(rays);
  CHECK(fine.format().scale == 0);
  CHECK(count(wave.hits) > count(exact.hits) - 40);
  double worst = 0.0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (wave.hits[i].prim == exact.hits[i].prim && exact.hits[i].is_hit() && exact.hits[i].t > 10)
      worst = std::max(worst, std::abs(double{wave.hits[i].t} - double{exact.hits[i].t}));
  }
  CHECK(worst < 20.0);

  BuildOptions options;
  options.format = format;
  options.test = TestKind::Woop;
  BuildStats stats;
  const Image image = build_image(scene.mesh, options, stats);
  Work work;
  const auto model = Tracer::create(image, {.traversal = Traversal::kPadded});
  std::vector<Hit> unscaled;
  for (const HitBits& bits : model->trace(std::span(rays), work))
    unscaled.push_back(hit_of(format, bits));
  CHECK(count(unscaled) < count(exact.hits) / 2);
}

TEST_CASE("scale: all hard cases pass with Woop's test, those of 1e20, 1e-20 and 1e-30 too") {
  const auto cases = load_hardcases(test::root() / "scenes/hardcases.jsonl");
  int scaled_cases = 0;
  for (const HardCase& c : cases) {
    CAPTURE(c.n);
    CAPTURE(c.name);
    Session session(options_of({}, TestKind::Woop), scene_of(c.mesh));
    if (session.format().scale != 0) ++scaled_cases;
    const Wave wave = session.trace(std::span(&c.ray, 1));
    const CaseResult result = judge_case(c, wave.hits.front(), {}, TestKind::Woop);
    CAPTURE(result.text);
    CHECK(result.pass());
    if (c.n < 20 || c.n > 22) continue;
    CHECK(session.format().scale != 0);
    CHECK(wave.hits.front().is_hit());
    CHECK_FALSE(judge_case(c, {}, {}, TestKind::Woop).pass());
    Hit moved = wave.hits.front();
    moved.t *= 1.001F;
    CHECK_FALSE(judge_case(c, moved, {}, TestKind::Woop).pass());
  }
  CHECK(cases.size() == 63);
  CHECK(scaled_cases >= 3);
}

TEST_CASE(
    "scale: rays leave a hit of a scaled scene as they leave that of its size in the window") {
  const Mesh mesh = soup(200, 0.4F, 3);
  const std::vector<Ray> rays = random_rays(mesh, 2000, 8);
  for (const Format& format : ladder()) {
    CAPTURE(name_of(format));
    for (const int k : {-60, -7, 9, 70}) {
      CAPTURE(k);
      const Mesh large = times(mesh, k);
      Session session(options_of(format, TestKind::Woop), scene_of(large));
      const std::vector<Ray> given = times(rays, k);
      const Wave wave = session.trace(given);
      const int scale = session.format().scale;
      std::vector<Ray> next;
      std::vector<std::int32_t> left;
      for (std::size_t i = 0; i < given.size(); ++i) {
        if (!wave.hits[i].is_hit()) continue;
        const Departure out = departure(large, given[i], wave.hits[i], session.format());
        const Departure in = departure(times(large, scale), scaled(given[i], scale),
                                       scaled(wave.hits[i], scale), {format, 0, true});
        for (int axis = 0; axis < 3; ++axis) {
          const float back = std::ldexp(out.origin[axis], scale);
          const bool exact = back == in.origin[axis];
          const bool tiny = std::abs(out.origin[axis]) < std::numeric_limits<float>::min();
          REQUIRE((exact || tiny));
          REQUIRE((double{back} - double{in.origin[axis]}) * out.normal[axis] >= 0.0);
        }
        next.push_back({.o = out.origin, .d = glm::vec3(out.normal)});
        left.push_back(wave.hits[i].prim);
      }
      REQUIRE(next.size() > 150);
      const Wave second = session.trace(next);
      std::size_t own = 0;
      for (std::size_t i = 0; i < next.size(); ++i) own += second.hits[i].prim == left[i] ? 1 : 0;
      CHECK(own == 0);
    }
  }
}

TEST_CASE("scale: what leaves the range on its way back is a miss, on its way there no ray") {
  const Mesh large = times(mesh_of({{-1, -1, 1}, {1, -1, 1}, {0, 1, 1}}), 100);
  Session session(options_of({}, TestKind::Woop), scene_of(large));
  const int scale = session.format().scale;
  REQUIRE(scale < 0);
  const std::vector<Ray> rays{{.d = {0, 0, 1}},
                              {.d = {0, 0, 0x1p-40F}},             // t = 2^140
                              {.d = {0, 0, 1}, .tmax = 0x1p99F},   // ends before
                              {.tmin = 0x1p101F, .d = {0, 0, 1}},  // begins behind
                              {.d = {0, 0, 1}, .tmax = 0x1p101F, .any = true}};
  const std::vector<Hit> hits = session.trace(rays).hits;
  CHECK(hits[0].t == 0x1p100F);
  for (const std::size_t i : {1, 2, 3}) {
    CAPTURE(i);
    CHECK_FALSE(hits[i].is_hit());
    CHECK(hits[i].status == Status::Ok);
    CHECK(std::isinf(hits[i].t));
  }
  CHECK(hits[4].is_hit());
  CHECK(hits[4].t == 0.0F);

  Session small(options_of({}, TestKind::Woop), scene_of(times(large, -220)));
  REQUIRE(small.format().scale > 0);
  const std::vector<Ray> far{{.o = {0, 0, -0x1p110F}, .d = {0, 0, 1}}};
  CHECK(small.trace(far).hits[0].status == Status::InvalidRay);
}

TEST_CASE("scale: rays and hits of numbers beyond the format are invalid rays in every test") {
  for (const TestKind test : kTests) {
    Session session(options_of({5, 10}, test), scene_of(soup(20, 0.3F, 2)));
    const std::vector<Ray> rays{
        {.o = {7e4F, 0, 0}, .d = {-1, 0, 0}}, {.d = {0, 7e4F, 0}}, {.d = {1e-9F, 0, 0}}};
    for (const Hit& hit : session.trace(rays).hits) CHECK(hit.status == Status::InvalidRay);
  }
}

TEST_CASE("scale: an image has it in its file, and stands in for the tree of its scene alone") {
  const test::TempDir folder;
  const Scene scene = scene_of(times(soup(50, 0.4F, 9), 10));
  RunOptions options = options_of({5, 10}, TestKind::Woop);
  const std::vector<Ray> rays = random_rays(scene.mesh, 500, 1);
  Session built(options, scene);
  REQUIRE(built.format().scale == -7);
  const auto bytes = built.image().bytes();
  options.image = folder / "a.tiim";
  write_file(options.image, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  Session stored(options, scene);
  CHECK(stored.format().scale == -7);
  const Wave a = built.trace(rays);
  const Wave b = stored.trace(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    CHECK(a.hits[i].prim == b.hits[i].prim);
    CHECK(a.hits[i].t == b.hits[i].t);
  }
  const Scene other = scene_of(times(scene.mesh, 1));
  test::check_error([&] { Session refused(options, other); }, {"another scene"});
}

TEST_CASE("scale: the frames of an animation have one, of all that it reaches") {
  const Mesh mesh = soup(100, 0.3F, 6);
  const Box reach{{-900, -1, -1}, {2, 2, 2}};
  Config config;
  config.format = {5, 10};
  config.triangle_test = TriangleTest::kWoop;
  const BuildOptions options = build_options_of(config, largest_coordinate(reach));
  CHECK(options.scale == -6);
  MovingTree tree(options, reach);
  Mesh other = mesh;
  for (glm::vec3& p : other.vertices) p.x -= 800.0F;
  for (const Mesh* frame : {&mesh, static_cast<const Mesh*>(&other), &mesh}) {
    BuildStats stats;
    const Image image = tree.next(*frame, false, stats);
    CHECK(image.header().scale == -6);
    CHECK(value_of_bits(config.format, image.header().box_lo[0]) < -14.0);
    CHECK(value_of_bits(config.format, image.header().box_lo[0]) > -16.0);
  }
}

}  // namespace
}  // namespace ti
