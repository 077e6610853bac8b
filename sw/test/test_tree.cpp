// SPDX-License-Identifier: Apache-2.0
// The tree holds every triangle in every cell that it meets, whatever the mesh, and the same mesh
// gives the same bytes.

#include <doctest/doctest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "accel/prepare.hpp"
#include "base/error.hpp"
#include "base/format_grid.hpp"
#include "test/tree_walk.hpp"

namespace ti {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

Image build(const Mesh& mesh, BuildStats& stats, Format format = {},
            Layout layout = Layout::kOdfl) {
  BuildOptions options;
  options.format = format;
  options.layout = layout;
  return build_image(mesh, options, stats);
}

/// Root cell and every leaf cell have positive thickness.
void check_no_flat_cell(const Image& image) {
  for (const Leaf& leaf : leaves(image)) {
    for (std::size_t axis = 0; axis < 3; ++axis) CHECK(leaf.cell.lo[axis] < leaf.cell.hi[axis]);
  }
}

}  // namespace

TEST_CASE("tree: a mesh without triangles gives one empty leaf") {
  BuildStats stats;
  const Image image = build(Mesh{}, stats);
  REQUIRE(image.nodes().size() == 1);
  CHECK(image.nodes()[0].is_leaf());
  CHECK(image.nodes()[0].count() == 0);
  CHECK(image.planes().empty());
  CHECK(stats.empty_leaves == 1);
  CHECK(stats.references == 0);
  CHECK(dropped_warning(stats).empty());
  check_no_flat_cell(image);
}

TEST_CASE("tree: one triangle flat on an axis stands inside a box of some thickness") {
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<glm::vec3> corners{{1, 2, 3}, {4, 7, 9}, {2, 8, 4}};
    for (glm::vec3& corner : corners) corner[axis] = 5.0F;
    const Mesh mesh = mesh_of(corners);
    BuildStats stats;
    const Image image = build(mesh, stats);
    const Box box = scene_box(image);
    for (std::size_t i = 0; i < 3; ++i) {
      for (const glm::vec3& corner : mesh.corners(0)) {
        CHECK(box.lo[i] < corner[i]);
        CHECK(corner[i] < box.hi[i]);
      }
    }
    REQUIRE(image.planes().size() == 1);
    CHECK(image.planes()[0].axis == static_cast<std::uint32_t>(axis));
    CHECK(number(image, image.planes()[0].nu) == 0.0);
    CHECK(number(image, image.planes()[0].nv) == 0.0);
    check_no_flat_cell(image);
    check_membership(mesh, image);
  }
}

TEST_CASE("tree: the records are those of the test, rotated to the largest normal component") {
  BuildStats stats;
  // n = (0,0,2) x: normal of (0,0,0) (0,2,0) (0,0,4) is (8,0,0); then a tie of all three
  // components.
  const Image flat = build(mesh_of({{3, 1, 2}, {3, 3, 2}, {3, 1, 6}}), stats);
  const ImagePlane& plane = flat.planes()[0];
  const ImageBary& bary = flat.barys()[0];
  CHECK(plane.axis == 0);
  CHECK(number(flat, plane.pu) == 1.0);
  CHECK(number(flat, plane.pv) == 2.0);
  CHECK(number(flat, plane.pw) == 3.0);
  CHECK(number(flat, bary.e0u) == 0.25);
  CHECK(number(flat, bary.e0v) == 0.0);
  CHECK(number(flat, bary.e1u) == 0.0);
  CHECK(number(flat, bary.e1v) == 0.5);
  const Image tie = build(mesh_of({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), stats);
  CHECK(tie.planes()[0].axis == 0);
  CHECK(number(tie, tie.planes()[0].nu) == 1.0);
  CHECK(number(tie, tie.planes()[0].nv) == 1.0);
}

TEST_CASE("tree: walls in one plane, repeated and side by side, end the build") {
  for (const std::size_t copies : {2U, 7U, 500U}) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<glm::vec3> corners;
      for (std::size_t i = 0; i < copies; ++i) {
        const auto step = static_cast<float>(i % 5);
        for (glm::vec3 corner : {glm::vec3{0, 0, 0}, {4, 4, 0}, {0, 4, 4}}) {
          corner[(axis + 1) % 3] += step;
          corner[axis] = 1.0F;
          corners.push_back(corner);
        }
      }
      const Mesh mesh = mesh_of(corners);
      BuildStats stats;
      const Image image = build(mesh, stats);
      CHECK(image.planes().size() == stats.triangles - stats.dropped_zero_area);
      check_no_flat_cell(image);
      if (stats.dropped_zero_area == 0) check_membership(mesh, image);
    }
  }
}

