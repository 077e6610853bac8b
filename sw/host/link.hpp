// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ti::host {

/// 32 bytes of a stream: eight words, lowest first. A ray is origin, tmin, direction, tmax, a value
/// of the number format each; a hit is the ray's number, primitive, t, u, v, status, steps, 0.
using Beat = std::array<std::uint32_t, 8>;

/// Rays that go to a stream as one packet, and the hits that come back, in any order.
struct Packet {
  std::vector<Beat> rays;
  std::vector<Beat> hits;
};

/// The way to one `ti_top`: its registers, its streams, and the memory that it reads. A simulation
/// is one (`sim/top`), a board another (`UioLink`); `Device` sees no difference.
class Link {
 public:
  virtual ~Link() = default;

  /// The register at a byte address; throws `Error` where there is none.
  [[nodiscard]] virtual std::uint32_t read(std::uint32_t address) = 0;
  virtual void write(std::uint32_t address, std::uint32_t value) = 0;

  /// Where the memory that the host may fill begins.
  [[nodiscard]] virtual std::uint64_t base() const = 0;

  /// Copies bytes to an address that the engine reads from; throws `Error` where no memory is.
  virtual void store(std::uint64_t address, std::span<const std::uint8_t> bytes) = 0;

  /// Sends a packet to each stream, none to one whose packet is empty, and waits for all hits.
  /// Throws `Error` when they do not come.
  virtual void exchange(std::span<Packet> packets) = 0;
};

}  // namespace ti::host
