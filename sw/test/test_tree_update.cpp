// SPDX-License-Identifier: Apache-2.0
// A tree that follows moving triangles holds what a tree of its own would, and keeps what stands
// still.

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "accel/build.hpp"
#include "engine/lock_step.hpp"
#include "model/tracer.hpp"
#include "scene/rays.hpp"
#include "test/tree_walk.hpp"

namespace ti {
namespace {

constexpr Box kReach{{-2, -2, -2}, {3, 3, 3}};

/// Moves the first `count` triangles of a soup by `step`.
Mesh moved(Mesh mesh, std::size_t count, const glm::vec3& step) {
  for (std::size_t i = 0; i < 3 * count; ++i) mesh.vertices[i] += step;
  return mesh;
}

/// t and primitive of random rays.
std::vector<std::pair<float, std::int32_t>> answers(const Mesh& mesh, const Image& image) {
  const std::vector<Ray> rays = random_rays(mesh, 2000, 3);
  std::vector<std::pair<float, std::int32_t>> out;
  for (const HitBits& bits : run_model(*Tracer::create(image, {}), rays).hits) {
    const Hit hit = hit_of({}, bits);
    out.emplace_back(hit.t, hit.prim);
  }
  return out;
}

TEST_CASE(
    "tree update: cells have what they must after each of many moves, and hits are the same") {
  for (const std::size_t count : {std::size_t{1}, std::size_t{20}, std::size_t{300}}) {
    Mesh mesh = soup(400, 0.1F, 5);
    MovingTree tree({}, kReach);
    BuildStats stats;
    (void)tree.next(mesh, false, stats);
    CHECK(stats.new_references == stats.references);
    for (int i = 0; i < 6; ++i) {
      mesh = moved(mesh, count, {0.13F, i % 2 == 0 ? 0.07F : -0.2F, 0.02F});
      const Image image = tree.next(mesh, false, stats);
      CAPTURE(count);
      CAPTURE(i);
      check_membership(mesh, image);
      BuildStats fresh;
      CHECK(answers(mesh, image) == answers(mesh, build_image(mesh, {}, fresh)));
    }
  }
}

TEST_CASE("tree update: what stands still is not built anew") {
  const Mesh mesh = soup(4000, 0.03F, 6);
  MovingTree tree({}, kReach);
  BuildStats stats;
  const Image first = tree.next(mesh, false, stats);
  const Image same = tree.next(mesh, false, stats);
  CHECK(stats.new_cells == 0);
  CHECK(std::equal(first.bytes().begin(), first.bytes().end(), same.bytes().begin(),
                   same.bytes().end()));
  (void)tree.next(moved(mesh, 1, {0.01F, 0, 0}), false, stats);
  CHECK(stats.new_cells > 0);
  CHECK(stats.new_references < stats.references / 20);
  (void)tree.next(moved(mesh, 4000, {0.01F, 0, 0}), false, stats);
  CHECK(stats.new_references == stats.references);
}

TEST_CASE("tree update: other triangles are dropped, or all is asked for: the tree is built anew") {
  Mesh mesh = soup(200, 0.1F, 7);
  MovingTree tree({}, kReach);
  BuildStats stats;
  (void)tree.next(mesh, false, stats);
  for (int corner = 0; corner < 3; ++corner) mesh.vertices[corner] = {0.5F, 0.5F, 0.5F};
  const Image image = tree.next(mesh, false, stats);
  CHECK(stats.dropped_zero_area == 1);
  CHECK(stats.new_references == stats.references);
  for (const Leaf& leaf : leaves(image))
    CHECK(!std::binary_search(leaf.prims.begin(), leaf.prims.end(), 0U));
  (void)tree.next(mesh, true, stats);
  CHECK(stats.new_references == stats.references);
}

TEST_CASE("tree update: a triangle that leaves a cell leaves its lists, and returns") {
  Mesh mesh = soup(100, 0.05F, 8);
  MovingTree tree({}, kReach);
  BuildStats stats;
  (void)tree.next(mesh, false, stats);
  const Mesh away = moved(mesh, 10, {1.5F, 1.5F, 1.5F});
  check_membership(away, tree.next(away, false, stats));
  check_membership(mesh, tree.next(mesh, false, stats));
}

}  // namespace
}  // namespace ti
