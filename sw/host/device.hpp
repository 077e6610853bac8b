// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "accel/image.hpp"
#include "base/config_keys.hpp"
#include "base/format.hpp"
#include "host/link.hpp"
#include "model/tracer.hpp"
#include "scene/ray.hpp"

namespace ti::host {

/// What a `ti_top` says of itself.
struct Machine {
  std::uint32_t digest = 0;  ///< of the keys of its configuration
  Format format;             ///< without its reciprocal
  int cores = 1;
  int streams = 1;
  TriangleTest triangle_test = TriangleTest::kLocal;
  bool any_hit = true;   ///< whether rays may end at any hit
  bool counters = true;  ///< whether it counts
  bool snapshot = false;
  int line_bytes = 64;
  int addr_bits = 32;
};

/// What has gone through a `ti_top` since its reset.
struct Tally {
  std::uint64_t rays = 0;  ///< taken
  std::uint64_t hits = 0;  ///< given, whatever their status
  std::uint32_t invalid_rays = 0;
  std::uint32_t memory_errors = 0;
  std::uint32_t watchdogs = 0;
};

/// The driver of one `ti_top` (docs/units/ti_top.md): scene, rays, hits and counters. One thread at
/// a time. The link must outlive it.
class Device {
 public:
  /// Throws `Error` when there is no `ti_top` at the other end, or one whose registers this driver
  /// does not know.
  explicit Device(Link& link);

  [[nodiscard]] const Machine& machine() const { return machine_; }

  /// Puts an image at the start of the link's memory and makes it the scene: drains, writes the
  /// memory, flushes all caches. Throws `Error` when the image is for another format or test, or
  /// ends beyond the addresses of the machine.
  void load(const Image& image);

  /// Traces rays of one kind, `Ray::any` of the first, in an equal part on each stream; the hits in
  /// the order of the rays. Counters count meanwhile. Throws `Error` when a hit is missing, comes
  /// twice or belongs to no ray.
  [[nodiscard]] std::vector<HitBits> trace(std::span<const Ray> rays);

  /// Takes no more rays and waits until those inside are out. `trace` takes rays again.
  void drain();
  /// Forgets all lines of all caches, behind the rays that were taken before.
  void flush();

  [[nodiscard]] Tally tally();
  /// The bits of IRQ_STATUS (docs/registers.md); `clear_irq` clears those that are 1 in `bits`, and
  /// those of `enable_irq` alone raise the interrupt.
  [[nodiscard]] std::uint32_t irq_status();
  void clear_irq(std::uint32_t bits);
  void enable_irq(std::uint32_t bits);

  /// A counter by the numbers of docs/counters.md, since the reset; of the last `snapshot` where
  /// the machine has them.
  [[nodiscard]] std::uint64_t counter(int core, int unit, int event);
  void snapshot();

 private:
  [[nodiscard]] std::uint64_t read_long(std::uint32_t low);
  void write_long(std::uint32_t low, std::uint64_t value);
  void wait(std::uint32_t address, std::uint32_t mask, std::uint32_t value);

  Link& link_;
  Machine machine_;
};

}  // namespace ti::host