TEST_CASE("tree: more equal triangles than a leaf can hold are an error") {
  Mesh mesh = mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 1}});
  mesh.triangles.resize(kMaxLeafCount, mesh.triangles[0]);
  BuildStats stats;
  CHECK(build(mesh, stats).planes().size() == kMaxLeafCount);
  CHECK(stats.largest_leaf == kMaxLeafCount);
  mesh.triangles.push_back(mesh.triangles[0]);
  CHECK_THROWS_AS((void)build(mesh, stats), Error);
}

TEST_CASE("tree: triangles that cannot be hit are dropped and counted, their neighbours stay") {
  const std::vector<glm::vec3> good{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  std::vector<glm::vec3> corners = good;
  corners.insert(corners.end(), {{kNan, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  corners.insert(corners.end(), {{0, 0, 0}, {1, kInf, 0}, {0, 1, 0}});
  corners.insert(corners.end(), {{2, 2, 2}, {2, 2, 2}, {2, 2, 2}});
  corners.insert(corners.end(), {{0, 0, 0}, {1, 1, 1}, {3, 3, 3}});
  corners.insert(corners.end(), {{0, 0, 0}, {1, 2, 3}, {0, 0, 0}});
  corners.insert(corners.end(), good.begin(), good.end());
  BuildStats stats;
  const Image image = build(mesh_of(corners), stats);
  CHECK(stats.triangles == 7);
  CHECK(stats.dropped_nonfinite == 2);
  CHECK(stats.dropped_zero_area == 3);
  REQUIRE(image.planes().size() == 2);
  CHECK(image.planes()[0].prim == 0);
  CHECK(image.planes()[1].prim == 6);
  CHECK(dropped_warning(stats) ==
        "dropped 2 with a vertex that is not finite and 3 of zero area out of 7 triangles");
}

TEST_CASE("tree: zero area is decided exactly") {
  const auto zero = [](double a, double b, double c, double d, double e, double f) {
    return has_zero_area({glm::vec3{a, b, 0.25F}, {c, d, 0.25F}, {e, f, 0.25F}});
  };
  const double tenth = 0.1F;
  const double ulp = 0x1p-23;
  CHECK(zero(0, 0, tenth, tenth, 3 * tenth, 3 * tenth));
  CHECK(zero(0, 0, 1, 1 + ulp, 2, 2 + 2 * ulp));
  CHECK_FALSE(zero(0, 0, 1, 1 + ulp, 1 + ulp, 1 + 2 * ulp));  // ulp^2
  CHECK_FALSE(zero(0, 0, 1e20F, 0, 1e20F, 1e-20F));
  CHECK_FALSE(zero(1e20F, 1e20F, -1e20F, -1e20F, 1e-20F, 0));
  CHECK(zero(1e20F, 1e20F, -1e20F, -1e20F, 1e-20F, 1e-20F));
  CHECK(zero(0x1p-149, 0x1p-149, 0x1p127, 0x1p127, 1, 1));
  CHECK_FALSE(zero(0x1p-149, 0x1p-148, 0x1p127, 0x1p127, 1, 1));
  CHECK_FALSE(zero(0, 0, 0x1p-149, 0, 0, 0x1p-149));
}

TEST_CASE("tree: huge and tiny coordinates build") {
  for (const float scale : {1e20F, 1e-20F, 1e-30F, 1.0F}) {
    Mesh mesh = soup(300, 0.2F, 5);
    for (glm::vec3& vertex : mesh.vertices) vertex *= scale;
    BuildStats stats;
    const Image image = build(mesh, stats);
    CAPTURE(scale);
    CHECK(stats.dropped_nonfinite == 0);
    CHECK(stats.dropped_zero_area == 0);
    CHECK(stats.leaves > 50);
    for (Leaf leaf :
         leaves(image)) {  // powers of two apart, so that the squares of `overlap` stay in range
      const double back = std::exp2(-std::ilogb(scale));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        leaf.cell.lo[axis] *= back;
        leaf.cell.hi[axis] *= back;
      }
      for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        Corners corners = mesh.corners(i);
        for (glm::vec3& corner : corners) {
          corner *= static_cast<float>(back);
        }
        if (overlap(corners, leaf.cell)) {
          CHECK(std::binary_search(leaf.prims.begin(), leaf.prims.end(), i));
        }
      }
    }
  }
}

TEST_CASE("tree: a scene at the end of the range is an error, not an infinite box") {
  const float end = std::numeric_limits<float>::max();
  BuildStats stats;
  CHECK_THROWS_AS((void)build(mesh_of({{end, 0, 0}, {0, end, 0}, {0, 0, -end}}), stats), Error);
}

TEST_CASE("tree: far from the origin cells stay thicker than the spacing of the numbers") {
  Mesh mesh = soup(200, 0.3F, 6);
  for (glm::vec3& vertex : mesh.vertices) vertex += glm::vec3{1e6F, -1e6F, 1e6F};
  BuildStats stats;
  const Image image = build(mesh, stats);
  check_no_flat_cell(image);
  for (const Leaf& leaf : leaves(image)) {
    CHECK(leaf.cell.hi[0] - leaf.cell.lo[0] >= 4 * 0.0625);
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      if (!has_zero_area(mesh.corners(i)) && overlap(mesh.corners(i), leaf.cell)) {
        CHECK(std::binary_search(leaf.prims.begin(), leaf.prims.end(), i));
      }
    }
  }
}

TEST_CASE("tree: every leaf of a soup holds what meets its cell") {
  for (const auto& [count, size] : {std::pair{40, 1.0F}, {400, 0.2F}, {1500, 0.05F}}) {
    const Mesh mesh = soup(static_cast<std::size_t>(count), size, 1);
    BuildStats stats;
    const Image image = build(mesh, stats);
    CHECK(stats.leaves > 20);
    check_no_flat_cell(image);
    check_membership(mesh, image);
  }
}

TEST_CASE(
    "tree: smaller formats hold rounded vertices, splits of the format, and drop what overflows") {
  Mesh mesh = soup(300, 0.2F, 2);
  mesh.vertices.insert(mesh.vertices.end(),
                       {{0, 0, 0}, {1e-6F, 0, 0}, {0, 1e-6F, 0}, {7e4F, 0, 0}});
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.triangles.push_back({last - 4, last - 3, last - 2});  // 1/h = 1e6 is beyond e = 5
  mesh.triangles.push_back({last - 4, last - 3, last - 1});  // so is this vertex
  for (const Format format : {Format{8, 16}, Format{7, 16}, Format{5, 10}, Format{8, 4}}) {
    CAPTURE(format.frac_bits);
    BuildStats stats;
    const Image image = build(mesh, stats, format);
    if (format.exp_bits == 5) CHECK(stats.dropped_nonfinite >= 2);
    check_no_flat_cell(image);
    Mesh rounded = mesh;
    for (glm::vec3& vertex : rounded.vertices) {
      for (int axis = 0; axis < 3; ++axis) {
        vertex[axis] = static_cast<float>(round_to(format, vertex[axis]));
      }
    }
    std::vector<bool> kept(mesh.triangles.size());
    for (const ImagePlane& plane : image.planes()) kept[plane.prim] = true;
    for (const Leaf& leaf : leaves(image)) {
      for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        if (kept[i] && overlap(rounded.corners(i), leaf.cell)) {
          CHECK(std::binary_search(leaf.prims.begin(), leaf.prims.end(), i));
        }
      }
    }
  }
}

