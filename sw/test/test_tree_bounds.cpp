// SPDX-License-Identifier: Apache-2.0
// No walk exceeds the bounds of its tree, and where restarts are left out a tree that may overflow
// the stack is refused.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "accel/image_checksum.hpp"
#include "accel/tree_bounds.hpp"
#include "model/tracer.hpp"
#include "model/trv.hpp"
#include "scene/rays.hpp"
#include "support.hpp"
#include "tree_walk.hpp"

namespace ti {
namespace {

/// The most entries of a ray of these signs that takes both children of every node.
int entries(const Image& image, std::uint32_t index, const std::array<bool, 3>& negative) {
  const ImageNode& node = image.nodes()[index];
  if (node.is_leaf()) return 0;
  const auto [near, far] = model::ordered(node, index, negative[node.axis()]);
  return std::max(1 + entries(image, near, negative), entries(image, far, negative));
}

Image image_of(std::size_t triangles, float size, Layout layout = Layout::kOdfl) {
  BuildStats stats;
  BuildOptions options;
  options.layout = layout;
  return build_image(soup(triangles, size, 4), options, stats);
}

/// The image with other nodes from its root on.
Image changed(const Image& image, const std::vector<ImageNode>& nodes) {
  std::vector<std::uint8_t> bytes(image.bytes().begin(), image.bytes().end());
  std::memcpy(bytes.data() + image.parts().node_offset + 8 * image.header().root, nodes.data(),
              nodes.size() * sizeof(ImageNode));
  const std::uint32_t sum = image_checksum(bytes);
  std::memcpy(bytes.data() + offsetof(ImageHeader, checksum), &sum, sizeof(sum));
  return Image(std::move(bytes), "changed.tiim");
}

TEST_CASE("tree bounds: the stack is what a ray that takes both children of all nodes has") {
  for (const Layout layout : {Layout::kOdfl, Layout::kDfl}) {
    for (const std::size_t triangles : {0U, 1U, 2U, 10U, 300U, 3000U}) {
      CAPTURE(triangles);
      const Image image = image_of(triangles, 0.1F, layout);
      int most = 0;
      for (int octant = 0; octant < 8; ++octant) {
        const std::array<bool, 3> signs{(octant & 1) != 0, (octant & 2) != 0, (octant & 4) != 0};
        most = std::max(most, entries(image, image.header().root, signs));
      }
      CHECK(tree_bounds(image)->stack == most);
      CHECK(tree_bounds(image)->nodes == image.nodes().size());
    }
  }
}

TEST_CASE("tree bounds: no ray restarts with that stack, and none visits more nodes") {
  const Mesh mesh = soup(300, 0.1F, 4);
  BuildStats stats;
  const Image image = build_image(mesh, {}, stats);
  const TreeBounds bounds = tree_bounds(image).value();
  CHECK(bounds.stack < stats.depth);
  const auto rays = inside_rays(mesh, 5000, 2);
  Work work;
  const auto whole = Tracer::create(image, {.stack_depth = bounds.stack, .restart = false});
  const auto watched = Tracer::create(
      image, {.stack_depth = bounds.stack, .watchdog_steps = static_cast<int>(bounds.nodes)});
  const auto without =
      Tracer::create(image, {.stack_depth = 0, .watchdog_steps = static_cast<int>(bounds.steps)});
  CHECK(whole->trace(rays, work) == watched->trace(rays, work));
  CHECK(work.restarts == 0);
  for (const HitBits& hit : without->trace(rays, work)) REQUIRE(hit.status == Status::Ok);
  CHECK(work.restarts > 0);
}

TEST_CASE("tree bounds: a tree that just fits the stack is traced, one entry less is refused") {
  const Image image = image_of(300, 0.1F);
  const int stack = tree_bounds(image)->stack;
  CHECK(Tracer::create(image, {.stack_depth = stack, .restart = false}) != nullptr);
  test::check_error(
      [&] { (void)Tracer::create(image, {.stack_depth = stack - 1, .restart = false}); },
      {std::to_string(stack) + " entries", "stack_depth is " + std::to_string(stack - 1)});
  CHECK(Tracer::create(image, {.stack_depth = stack - 1}) != nullptr);
}

TEST_CASE("tree bounds: nodes that share children have none, and need restarts") {
  const Image image = image_of(10, 0.5F);
  ImageNode root = image.nodes()[image.header().root];
  root.link = (image.header().root + 1) << 3U | (root.link & 7U);  // both children are the next
  const Image shared = changed(image, {root});
  CHECK(!tree_bounds(shared));
  test::check_error([&] { (void)Tracer::create(shared, {.stack_depth = 64, .restart = false}); },
                    {"share"});
}

TEST_CASE("tree bounds: a tree deeper than the trail of a padded walk is refused") {
  // A chain: one child of each inner node is the next one, the other the leaf behind them.
  const auto chain = [](std::uint32_t depth) {
    const Image image = image_of(300, 0.1F);
    std::vector<ImageNode> nodes(depth, {0, depth << 3U});
    nodes.push_back({0, 3});
    return changed(image, nodes);
  };
  const Tracer::Options padded{.traversal = Traversal::kPadded};
  CHECK(tree_depth(chain(64)) == 64);
  CHECK(Tracer::create(chain(64), padded) != nullptr);
  CHECK(Tracer::create(chain(65), {}) != nullptr);
  test::check_error([&] { (void)Tracer::create(chain(65), padded); }, {"65 levels", "has 64"});
}

TEST_CASE("without any-hit rays such a ray is invalid, and the others are as they were") {
  const Mesh mesh = soup(300, 0.1F, 4);
  BuildStats stats;
  const Image image = build_image(mesh, {}, stats);
  auto rays = inside_rays(mesh, 1000, 2);
  for (std::size_t i = 0; i < rays.size(); i += 2) rays[i].any = true;
  Work work;
  const auto with = Tracer::create(image, {})->trace(rays, work);
  const auto without = Tracer::create(image, {.any_hit = false})->trace(rays, work);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!rays[i].any) {
      CHECK(without[i] == with[i]);
    } else {
      CHECK(without[i].status == Status::InvalidRay);
      CHECK(without[i].prim == -1);
      CHECK(without[i].steps == 0);
    }
  }
}

}  // namespace
}  // namespace ti
