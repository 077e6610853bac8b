// SPDX-License-Identifier: Apache-2.0
// What must not change a hit, bit for bit: axes mirrored and permuted, a scale of a power of two,
// the order of triangles, a twin of each triangle; and for Woop's test a translation by exact
// vectors.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "model/tracer.hpp"
#include "scene/rays.hpp"
#include "tree_walk.hpp"

namespace ti {
namespace {

struct Machine {
  Format format;
  TestKind test;
  Traversal traversal;
};

std::vector<Machine> machines() {
  std::vector<Machine> all;
  for (const Format& format : {Format{8, 13}, Format{7, 16, {.toward_zero = true}}, Format{}}) {
    for (const TestKind test : {TestKind::Local, TestKind::Np, TestKind::Woop}) {
      for (const Traversal traversal : {Traversal::kPlain, Traversal::kPadded})
        all.push_back({format, test, traversal});
    }
  }
  return all;
}

/// The hits of a machine, without the nodes that they took.
std::vector<HitBits> hits_of(const Machine& machine, const Mesh& mesh,
                             const std::vector<Ray>& rays) {
  BuildOptions options;
  options.format = machine.format;
  options.test = machine.test;
  BuildStats stats;
  const Image image = build_image(mesh, options, stats);
  Work work;
  auto hits = Tracer::create(image, {.traversal = machine.traversal})->trace(std::span(rays), work);
  for (HitBits& hit : hits) hit.steps = 0;
  return hits;
}

/// Mesh and rays with every point and direction changed.
struct Moved {
  Mesh mesh;
  std::vector<Ray> rays;
};
Moved moved(const Mesh& mesh, const std::vector<Ray>& rays,
            const std::function<glm::vec3(const glm::vec3&)>& point,
            const std::function<glm::vec3(const glm::vec3&)>& direction) {
  Moved out{mesh, rays};
  for (glm::vec3& p : out.mesh.vertices) p = point(p);
  for (Ray& ray : out.rays) {
    ray.o = point(ray.o);
    ray.d = direction(ray.d);
  }
  return out;
}

void check_same(const std::function<glm::vec3(const glm::vec3&)>& change) {
  const Mesh mesh = soup(300, 0.3F, 8);
  const auto rays = inside_rays(mesh, 600, 4);
  const Moved other = moved(mesh, rays, change, change);
  for (const Machine& machine : machines()) {
    CAPTURE(name_of(machine.format));
    CAPTURE(test_name(machine.test));
    CHECK(hits_of(machine, other.mesh, other.rays) == hits_of(machine, mesh, rays));
  }
}

TEST_CASE("invariance: each axis may be mirrored") {
  for (int axis = 0; axis < 3; ++axis) {
    check_same([axis](glm::vec3 p) {
      p[axis] = -p[axis];
      return p;
    });
  }
}

TEST_CASE("invariance: axes may change places") {
  for (const std::array<int, 3>& to :
       {std::array{1, 2, 0}, std::array{2, 0, 1}, std::array{1, 0, 2}, std::array{0, 2, 1}}) {
    check_same([to](const glm::vec3& p) { return glm::vec3(p[to[0]], p[to[1]], p[to[2]]); });
  }
}

TEST_CASE("invariance: a scale of a power of two leaves t, and t of a fixed direction has it") {
  for (const int power : {-9, -1, 5}) {
    const float scale = std::ldexp(1.0F, power);
    check_same([scale](const glm::vec3& p) { return scale * p; });
  }
  const Mesh mesh = soup(300, 0.3F, 8);
  const auto rays = inside_rays(mesh, 600, 4);
  const auto larger = [](const glm::vec3& p) { return 8.0F * p; };
  const auto same = [](const glm::vec3& d) { return d; };
  const Moved other = moved(mesh, rays, larger, same);
  for (const Machine& machine : machines()) {
    const auto before = hits_of(machine, mesh, rays);
    const auto after = hits_of(machine, other.mesh, other.rays);
    for (std::size_t i = 0; i < before.size(); ++i) {
      REQUIRE(after[i].prim == before[i].prim);
      if (before[i].prim < 0) continue;
      REQUIRE(hit_of(machine.format, after[i]).t == 8.0F * hit_of(machine.format, before[i]).t);
      REQUIRE(after[i].u == before[i].u);
      REQUIRE(after[i].v == before[i].v);
    }
  }
}

TEST_CASE("invariance: the order of the triangles leaves the hit, but for its number") {
  const Mesh mesh = soup(300, 0.3F, 8);
  Mesh turned = mesh;
  std::reverse(turned.triangles.begin(), turned.triangles.end());
  const auto last = static_cast<std::int32_t>(mesh.triangles.size()) - 1;
  const auto rays = inside_rays(mesh, 600, 4);
  for (const Machine& machine : machines()) {
    const auto before = hits_of(machine, mesh, rays);
    const auto after = hits_of(machine, turned, rays);
    std::size_t ties = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      REQUIRE(after[i].t == before[i].t);
      if (before[i].prim < 0 || after[i].prim == last - before[i].prim) {
        REQUIRE(after[i].u == before[i].u);
        REQUIRE(after[i].v == before[i].v);
      } else {  // of equal t the lower number, which is that of the other one now
        ++ties;
        REQUIRE(last - after[i].prim > before[i].prim);
      }
    }
    CHECK(ties < before.size() / 20);
  }
}

TEST_CASE("invariance: of two equal triangles the lower number is hit") {
  const Mesh mesh = soup(300, 0.3F, 8);
  Mesh twice = mesh;
  twice.triangles.insert(twice.triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
  const auto rays = inside_rays(mesh, 600, 4);
  for (const Machine& machine : machines())
    CHECK(hits_of(machine, twice, rays) == hits_of(machine, mesh, rays));
}

TEST_CASE("invariance: a translation that rounds nothing leaves the hits of local and woop") {
  // On a grid of 2^-6, so that each coordinate stays a number of the format.
  const auto on_grid = [](const glm::vec3& p) {
    return glm::vec3(std::round(p.x * 64.0F), std::round(p.y * 64.0F), std::round(p.z * 64.0F)) /
           64.0F;
  };
  const auto same = [](const glm::vec3& d) { return d; };
  const Mesh mesh = soup(300, 0.3F, 8);
  const auto rays = inside_rays(mesh, 600, 4);
  const Moved here = moved(mesh, rays, on_grid, same);
  const Moved there = moved(
      mesh, rays, [&](const glm::vec3& p) { return on_grid(p) + glm::vec3(16, -24, 8); }, same);
  for (const Machine& machine : machines()) {
    if (machine.test == TestKind::Np) continue;
    CAPTURE(name_of(machine.format));
    CAPTURE(test_name(machine.test));
    CHECK(hits_of(machine, there.mesh, there.rays) == hits_of(machine, here.mesh, here.rays));
  }
}

}  // namespace
}  // namespace ti
