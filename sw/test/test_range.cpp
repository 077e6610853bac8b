// SPDX-License-Identifier: Apache-2.0
// Whatever the range or the fraction of a format takes from a mesh is counted by its kind and told
// in one sentence.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "test/tree_walk.hpp"

namespace ti {
namespace {

constexpr Format kHalf{5, 10};
const std::vector<glm::vec3> kGood{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

/// What is counted where `more` corners stand behind a triangle that is always good.
BuildStats stats_of(const std::vector<glm::vec3>& more, TestKind test = TestKind::Woop,
                    const Format& format = kHalf, int scale = 0) {
  std::vector<glm::vec3> corners = kGood;
  corners.insert(corners.end(), more.begin(), more.end());
  BuildOptions options;
  options.format = format;
  options.test = test;
  options.scale = scale;
  BuildStats stats;
  (void)build_image(mesh_of(corners), options, stats);
  return stats;
}

TEST_CASE("range: nothing is counted and nothing said where all is well") {
  for (const TestKind test : {TestKind::Local, TestKind::Np, TestKind::Woop}) {
    const BuildStats stats = stats_of({{0.1F, 0.2F, 0.3F}, {4, 5, 6}, {7, 9, 8}}, test);
    CHECK(stats.range.coordinates.none());
    CHECK(stats.range.constants.none());
    CHECK(stats.range.merged == 0);
    CHECK(range_warning(stats.range, kHalf).empty());
    CHECK(dropped_warning(stats).empty());
  }
}

TEST_CASE("range: coordinates that overflow, vanish or keep few bits") {
  const BuildStats far = stats_of({{7e4F, 0, 0}, {0, 7e4F, 0}, {0, 0, 1}});
  CHECK(far.range.coordinates.overflowed == 2);
  CHECK(far.range.dropped_overflow == 1);
  CHECK(far.dropped_nonfinite == 1);
  CHECK(dropped_warning(far) ==
        "dropped 1 with a vertex or constant beyond the format out of 2 triangles");
  CHECK(range_warning(far.range, kHalf) == "in (5,10) 2 coordinates overflow: take more exp_bits");

  const BuildStats near = stats_of({{0x1p-26F, 2, 0}, {1, 0x1.01p-20F, 2}, {0, 1, 0x1p-20F}});
  CHECK(near.range.coordinates.vanished == 1);
  CHECK(near.range.coordinates.shortened == 1);  // 2^-20 is exact
  CHECK(near.range.moved == 0x1p-26);
  CHECK(range_warning(near.range, kHalf) ==
        "in (5,10) 1 coordinate vanishes (by up to 1.5e-08 units), 1 coordinate keeps few bits (by "
        "up to 1.5e-08 units): take more exp_bits");

  Format flush = kHalf;
  flush.modes.flush = true;
  CHECK(stats_of({{0x1p-15F, 0, 1}, {1, 1, 0}, {0, 1, 1}}, TestKind::Woop, flush)
            .range.coordinates.vanished == 1);
}

TEST_CASE("range: what is lost is that of the scaled scene, how far it is off in scene units") {
  const std::vector<glm::vec3> corners{{7e4F, 0, 0}, {0, 7e4F, 0x1p-20F}, {0, 0, 1}};
  const BuildStats stats = stats_of(corners, TestKind::Woop, kHalf, -14);
  CHECK(stats.range.coordinates.overflowed == 0);
  CHECK(stats.range.coordinates.vanished == 1);
  CHECK(stats.range.moved == 0x1p-20);
  CHECK(stats.dropped_nonfinite == 0);
}

TEST_CASE("range: constants that overflow, vanish or keep few bits") {
  // 1 / height beyond 65504, with corners that the format has.
  const BuildStats thin =
      stats_of({{0, 0, 0}, {0x1p-17F, 0, 0}, {0, 0x1p-17F, 0}}, TestKind::Local);
  CHECK(thin.range.constants.overflowed > 0);
  CHECK(thin.range.dropped_overflow == 1);
  CHECK(range_warning(thin.range, kHalf).find("constants overflow") != std::string::npos);
  // The slopes of a large triangle that is nearly level.
  const BuildStats level =
      stats_of({{0, 0, 0}, {6e4F, 0, 0x1p-10F}, {0, 6e4F, 0x1p-12F}}, TestKind::Local);
  CHECK(level.range.constants.vanished > 0);
  const BuildStats large = stats_of({{0, 0, 0}, {5.5e4F, 0, 0}, {0, 6e4F, 0}}, TestKind::Local);
  CHECK(large.range.constants.shortened > 0);
  CHECK(stats_of({{0, 0, 0}, {6e4F, 0, 0}, {0, 6e4F, 0}}).range.constants.none());
}

TEST_CASE("range: vertices that fall together, and triangles that have no area by it") {
  const BuildStats stats =
      stats_of({{1, 1, 0}, {1.0001F, 1, 0}, {1, 2, 0}, {2, 2, 2}, {2, 2, 2}, {3, 3, 3}});
  CHECK(stats.range.merged == 1);
  CHECK(stats.dropped_zero_area == 2);
  CHECK(stats.range.dropped_rounded == 1);
  CHECK(dropped_warning(stats) ==
        "dropped 1 of zero area and 1 of zero area in the format out of 3 triangles");
  CHECK(range_warning(stats.range, kHalf) ==
        "in (5,10) 1 vertex falls on another, 1 triangle loses its area: take more frac_bits");

  // Of two triangles without a corner in common; nothing is dropped.
  const BuildStats apart =
      stats_of({{5, 5, 5}, {6, 5, 5}, {5, 6, 5}, {5.0001F, 5, 5}, {6.0001F, 7, 5}, {5, 7, 5}});
  CHECK(apart.range.merged == 1);
  CHECK(apart.range.dropped_rounded == 0);
  CHECK(dropped_warning(apart).empty());
}

TEST_CASE(
    "range: what no triangle names, and what is not finite as given, is nothing of the format") {
  Mesh mesh = mesh_of(kGood);
  mesh.vertices.push_back({7e4F, 1e-9F, 1.00001F});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  mesh.vertices.insert(mesh.vertices.end(), {{nan, 0, 0}, {1, INFINITY, 0}, {0, 1, 0}});
  mesh.triangles.push_back({4, 5, 6});
  BuildOptions options;
  options.format = kHalf;
  BuildStats stats;
  (void)build_image(mesh, options, stats);
  CHECK(stats.dropped_nonfinite == 1);
  CHECK(stats.range.dropped_overflow == 0);
  CHECK(stats.range.coordinates.none());
  CHECK(stats.range.merged == 0);
}

}  // namespace
}  // namespace ti
