// SPDX-License-Identifier: Apache-2.0
// The driver of ti_top gives each ray its hit whatever the streams, puts the scene where it says,
// and refuses what is not its machine.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "fake_machine.hpp"
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

  explicit FakeLink(int streams, Format format = {8, 23})
      : registers(test::machine_registers(streams, format)) {}

  [[nodiscard]] std::uint32_t read(std::uint32_t address) override { return registers[address]; }
  void write(std::uint32_t address, std::uint32_t value) override {
    if (address == offsetof(ti_regs_t, CONTROL) && (value & TI_REGS__CONTROL__FLUSH_bm) != 0) {
      ++flushes;
      value &= ~std::uint32_t{TI_REGS__CONTROL__FLUSH_bm};
    }
    registers[address] = value;
  }
  [[nodiscard]] std::uint64_t base() const override { return kBase; }
  void store(std::uint64_t address, std::span<const std::uint8_t> bytes) override {
    CHECK(address == kBase);
    memory.assign(bytes.begin(), bytes.end());
  }
  void exchange(std::span<host::Packet> packets) override {
    const std::uint32_t control = registers[offsetof(ti_regs_t, CONTROL)];
    CHECK((control & TI_REGS__CONTROL__RUN_bm) != 0);
    const bool any = (control & TI_REGS__CONTROL__ANY_HIT_bm) != 0;
    const Image image(memory, "memory");
    const auto model = Tracer::create(image, {});
    for (host::Packet& packet : packets) {
      for (const host::Beat& beat : packet.rays)
        packet.hits.push_back(
            test::answer(*model, beat, any, static_cast<std::uint32_t>(packet.hits.size())));
      std::shuffle(packet.hits.begin(), packet.hits.end(), random);
      if (spoil) spoil(packet.hits);
    }
  }

  std::map<std::size_t, std::uint32_t> registers;
  int flushes = 0;
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
    device.load(scene.image);
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
  device.load(scene.image);
  std::vector<Ray> rays = scene.rays;
  for (Ray& ray : rays) ray.any = true;
  Work work;
  CHECK(device.trace(rays) == Tracer::create(scene.image, {})->trace(rays, work));
}

TEST_CASE("driver: the scene stands where the image does") {
  const Scene scene;
  FakeLink link(1);
  host::Device device(link);
  device.load(scene.image);
  const ImageParts& parts = scene.image.parts();
  CHECK(link.registers[offsetof(ti_regs_t, NODE_BASE_LO)] == FakeLink::kBase + parts.node_offset);
  CHECK(link.registers[offsetof(ti_regs_t, BARY_BASE_LO)] == FakeLink::kBase + parts.bary_offset);
  CHECK(link.registers[offsetof(ti_regs_t, BARY_BASE_HI)] == 0);
  CHECK(link.registers[offsetof(ti_regs_t, NUM_RECORDS)] == parts.triangle_count);
  CHECK(link.registers[offsetof(ti_regs_t, BOX_HI) + 8] == scene.image.header().box_hi[2]);
}

TEST_CASE("driver: drain takes no more rays, a flush forgets, and registers say what has come") {
  FakeLink link(1);
  host::Device device(link);
  link.registers[offsetof(ti_regs_t, CONTROL)] = TI_REGS__CONTROL__RUN_bm;
  device.drain();
  CHECK(link.registers[offsetof(ti_regs_t, CONTROL)] == 0);
  device.flush();
  CHECK(link.flushes == 1);
  link.registers[offsetof(ti_regs_t, RAYS_LO)] = 5;
  link.registers[offsetof(ti_regs_t, RAYS_HI)] = 1;
  link.registers[offsetof(ti_regs_t, WATCHDOGS)] = 3;
  CHECK(device.tally().rays == (std::uint64_t{1} << 32U) + 5);
  CHECK(device.tally().watchdogs == 3);
  device.enable_irq(TI_REGS__IRQ_ENABLE__WATCHDOG_bm);
  CHECK(link.registers[offsetof(ti_regs_t, IRQ_ENABLE)] == 4);
  link.registers[offsetof(ti_regs_t, IRQ_STATUS)] = 8;
  CHECK(device.irq_status() == TI_REGS__IRQ_STATUS__DRAINED_bm);
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
    device.load(scene.image);
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
  test::check_error([&] { other.load(scene.image); }, {"the image is for (8,23)"});

  FakeLink narrow(1);
  narrow.registers[offsetof(ti_regs_t, MEMORY)] = 64U | 20U << 8U;
  host::Device small(narrow);
  test::check_error([&] { small.load(scene.image); }, {"beyond the 20 bits"});
}

}  // namespace
}  // namespace ti
