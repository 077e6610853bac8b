// SPDX-License-Identifier: Apache-2.0
// Walks end: rays that are made to stall restarts stay within the bound of their tree, and a tree
// that leads in a circle ends by the watchdog.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "accel/tree_bounds.hpp"
#include "model/tracer.hpp"
#include "portable_random.hpp"
#include "scene/geometry.hpp"
#include "tree_walk.hpp"
#include "volume.hpp"

namespace ti {
namespace {

/// Squares of a grid of 4 x 4 x 4 cells, on all of its planes: splits meet in lines and points, and
/// triangles lie in them.
Mesh lattice() {
  std::vector<glm::vec3> corners;
  for (int axis = 0; axis < 3; ++axis) {
    for (int plane = 0; plane <= 4; ++plane) {
      for (int cell = 0; cell < 16; ++cell) {
        const auto at = [&](int du, int dv) {
          glm::vec3 p;
          p[axis] = 0.25F * static_cast<float>(plane);
          p[(axis + 1) % 3] = 0.25F * static_cast<float>(cell % 4 + du);
          p[(axis + 2) % 3] = 0.25F * static_cast<float>(cell / 4 + dv);
          return p;
        };
        for (const auto& p : {at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)})
          corners.push_back(p);
      }
    }
  }
  return mesh_of(corners);
}

/// A ray made to stall: it begins in a plane, an edge or a corner of the tree or of a cell of the
/// lattice, or up to 1,000 diagonals away, and goes along a plane, along an axis, towards a corner,
/// or nearly so.
class StallingRays {
 public:
  explicit StallingRays(const Image& image, std::uint32_t seed) : random_(seed) {
    for (const ImageNode& node : image.nodes()) {
      if (node.is_leaf()) continue;
      planes_[node.axis()].push_back(static_cast<float>(value_of_bits(image.format(), node.value)));
    }
    for (auto& planes : planes_) planes.push_back(0.5F);
  }

  Ray operator()() {
    Ray ray;
    const glm::vec3 from = point();
    const glm::vec3 to = point();
    ray.o = from;
    switch (random_() % 4) {
      case 0: {  // along an axis, in planes of the others, or off it by next to nothing
        const auto axis = static_cast<int>(random_() % 3);
        ray.d[axis] = random_() % 2 == 0 ? 1.0F : -1.0F;
        const auto tilted = (axis + 1) % 3;
        constexpr std::array<float, 4> kTilts{0.0F, -0.0F, 1e-6F, -1e-30F};
        ray.d[tilted] = kTilts[random_() % 4];
        ray.o -= 2.0F * ray.d;
        break;
      }
      case 1:  // to a corner from anywhere near
        ray.d = to - from;
        break;
      case 2: {  // diagonal: three planes at one t
        for (int axis = 0; axis < 3; ++axis) ray.d[axis] = random_() % 2 == 0 ? 0.25F : -0.25F;
        ray.o -= 8.0F * ray.d;
        break;
      }
      default: {  // from afar to a corner
        const float away = std::ldexp(1.0F, static_cast<int>(random_() % 11));
        const glm::vec3 side = test::on_sphere(random_);
        ray.o = to + away * side;
        ray.d = to - ray.o;
      }
    }
    if (ray.d == glm::vec3(0.0F)) ray.d.x = 1.0F;
    return ray;
  }

 private:
  glm::vec3 point() {
    glm::vec3 p;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto& planes = planes_[axis];
      p[static_cast<int>(axis)] =
          random_() % 4 == 0 ? test::unit_random(random_) : planes[random_() % planes.size()];
    }
    return p;
  }

  std::array<std::vector<float>, 3> planes_;
  std::mt19937 random_;
};

std::vector<Format> formats() {
  std::vector<Format> formats{{5, 10}, {8, 13}, {7, 16}, {8, 20}, {8, 23}};
  formats.push_back({7, 16, {.toward_zero = true, .flush = false}});
  return formats;
}

/// `count` rays for each tree, format, walk and depth of the stack. Every ray ends as it should,
/// having visited no leaf twice and, in each descent, no more nodes than the tree is deep.
void check_ends(std::size_t count) {
  std::uint64_t traced = 0;
  std::uint64_t restarts = 0;
  for (const Mesh& mesh : {lattice(), soup(300, 0.2F, 4)}) {
    for (const Format& format : formats()) {
      BuildStats stats;
      const Image image = build_image(mesh, {.format = format}, stats);
      const TreeBounds bounds = tree_bounds(image).value();
      REQUIRE(bounds.steps < 65535);
      const std::uint64_t descent = static_cast<std::uint64_t>(stats.depth) + 1;
      for (const Traversal traversal : {Traversal::kPlain, Traversal::kPadded}) {
        for (const int depth : {0, 1, 2, 3, 4, 8}) {
          const auto model = Tracer::create(image, {.stack_depth = depth, .traversal = traversal});
          StallingRays rays(image, 7);
          std::uint64_t wrong = 0;
          for (std::size_t i = 0; i < count; ++i) {
            const Ray ray = rays();
            Work work;
            const HitBits hit = model->trace(ray, work);
            wrong += hit.status != Status::Ok || hit.steps != work.steps ||
                     work.leaves > stats.leaves || work.steps > work.leaves * descent ||
                     hit.steps > bounds.steps;
            restarts += work.restarts;
          }
          CAPTURE(name_of(format));
          CAPTURE(depth);
          CHECK(wrong == 0);
          traced += count;
        }
      }
    }
  }
  MESSAGE(traced << " rays, " << restarts << " restarts");
  CHECK(restarts > traced / 10);
}

TEST_CASE("restarts end within the bound of the tree, for rays that are made to stall them") {
  check_ends(test::volume(1000));
}

TEST_CASE("restarts end: the same for ten million rays" * doctest::skip()) { check_ends(70000); }

}  // namespace
}  // namespace ti