TEST_CASE("tree: DFL and ODFL have the same leaves, and ODFL puts the larger child next") {
  const Mesh mesh = soup(800, 0.1F, 3);
  BuildStats stats;
  const Image ordered = build(mesh, stats);
  const Image plain = build(mesh, stats, {}, Layout::kDfl);
  const auto a = leaves(ordered);
  const auto b = leaves(plain);
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].cell.lo == b[i].cell.lo);
    CHECK(a[i].cell.hi == b[i].cell.hi);
    CHECK(a[i].prims == b[i].prims);
  }
  std::size_t reordered = 0;
  for (const Visit& visit : visits(ordered)) {
    const ImageNode node = ordered.nodes()[visit.node];
    if (node.is_leaf()) continue;
    Box lower = visit.cell;
    Box upper = visit.cell;
    lower.hi[node.axis()] = upper.lo[node.axis()] = number(ordered, node.value);
    CHECK(node.reorder() == (upper.half_area() > lower.half_area()));
    if (node.reorder()) ++reordered;
  }
  CHECK(reordered > 0);
  for (const ImageNode& node : plain.nodes()) {
    if (!node.is_leaf()) CHECK_FALSE(node.reorder());
  }
}

TEST_CASE("tree: records stand in the order in which leaves name them first") {
  BuildStats stats;
  const Image image = build(soup(500, 0.1F, 4), stats);
  std::uint32_t next = 0;
  for (const ImageNode& node : image.nodes()) {
    if (!node.is_leaf()) continue;
    for (std::uint32_t i = 0; i < node.count(); ++i) {
      const std::uint32_t record = image.list()[node.value + i];
      CHECK(record <= next);
      if (record == next) ++next;
    }
  }
  CHECK(next == image.planes().size());
}

