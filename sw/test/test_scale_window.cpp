// SPDX-License-Identifier: Apache-2.0
// The window of sizes that a triangle test has room for is as wide as it is said to be.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "accel/scene_scale.hpp"
#include "model/tracer.hpp"
#include "scene/scaling.hpp"
#include "test/support.hpp"
#include "test/tree_walk.hpp"

namespace ti {
namespace {

constexpr std::array<TestKind, 3> kTests{TestKind::Local, TestKind::Np, TestKind::Woop};

std::vector<Format> all_formats() {
  std::vector<Format> formats;
  for (int exp_bits = 3; exp_bits <= 8; ++exp_bits) {
    for (int frac_bits = 2; frac_bits <= 23; ++frac_bits) {
      for (const bool toward_zero : {false, true}) {
        for (const bool flush : {false, true})
          formats.push_back({exp_bits, frac_bits, {.toward_zero = toward_zero, .flush = flush}});
      }
    }
  }
  return formats;
}

std::vector<Format> ladder() {
  return {{5, 10}, {6, 12, {.toward_zero = true, .flush = true}}, {7, 16}, {8, 13}, {8, 23}};
}

TEST_CASE(
    "scale: of every format a scene of any size comes into the window, from outside to its "
    "middle") {
  for (const Format& format : all_formats()) {
    for (const TestKind test : kTests) {
      const ScaleWindow window = scale_window(format, test);
      REQUIRE(window.low <= window.high);
      REQUIRE(window.high < format.bias());
      for (int size = -148; size <= 128; ++size) {
        const double largest = std::ldexp(0.75, size);
        const int scale = scene_scale(largest, format, test);
        REQUIRE(std::abs(scale) <= kMostScale);
        const bool inside = window.low <= size && size <= window.high;
        REQUIRE(size + scale == (inside ? size : window.middle()));
        REQUIRE(scene_scale(std::ldexp(largest, scale), format, test) == 0);
        REQUIRE(scene_scale(std::ldexp(0.5, size), format, test) == scale);
      }
    }
  }
  for (const double nothing :
       {0.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    CHECK(scene_scale(nothing, {5, 10}, TestKind::Woop) == 0);
}

TEST_CASE("scale: scenes of usual sizes stay as they are in formats with room") {
  for (const Format& format : {Format{8, 23}, Format{7, 16}, Format{8, 13}}) {
    for (const TestKind test : kTests) {
      const ScaleWindow window = scale_window(format, test);
      CHECK(window.low <= -9);
      CHECK(window.high >= 16);
    }
  }
  CHECK(scale_window({5, 10}, TestKind::Woop).low == 4);
  CHECK(scale_window({5, 10}, TestKind::Woop).high == 4);
}

/// The triangle in the cube of half side `m` whose edge functions are largest, and a ray to its
/// middle along its normal, from a place `far` times the cube's size away.
struct Widest {
  Mesh mesh;
  Ray ray;
};
Widest widest(int size, double far) {
  const float m = std::ldexp(0.984375F, size);
  Widest out{mesh_of({{-m, -m, -m}, {m, m, -m}, {-m, m, m}}), {}};
  const glm::vec3 n(1.0F, -1.0F, 1.0F);
  const glm::vec3 middle(-m / 3.0F, m / 3.0F, -m / 3.0F);
  out.ray.o = middle + n * static_cast<float>(far * m);
  out.ray.d = -n;
  return out;
}

bool hits_unscaled(const Format& format, const Mesh& mesh, const Ray& ray, double& t) {
  BuildOptions options;
  options.format = format;
  options.test = TestKind::Woop;
  BuildStats stats;
  const Image image = build_image(mesh, options, stats);
  Work work;
  const Hit hit =
      hit_of(format, Tracer::create(image, {.traversal = Traversal::kPadded})->trace(ray, work));
  t = hit.t;
  return hit.is_hit();
}

/// Whether Woop's test, unscaled, hits it at the right distance.
bool hits_widest(const Format& format, int size, double far) {
  const Widest scene = widest(size, far);
  double t = 0.0;
  const bool hit = hits_unscaled(format, scene.mesh, scene.ray, t);
  return hit && std::abs(t / (far * std::ldexp(0.984375, size)) - 1.0) < 0.02;
}

TEST_CASE("scale: the largest triangle is hit at the upper end of Woop's window, not far above") {
  for (const Format& format : ladder()) {
    CAPTURE(name_of(format));
    const int high = scale_window(format, TestKind::Woop).high;
    const double far = high > 4 ? 0x1p10 : 0x1p7;  // (5,10) has no room for more
    CHECK(hits_widest(format, high, far));
    if (!format.modes.toward_zero) CHECK_FALSE(hits_widest(format, high + 4, 2.0 * far));
  }
}

TEST_CASE("scale: a triangle of a unit in the last place is hit at the lower end, within it") {
  for (const Format& format : {Format{7, 16}, Format{8, 13}, Format{8, 23}}) {
    CAPTURE(name_of(format));
    const int low = scale_window(format, TestKind::Woop).low;
    const auto tried = [&](int size, double& off) {
      const auto m = static_cast<float>(round_to(format, std::ldexp(0.7, size)));
      const float e = std::ldexp(1.0F, size - 1 - format.frac_bits);
      const Mesh mesh = mesh_of({{m, m, m}, {m + e, m, m}, {m, m + e, m}});
      const Ray ray{.o = {m, m, 0.0F}, .d = {0.0F, 0.0F, 1.0F}};
      double t = 0.0;
      const bool hit = hits_unscaled(format, mesh, ray, t);
      off = std::abs(t - double{m}) / double{e};
      return hit;
    };
    double off = 0.0;
    CHECK(tried(low, off));
    CHECK(off <= 4.0);
    // Far below it all weights vanish.
    CHECK_FALSE(tried(low - (format.frac_bits + 4) / 2, off));
  }
}

}  // namespace
}  // namespace ti
