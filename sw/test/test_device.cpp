// SPDX-License-Identifier: Apache-2.0
// The driver of ti_top gives each ray its hit whatever the streams, puts the scene where it says,
// and refuses what is not its machine.
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "host/device.hpp"
#include "host/ti_regs.h"
#include "model/tracer.hpp"
#include "scene/rays.hpp"
#include "support.hpp"
#include "tree_walk.hpp"

namespace ti {
namespace {

/// A machine whose engine is the model.
class FakeLink final : public host::Link {
 public:
  static constexpr std::uint64_t kBase = 0x100000;

  explicit FakeLink(int streams, Format format = {8, 23}) {
    registers[offsetof(ti_regs_t, ID)] = TI_REGS__ID__VALUE_reset;
    registers[offsetof(ti_regs_t, VERSION)] = 1U << 16U | 7U;
    registers[offsetof(ti_regs_t, FORMAT)] =
        static_cast<std::uint32_t>(format.exp_bits | format.frac_bits << 8);
    registers[offsetof(ti_regs_t, MACHINE)] =
        static_cast<std::uint32_t>(streams | streams << 8) | 1U << 20U;
    registers[offsetof(ti_regs_t, MEMORY)] = 64U | 32U << 8U;
    registers[offsetof(ti_regs_t, STATUS)] = TI_REGS__STATUS__IDLE_bm;
  }

  [[nodiscard]] std::uint32_t read(std::uint32_t address) override { return registers[address]; }
  void write(std::uint32_t address, std::uint32_t value) override {
    if (address == offsetof(ti_regs_t, CONTROL))
      value &= ~std::uint32_t{TI_REGS__CONTROL__FLUSH_bm};
    registers[address] = value;
  }
  void store(std::uint64_t address, std::span<const std::uint8_t> bytes) override {
    CHECK(address == kBase);
    memory.assign(bytes.begin(), bytes.end());
  }
  void exchange(std::span<host::Packet> packets) override {
    CHECK((registers[offsetof(ti_regs_t, CONTROL)] & TI_REGS__CONTROL__RUN_bm) != 0);
    const Image image(memory, "memory");
    const auto model = Tracer::create(image, {});
    for (host::Packet& packet : packets) {
      Work work;
      for (const host::Beat& beat : packet.rays) {
        const auto value = [&beat](std::size_t word) { return std::bit_cast<float>(beat[word]); };
        const Ray ray{
            .o = {value(0), value(1), value(2)},
            .tmin = value(3),
            .d = {value(4), value(5), value(6)},
            .tmax = value(7),
            .any = (registers[offsetof(ti_regs_t, CONTROL)] & TI_REGS__CONTROL__ANY_HIT_bm) != 0};
        const HitBits hit = model->trace(ray, work);
        packet.hits.push_back({static_cast<std::uint32_t>(packet.hits.size()),
                               static_cast<std::uint32_t>(hit.prim), hit.t, hit.u, hit.v,
                               static_cast<std::uint32_t>(hit.status), hit.steps, 0});
      }
      std::shuffle(packet.hits.begin(), packet.hits.end(), random);
      if (spoil) spoil(packet.hits);
    }
  }

  std::map<std::size_t, std::uint32_t> registers;
  std::vector<std::uint8_t> memory;
  std::mt19937 random{1};
  std::function<void(std::vector<host::Beat>&)> spoil;
};

struct Scene {
  Mesh mesh = soup(40, 0.5F, 1);
  BuildStats stats;
  Image image = build_image(mesh, {}, stats);
  std::vector<Ray> rays = random_rays(mesh, 101, 3);
};

TEST_CASE("driver: every ray gets its hit, on any number of streams") {
  const Scene scene;
  const auto model = Tracer::create(scene.image, {});
  for (const int streams : {1, 2, 3, 64}) {
    CAPTURE(streams);
    FakeLink link(streams);
    host::Device device(link);
    device.load(scene.image, FakeLink::kBase);
    for (const std::size_t count : {0U, 1U, 2U, 101U}) {
      const std::vector<Ray> rays(scene.rays.begin(),
                                  scene.rays.begin() + static_cast<std::ptrdiff_t>(count));
      Work work;
      CHECK(device.trace(rays) == model->trace(rays, work));
    }
  }
}

TEST_CASE("driver: any-hit rays are asked for by the register") {
  const Scene scene;
  FakeLink link(1);
  host::Device device(link);
  device.load(scene.image, FakeLink::kBase);
  std::vector<Ray> rays = scene.rays;
  for (Ray& ray : rays) ray.any = true;
  Work work;
  CHECK(device.trace(rays) == Tracer::create(scene.image, {})->trace(rays, work));
}

TEST_CASE("driver: the scene stands where the image does") {
  const Scene scene;
  FakeLink link(1);
  host::Device device(link);
  device.load(scene.image, FakeLink::kBase);
  const ImageParts& parts = scene.image.parts();
  CHECK(link.registers[offsetof(ti_regs_t, NODE_BASE_LO)] == FakeLink::kBase + parts.node_offset);
  CHECK(link.registers[offsetof(ti_regs_t, BARY_BASE_LO)] == FakeLink::kBase + parts.bary_offset);
  CHECK(link.registers[offsetof(ti_regs_t, BARY_BASE_HI)] == 0);
  CHECK(link.registers[offsetof(ti_regs_t, NUM_RECORDS)] == parts.triangle_count);
  CHECK(link.registers[offsetof(ti_regs_t, BOX_HI) + 8] == scene.image.header().box_hi[2]);
}

TEST_CASE("driver: a hit that is missing, twice or of no ray is an error") {
  const Scene scene;
  const std::map<std::string, std::function<void(std::vector<host::Beat>&)>> ways{
      {"of 101 hits came", [](auto& hits) { hits.pop_back(); }},
      {"which nobody waits for", [](auto& hits) { hits.push_back(hits.front()); }},
      {"a hit of ray 101,", [](auto& hits) { hits.back()[0] = 101; }}};
  for (const auto& [sentence, spoil] : ways) {
    FakeLink link(1);
    host::Device device(link);
    device.load(scene.image, FakeLink::kBase);
    link.spoil = spoil;
    test::check_error([&] { (void)device.trace(scene.rays); }, {sentence});
  }
}

TEST_CASE("driver: another machine than the driver's or the image's is refused") {
  const Scene scene;
  FakeLink none(1);
  none.registers[offsetof(ti_regs_t, ID)] = 0xdeadbeef;
  test::check_error([&] { host::Device device(none); }, {"there is no ti_top here"});

  FakeLink later(1);
  later.registers[offsetof(ti_regs_t, VERSION)] = 2U << 16U;
  test::check_error([&] { host::Device device(later); }, {"registers of version 2"});

  FakeLink short_numbers(1, {7, 16});
  host::Device other(short_numbers);
  CHECK(other.machine().format == Format{7, 16});
  test::check_error([&] { other.load(scene.image, FakeLink::kBase); }, {"the image is for (8,23)"});

  FakeLink narrow(1);
  narrow.registers[offsetof(ti_regs_t, MEMORY)] = 64U | 20U << 8U;
  host::Device small(narrow);
  test::check_error([&] { small.load(scene.image, FakeLink::kBase); }, {"beyond the 20 bits"});
}

}  // namespace
}  // namespace ti
