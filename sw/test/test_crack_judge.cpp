// SPDX-License-Identifier: Apache-2.0
// A crack is a gap in a sheet that goes on around the ray; an outline, a border, a slit between two
// outlines and the beginning of a ray excuse a miss.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "reference_test.hpp"
#include "truth/crack_judge.hpp"
#include "truth/exact_tracer.hpp"

namespace ti {
namespace {

constexpr Format kFormat{8, 13};

/// Squares of two triangles from (x0, 0) to (x1, 1) at a height z, `cells` a side. Corners are not
/// shared: each triangle has its own.
void add_grid(Mesh& mesh, float x0, float x1, float z, int cells) {
  const auto corner = [&](int i, int k) {
    const float n = static_cast<float>(cells);
    return glm::vec3(x0 + (x1 - x0) * static_cast<float>(i) / n, static_cast<float>(k) / n, z);
  };
  const auto add = [&mesh](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
    mesh.triangles.push_back({first, first + 1, first + 2});
  };
  for (int i = 0; i < cells; ++i) {
    for (int k = 0; k < cells; ++k) {
      add(corner(i, k), corner(i + 1, k), corner(i + 1, k + 1));
      add(corner(i, k), corner(i + 1, k + 1), corner(i, k + 1));
    }
  }
}

Mesh grid(int cells) {
  Mesh mesh;
  add_grid(mesh, 0.0F, 1.0F, 0.0F, cells);
  return mesh;
}

std::vector<std::int32_t> sheet_of(const Mesh& mesh, const Ray& ray) {
  const ExactTracer::Hit hit = ExactTracer(mesh, kFormat).trace(ray);
  REQUIRE(hit.hit);
  return CrackJudge(mesh, kFormat).sheet(ray, hit).triangles;
}

Ray down(float x, float y, float z = 1.0F) { return {.o = {x, y, z}, .d = {0, 0, -1}}; }

TEST_CASE("cracks: the sheet is of the triangles that come near the ray") {
  // A is 1, so r is 11 * 2^-14, a 1490th.
  const Mesh mesh = grid(8);
  CHECK(sheet_of(mesh, down(0.40625F, 0.3828125F)) == std::vector<std::int32_t>{54});
  CHECK(sheet_of(mesh, down(0.4375F, 0.4375F)) == std::vector<std::int32_t>{54, 55});  // an edge
  CHECK(sheet_of(mesh, down(0.5F, 0.5F)).size() == 6);                                 // a corner
  CHECK(sheet_of(mesh, down(0.5F + 0x1p-12F, 0.5F)).size() == 6);
  CHECK(sheet_of(mesh, down(0.5F + 0x1p-9F, 0.5F)).size() < 6);
}

TEST_CASE("cracks: of a sheet that a ray grazes it may hit what lies behind") {
  // Near the ray are 0.375 to 0.625 of its way; from straight above no more than the plane.
  const Mesh mesh = grid(8);
  const auto end_of = [&mesh](const Ray& ray) {
    return CrackJudge(mesh, kFormat).sheet(ray, ExactTracer(mesh, kFormat).trace(ray)).end;
  };
  const Ray grazing{.o = {0.0F, 0.4375F, 0x1p-8F}, .d = {1, 0, -0x1p-7F}};
  CHECK(end_of(grazing) > 0.55);
  CHECK(end_of(grazing) < 0.75);
  CHECK(end_of(down(0.4375F, 0.4375F)) < 1.0 + 0x1p-8);
}

TEST_CASE("cracks: near the border of a mesh a ray may miss") {
  const Mesh mesh = grid(8);
  CHECK(sheet_of(mesh, down(0x1p-12F, 0.375F)).empty());
  CHECK_FALSE(sheet_of(mesh, down(0x1p-10F, 0.375F)).empty());
}

TEST_CASE("cracks: near the outline of a closed mesh a ray may miss, in its middle it may not") {
  const Mesh mesh = reference::sphere(4);
  CHECK_FALSE(sheet_of(mesh, down(0.25F, 0.125F, 2.0F)).empty());
  CHECK_FALSE(sheet_of(mesh, down(0.9375F, 0.0625F, 2.0F)).empty());
  const Ray near_outline{.o = {0.9990F, 0.0F, 2.0F}, .d = {0, 0, -1}};
  CHECK(sheet_of(mesh, near_outline).empty());
}

TEST_CASE("cracks: a slit between two outlines is none, though something lies on all sides") {
  Mesh mesh;
  add_grid(mesh, 0.0F, 0.5F, 0.0F, 4);
  add_grid(mesh, 0.5F, 1.0F, -0x1p-9F, 4);
  CHECK(sheet_of(mesh, down(0.5F - 0x1p-12F, 0.375F)).empty());
  CHECK(sheet_of(mesh, down(0.5F + 0x1p-12F, 0.375F)).empty());
  CHECK_FALSE(sheet_of(mesh, down(0.4375F, 0.375F)).empty());
}

TEST_CASE("cracks: where a hit may come to lie before the beginning of the ray it may be lost") {
  const Mesh mesh = grid(8);
  CHECK(sheet_of(mesh, down(0.4375F, 0.375F, 0.0F)).empty());
  CHECK(sheet_of(mesh, down(0.4375F, 0.375F, 0x1p-11F)).empty());
  CHECK_FALSE(sheet_of(mesh, down(0.4375F, 0.375F, 0x1p-8F)).empty());
  Ray late = down(0.4375F, 0.375F);
  late.tmin = 1.0F - 0x1p-11F;
  CHECK(sheet_of(mesh, late).empty());
}

TEST_CASE("cracks: a sheet goes on over triangles that are wound the other way") {
  Mesh mesh = grid(8);
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
    std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  CHECK(sheet_of(mesh, down(0.5F, 0.5F)).size() == 6);
}

TEST_CASE("cracks: corners that round to 0 from both sides are one") {
  Mesh mesh = grid(8);
  float tiny = 1e-44F;  // less than half the least number of the format
  for (glm::vec3& corner : mesh.vertices) corner.z = tiny = -tiny;
  CHECK(sheet_of(mesh, down(0.5F, 0.5F)).size() == 6);
}

TEST_CASE("cracks: a fold is an outline") {
  // Two halves of a roof upside down, seen from one side of it: the second turns its back.
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 1, 0}, {1, 0, -1}, {1, 1, -1}, {0.5F, 0, -4}, {0.5F, 1, -4}};
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {2, 4, 5}, {2, 5, 3}};
  CHECK(sheet_of(mesh, down(0.75F, 0.5F)).size() == 1);
  CHECK(sheet_of(mesh, down(1.0F - 0x1p-12F, 0.5F)).empty());
}

TEST_CASE("cracks: a triangle that rounding has made an edge joins those beside it") {
  Mesh mesh = grid(8);
  // A needle beyond the format between the two triangles of a square.
  const std::size_t square = 54;
  mesh.triangles[square + 1] = mesh.triangles[square];
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const glm::vec3 a = mesh.corners(square)[0];
  const glm::vec3 c = mesh.corners(square)[2];
  const glm::vec3 beside = c + glm::vec3(-0x1p-20F, 0x1p-20F, 0.0F);
  mesh.vertices.insert(mesh.vertices.end(), {a, beside, {a.x, c.y, 0.0F}, a, c, beside});
  mesh.triangles[square + 1] = {first, first + 1, first + 2};
  mesh.triangles.push_back({first + 3, first + 4, first + 5});
  CHECK(sheet_of(mesh, down(0.4375F, 0.4375F)) == std::vector<std::int32_t>{54, 55});
}

}  // namespace
}  // namespace ti