TEST_CASE("tree: the same mesh gives the same bytes, however many threads build it, and -0 is 0") {
  const Mesh mesh = soup(60000, 0.01F, 8);  // tasks at two depths
  BuildStats stats;
  std::vector<std::uint8_t> first;
  for (const std::size_t threads : {1U, 8U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Image image = build(mesh, stats);
    if (first.empty()) first.assign(image.bytes().begin(), image.bytes().end());
    CHECK(std::ranges::equal(image.bytes(), first));
  }
  Mesh small = mesh_of({{0.0F, 0, 0}, {1, 0.0F, 0}, {0, 1, 0.0F}});
  const Image plus = build(small, stats);
  small.vertices[0].x = small.vertices[1].y = small.vertices[2].z = -0.0F;
  CHECK(std::ranges::equal(plus.bytes(), build(small, stats).bytes()));
}

TEST_CASE("tree: a triangle that names a missing vertex is an error") {
  Mesh mesh = mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  mesh.triangles[0][1] = 3;
  BuildStats stats;
  CHECK_THROWS_WITH_AS((void)build(mesh, stats),
                       "mesh: triangle 0 names vertex 3 of 3: repair the mesh file", Error);
}

TEST_CASE("tree: neighbours in a format are right for every value of small formats") {
  constexpr Modes kFlush{.flush = true};
  for (const Format format : {Format{3, 2}, Format{4, 3}, Format{5, 2}, Format{4, 3, kFlush}}) {
    const FormatGrid grid(format);
    std::vector<double> values;
    for (std::uint32_t bits = 0; bits < 1U << static_cast<unsigned>(format.width()); ++bits) {
      const double value = value_of_bits(format, bits);
      if (std::isfinite(value)) values.push_back(value);
    }
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    CHECK(grid.max() == values.back());
    for (std::size_t i = 0; i + 1 < values.size(); ++i) {
      const double x = values[i];
      const double y = values[i + 1];
      CHECK(grid.above(x) == y);
      CHECK(grid.below(y) == x);
      CHECK(grid.at_most(x) == x);
      CHECK(grid.at_least(y) == y);
      for (const double share : {1e-12, 0.3, 0.5, 0.99}) {
        const double between = x + share * (y - x);
        CHECK(grid.below(between) == x);
        CHECK(grid.above(between) == y);
        CHECK(grid.at_most(between) == x);
        CHECK(grid.at_least(between) == y);
      }
    }
    CHECK(grid.below(values.front()) == -kInf);
    CHECK(grid.above(values.back()) == kInf);
    CHECK(grid.at_least(values.back() * 1.01) == kInf);
  }
}

}  // namespace ti
