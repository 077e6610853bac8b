// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "host/mapped_device.hpp"

namespace ti::host {

/// An AXI DMA core of Xilinx in direct register mode (PG021), behind a UIO device: MM2S sends the
/// rays of a stream, S2MM receives its hits, whose interrupt is that of the device.
class AxiDma {
 public:
  using Clock = std::chrono::steady_clock;

  /// `length_bits` is what the core was built for. With `interrupts` false it is asked again and
  /// again.
  AxiDma(const std::filesystem::path& device, std::uint64_t bytes, int length_bits,
         bool interrupts);

  /// Begins a transfer of `bytes` bytes from `rays`, and one of up to as many to `hits`. Resets the
  /// core before. Throws `Error` for a transfer that is too long for it.
  void start(std::uint64_t rays, std::uint64_t hits, std::uint64_t bytes, Clock::time_point end);

  /// Waits for TLAST of the hits; their bytes. Throws `Error` when the core reports one, or at
  /// `end`.
  [[nodiscard]] std::uint32_t finish(Clock::time_point end);

 private:
  void check_errors() const;
  [[noreturn]] void time_out(const char* what) const;

  MappedDevice registers_;
  std::uint64_t most_;  // bytes of a transfer
  bool interrupts_;
};

}  // namespace ti::host
