// SPDX-License-Identifier: Apache-2.0
#include "host/device.hpp"

#include <fmt/core.h>

#include <chrono>
#include <cstddef>
#include <string>
#include <thread>

#include "base/error.hpp"
#include "host/ti_regs.h"

namespace ti::host {
namespace {

/// Reads of STATUS or CONTROL, and time, until what is waited for counts as never coming.
constexpr int kReads = 1'000'000;
constexpr std::chrono::seconds kPatience{2};

constexpr std::uint32_t at(std::size_t offset) { return static_cast<std::uint32_t>(offset); }

constexpr std::uint32_t field(std::uint32_t word, std::uint32_t mask, int low) {
  return (word & mask) >> low;
}

}  // namespace

Device::Device(Link& link) : link_(link) {
  const std::uint32_t id = link_.read(at(offsetof(ti_regs_t, ID)));
  if (id != TI_REGS__ID__VALUE_reset)
    throw Error(fmt::format("there is no ti_top here, register ID is {:08x}", id));
  const std::uint32_t version = link_.read(at(offsetof(ti_regs_t, VERSION)));
  const std::uint32_t major =
      field(version, TI_REGS__VERSION__MAJOR_bm, TI_REGS__VERSION__MAJOR_bp);
  if (major != TI_REGS__VERSION__MAJOR_reset) {
    throw Error(fmt::format("this ti_top has registers of version {}, the driver those of {}",
                            major, TI_REGS__VERSION__MAJOR_reset));
  }
  machine_.digest = link_.read(at(offsetof(ti_regs_t, CONFIG_HASH)));
  const std::uint32_t format = link_.read(at(offsetof(ti_regs_t, FORMAT)));
  machine_.format.exp_bits =
      static_cast<int>(field(format, TI_REGS__FORMAT__EXP_BITS_bm, TI_REGS__FORMAT__EXP_BITS_bp));
  machine_.format.frac_bits =
      static_cast<int>(field(format, TI_REGS__FORMAT__FRAC_BITS_bm, TI_REGS__FORMAT__FRAC_BITS_bp));
  machine_.format.modes.toward_zero = (format & TI_REGS__FORMAT__ROUNDING_bm) != 0;
  machine_.format.modes.flush = (format & TI_REGS__FORMAT__SUBNORMALS_bm) != 0;
  const std::uint32_t machine = link_.read(at(offsetof(ti_regs_t, MACHINE)));
  machine_.cores =
      static_cast<int>(field(machine, TI_REGS__MACHINE__CORES_bm, TI_REGS__MACHINE__CORES_bp));
  machine_.streams =
      static_cast<int>(field(machine, TI_REGS__MACHINE__STREAMS_bm, TI_REGS__MACHINE__STREAMS_bp));
  machine_.triangle_test = static_cast<TriangleTest>(
      field(machine, TI_REGS__MACHINE__TRIANGLE_TEST_bm, TI_REGS__MACHINE__TRIANGLE_TEST_bp));
  machine_.any_hit = (machine & TI_REGS__MACHINE__ANY_HIT_bm) != 0;
  machine_.counters = (machine & TI_REGS__MACHINE__COUNTERS_bm) != 0;
  machine_.snapshot = (machine & TI_REGS__MACHINE__SNAPSHOT_bm) != 0;
  const std::uint32_t memory = link_.read(at(offsetof(ti_regs_t, MEMORY)));
  machine_.line_bytes = static_cast<int>(
      field(memory, TI_REGS__MEMORY__LINE_BYTES_bm, TI_REGS__MEMORY__LINE_BYTES_bp));
  machine_.addr_bits =
      static_cast<int>(field(memory, TI_REGS__MEMORY__ADDR_BITS_bm, TI_REGS__MEMORY__ADDR_BITS_bp));
}

void Device::load(const Image& image) {
  const std::uint64_t base = link_.base();
  const ImageHeader& header = image.header();
  const ImageParts& parts = image.parts();
  const Format& format = machine_.format;
  const Format& given = image.format();
  if (given.exp_bits != format.exp_bits || given.frac_bits != format.frac_bits ||
      given.modes.toward_zero != format.modes.toward_zero ||
      given.modes.flush != format.modes.flush || header.test != test_kind(machine_.triangle_test)) {
    throw Error(fmt::format("the image is for {} and the test {}, the engine has {} and {}",
                            name_of(given), test_name(header.test), name_of(format),
                            test_name(test_kind(machine_.triangle_test))));
  }
  const std::uint64_t end = base + image.bytes().size();
  if (machine_.addr_bits < 64 && end > std::uint64_t{1} << machine_.addr_bits) {
    throw Error(fmt::format("the image ends at address {}, beyond the {} bits of the engine's", end,
                            machine_.addr_bits));
  }
  drain();
  link_.store(base, image.bytes());
  link_.write(at(offsetof(ti_regs_t, ROOT)), header.root);
  link_.write(at(offsetof(ti_regs_t, NUM_LIST)), parts.list_count);
  link_.write(at(offsetof(ti_regs_t, NUM_RECORDS)), parts.triangle_count);
  write_long(at(offsetof(ti_regs_t, NODE_BASE_LO)), base + parts.node_offset);
  write_long(at(offsetof(ti_regs_t, LIST_BASE_LO)), base + parts.list_offset);
  write_long(at(offsetof(ti_regs_t, PLANE_BASE_LO)), base + parts.record_offset());
  write_long(at(offsetof(ti_regs_t, BARY_BASE_LO)), base + parts.bary_offset);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    link_.write(at(offsetof(ti_regs_t, BOX_LO) + 4 * axis), header.box_lo[axis]);
    link_.write(at(offsetof(ti_regs_t, BOX_HI) + 4 * axis), header.box_hi[axis]);
  }
  flush();
}

