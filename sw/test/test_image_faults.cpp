// SPDX-License-Identifier: Apache-2.0
// Whatever stands in an image's sections, every ray ends, and one that read what cannot be says so.
#include <doctest/doctest.h>

#include <array>
#include <random>
#include <span>
#include <vector>

#include "accel/build.hpp"
#include "accel/image_checksum.hpp"
#include "engine/fault_campaign.hpp"
#include "portable_random.hpp"
#include "tree_walk.hpp"

namespace ti {
namespace {

constexpr int kWatchdog = 1000;

Image image_of(TestKind test, Format format = {}) {
  BuildStats stats;
  return build_image(soup(60, 0.6F, 7), {.format = format, .test = test}, stats);
}

/// Rays from points of the unit cube.
std::vector<Ray> rays_of(std::uint64_t number) {
  std::mt19937 rng(static_cast<std::uint32_t>(number));
  std::vector<Ray> rays(8);
  for (Ray& ray : rays) {
    ray.d = test::on_sphere(rng);
    for (int axis = 0; axis < 3; ++axis) ray.o[axis] = test::unit_random(rng);
    ray.any = rng() % 4 == 0;
  }
  return rays;
}

/// The image with `change` made to the bytes of its sections.
template <typename Change>
Image changed(const Image& image, const Change& change) {
  std::vector<std::uint8_t> bytes(image.bytes().begin(), image.bytes().end());
  const ImageParts& parts = image.parts();
  auto* nodes = reinterpret_cast<ImageNode*>(bytes.data() + parts.node_offset);
  auto* list = reinterpret_cast<std::uint32_t*>(bytes.data() + parts.list_offset);
  change(std::span(nodes, parts.node_count), std::span(list, parts.list_count));
  auto* header = reinterpret_cast<ImageHeader*>(bytes.data());
  header->checksum = image_checksum(bytes);
  return Image(std::move(bytes), "changed", ImageCheck::Places);
}

/// The status of a ray through the middle of the image.
Status end_of(const Image& image, Traversal traversal = Traversal::kPlain) {
  const auto model = Tracer::create(image, {.watchdog_steps = kWatchdog, .traversal = traversal});
  Work work;
  return model->trace(Ray{.o = {0, 0, -9}, .d = {0.01F, 0.02F, 1}}, work).status;
}

TEST_CASE("image faults: rays on damaged images end, with an error where they read what is none") {
  struct Machine {
    TestKind test;
    Traversal traversal;
    Format format;
  };
  const std::array machines{Machine{TestKind::Local, Traversal::kPlain, {}},
                            Machine{TestKind::Np, Traversal::kPlain, {8, 13}},
                            Machine{TestKind::Woop, Traversal::kPadded, {}},
                            Machine{TestKind::Woop, Traversal::kPadded, {7, 16}}};
  for (const Machine& machine : machines) {
    const Image image = image_of(machine.test, machine.format);
    FaultSettings settings;
    settings.model = {.watchdog_steps = kWatchdog, .traversal = machine.traversal};
    settings.images = 2000;
    settings.rays = rays_of;
    const FaultCampaign campaign = run_faults(image, settings);
    for (const std::string& example : campaign.examples) MESSAGE(example);
    const FaultCount sum = campaign.sum();
    CHECK(sum.good());
    CHECK(sum.images == 2000);
    CHECK(sum.memory_errors > 100);
    CHECK((sum.watchdogs > 10) == (machine.traversal == Traversal::kPlain));
    CHECK(sum.changed > 500);
    CHECK(campaign.counts[static_cast<std::size_t>(ImageFault::Header)].refused > 50);
  }
}

TEST_CASE("image faults: a fault is a matter of its kind and seed alone") {
  const Image image = image_of(TestKind::Local);
  for (std::size_t kind = 0; kind < kImageFaults; ++kind) {
    const auto fault = static_cast<ImageFault>(kind);
    CHECK(damaged(image, fault, 3) == damaged(image, fault, 3));
    CHECK(damaged(image, fault, 3) != damaged(image, fault, 4));
  }
}

TEST_CASE("image faults: a circle ends at the watchdog") {
  const Image image = image_of(TestKind::Local);
  for (const Traversal traversal : {Traversal::kPlain, Traversal::kPadded}) {
    const Image circle = changed(image, [](auto nodes, auto) {
      for (std::uint32_t i = 0; i < nodes.size(); ++i)
        if (!nodes[i].is_leaf()) nodes[i] = {nodes[i].value, 0U << 3U | (nodes[i].link & 7U)};
    });
    const Status end = end_of(circle, traversal);
    CHECK(end == (traversal == Traversal::kPlain ? Status::Watchdog : Status::MemoryError));
  }
}

TEST_CASE("image faults: nodes, entries and triangles that are not there are memory errors") {
  const Image image = image_of(TestKind::Local);
  const auto reach = static_cast<std::uint32_t>(image.reach_of_nodes().size());
  for (const std::uint32_t far : {reach, reach + 1, (1U << 29U) - 1}) {
    CHECK(end_of(changed(image, [far](auto nodes, auto) {
            for (ImageNode& node : nodes)
              if (!node.is_leaf()) node.link = far << 3U | (node.link & 7U);
            nodes[0] = {0x7f800000U, far << 3U | 4U};  // near alone, which is that child
          })) == Status::MemoryError);
  }
  const std::uint32_t entries = image.parts().list_count;
  for (const ImageNode leaf : {ImageNode{0, 65536U << 3U | 3U}, ImageNode{0, 1U << 31U | 3U},
                               ImageNode{entries, 1U << 3U | 3U}, ImageNode{~0U, 2U << 3U | 3U},
                               ImageNode{0, (entries + 1) << 3U | 3U}}) {
    CHECK(end_of(changed(image, [leaf](auto nodes, auto) {
            for (ImageNode& node : nodes) node = leaf;
          })) == Status::MemoryError);
  }
  CHECK(end_of(changed(image, [&](auto, auto list) {
          for (std::uint32_t& entry : list) entry = image.parts().triangle_count;
        })) == Status::MemoryError);
  CHECK(end_of(changed(image, [](auto nodes, auto) {
          for (ImageNode& node : nodes) node = {~0U, 3U};  // an empty leaf reads no list
        })) == Status::Ok);
}

TEST_CASE("image faults: a padded walk ends below the last level of its trail") {
  const Image image = image_of(TestKind::Woop);
  const auto chain = [&](std::uint32_t levels) {
    return changed(image, [levels](auto nodes, auto) {
      REQUIRE(nodes.size() > levels);
      for (ImageNode& node : nodes) node = {0, 3U};
      for (std::uint32_t i = 0; i < levels; ++i) nodes[i] = {0x7f800000U, (i + 1) << 3U | 2U};
    });
  };
  CHECK(end_of(chain(64), Traversal::kPadded) == Status::Ok);
  CHECK(end_of(chain(63), Traversal::kPadded) == Status::Ok);
  CHECK(end_of(chain(65), Traversal::kPlain) == Status::Ok);
}

}  // namespace
}  // namespace ti
