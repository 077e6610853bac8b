// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "memory.hpp"

namespace ti::sim {

struct DramSettings {
  int ports = 1;
  int line_bytes = 64;     ///< 32, 64 or 128
  double clock_mhz = 500;  ///< of the engine
  std::uint64_t error_every = 0;
  std::uint64_t shuffle_seed = 0;  ///< 0: in the order in which lines come from the DRAM
};

/// The DRAM of gddr3.ini, by DRAMsim3, behind all ports together; its clock is its own.
///
/// A port has a queue of `kPortQueue` requests, whose first one goes to its channel when that has
/// room, the oldest of the ports first. Requests for one line that wait together in a channel share
/// a burst. Lines that do not touch the image are answered with an error and leave the DRAM alone;
/// so that each n-th line can be an error, as the settings say, it is read and then spoilt.
///
/// Throws `Error` in a build without DRAMsim3 (no_dram.cpp).
[[nodiscard]] std::unique_ptr<Memory> make_dram_memory(std::span<const std::uint8_t> image,
                                                       const DramSettings& settings);

constexpr int kPortQueue = 8;

}  // namespace ti::sim