void Device::drain() {
  link_.write(at(offsetof(ti_regs_t, CONTROL)), 0);
  wait(at(offsetof(ti_regs_t, STATUS)), TI_REGS__STATUS__IDLE_bm, TI_REGS__STATUS__IDLE_bm);
}

void Device::flush() {
  link_.write(at(offsetof(ti_regs_t, CONTROL)), TI_REGS__CONTROL__FLUSH_bm);
  wait(at(offsetof(ti_regs_t, CONTROL)), TI_REGS__CONTROL__FLUSH_bm, 0);
}

std::vector<HitBits> Device::trace(std::span<const Ray> rays) {
  if (rays.empty()) return {};
  const auto streams = static_cast<std::size_t>(machine_.streams);
  const std::size_t part = (rays.size() + streams - 1) / streams;
  std::vector<Packet> packets(streams);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto bits = [this](float value) { return round_to_bits(machine_.format, value); };
    const Ray& ray = rays[i];
    packets[i / part].rays.push_back({bits(ray.o.x), bits(ray.o.y), bits(ray.o.z), bits(ray.tmin),
                                      bits(ray.d.x), bits(ray.d.y), bits(ray.d.z), bits(ray.tmax)});
  }
  const std::uint32_t any = rays.front().any ? TI_REGS__CONTROL__ANY_HIT_bm : 0;
  link_.write(at(offsetof(ti_regs_t, CONTROL)), any);
  link_.write(at(offsetof(ti_regs_t, CONTROL)),
              any | TI_REGS__CONTROL__RUN_bm | TI_REGS__CONTROL__COUNT_bm);
  link_.exchange(packets);
  link_.write(at(offsetof(ti_regs_t, CONTROL)), any);

  std::vector<HitBits> hits(rays.size());
  std::vector<bool> came(rays.size());
  for (std::size_t s = 0; s < streams; ++s) {
    for (const Beat& beat : packets[s].hits) {
      const std::size_t place = s * part + beat[0];
      if (beat[0] >= packets[s].rays.size() || came[place])
        throw Error(fmt::format("stream {}: a hit of ray {}, which nobody waits for", s, beat[0]));
      came[place] = true;
      hits[place] = {.t = beat[2],
                     .u = beat[3],
                     .v = beat[4],
                     .prim = static_cast<std::int32_t>(beat[1]),
                     .status = static_cast<Status>(beat[5]),
                     .steps = static_cast<std::uint16_t>(beat[6])};
    }
    if (packets[s].hits.size() != packets[s].rays.size()) {
      throw Error(fmt::format("stream {}: {} of {} hits came, the engine has lost rays", s,
                              packets[s].hits.size(), packets[s].rays.size()));
    }
  }
  return hits;
}

Tally Device::tally() {
  return {.rays = read_long(at(offsetof(ti_regs_t, RAYS_LO))),
          .hits = read_long(at(offsetof(ti_regs_t, HITS_LO))),
          .invalid_rays = link_.read(at(offsetof(ti_regs_t, INVALID_RAYS))),
          .memory_errors = link_.read(at(offsetof(ti_regs_t, MEMORY_ERRORS))),
          .watchdogs = link_.read(at(offsetof(ti_regs_t, WATCHDOGS)))};
}

std::uint32_t Device::irq_status() { return link_.read(at(offsetof(ti_regs_t, IRQ_STATUS))); }

void Device::clear_irq(std::uint32_t bits) {
  link_.write(at(offsetof(ti_regs_t, IRQ_STATUS)), bits);
}

void Device::enable_irq(std::uint32_t bits) {
  link_.write(at(offsetof(ti_regs_t, IRQ_ENABLE)), bits);
}

std::uint64_t Device::counter(int core, int unit, int event) {
  link_.write(at(offsetof(ti_regs_t, COUNTER_SELECT)),
              static_cast<std::uint32_t>(core) << TI_REGS__COUNTER_SELECT__CORE_bp |
                  static_cast<std::uint32_t>(unit) << TI_REGS__COUNTER_SELECT__UNIT_bp |
                  static_cast<std::uint32_t>(event) << TI_REGS__COUNTER_SELECT__EVENT_NUMBER_bp);
  return read_long(at(offsetof(ti_regs_t, COUNTER_LO)));
}

void Device::snapshot() {
  link_.write(at(offsetof(ti_regs_t, SNAPSHOT)), TI_REGS__SNAPSHOT__TAKE_bm);
}

std::uint64_t Device::read_long(std::uint32_t low) {
  const std::uint64_t value = link_.read(low);  // keeps the upper half
  return value | std::uint64_t{link_.read(low + 4)} << 32U;
}

void Device::write_long(std::uint32_t low, std::uint64_t value) {
  link_.write(low, static_cast<std::uint32_t>(value));
  link_.write(low + 4, static_cast<std::uint32_t>(value >> 32U));
}

void Device::wait(std::uint32_t address, std::uint32_t mask, std::uint32_t value) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  for (int i = 0; i < kReads || std::chrono::steady_clock::now() < end; ++i) {
    if ((link_.read(address) & mask) == value) return;
    std::this_thread::yield();
  }
  throw Error(fmt::format("the engine does not come to rest, as register {:02x} says", address));
}

}  // namespace ti::host
