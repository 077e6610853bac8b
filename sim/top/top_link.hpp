// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "Vti_top.h"
#include "engine/engine.hpp"
#include "host/link.hpp"
#include "memory.hpp"
#include "verilated.h"
#include "waves.hpp"

namespace ti::sim {

/// The verilated `ti_top` with a memory behind its read ports. Time passes only in calls; all
/// clocks are one.
class TopLink final : public host::Link {
 public:
  /// A machine after its reset, with `bytes` of memory at `Memory::kBase`.
  TopLink(std::size_t bytes, const RtlOptions& options);
  ~TopLink() override;
  TopLink(const TopLink&) = delete;
  TopLink& operator=(const TopLink&) = delete;

  [[nodiscard]] std::uint32_t read(std::uint32_t address) override;
  void write(std::uint32_t address, std::uint32_t value) override;
  [[nodiscard]] std::uint64_t base() const override { return Memory::kBase; }
  void store(std::uint64_t address, std::span<const std::uint8_t> bytes) override;
  void exchange(std::span<host::Packet> packets) override;

  /// What the memory did.
  [[nodiscard]] const Memory& memory() const { return *memory_; }
  /// Cycles in which packets were on their way.
  [[nodiscard]] std::uint64_t cycles() const { return cycles_; }

 private:
  void cycle();
  [[nodiscard]] bool stall();
  void check(std::uint32_t address, std::uint32_t response) const;

  RtlOptions options_;
  std::mt19937_64 random_;
  std::vector<std::uint8_t> bytes_;
  std::unique_ptr<Memory> memory_;
  VerilatedContext context_;
  Waves<Vti_top> waves_;
  std::unique_ptr<Vti_top> top_;
  std::uint64_t cycles_ = 0;
};

}  // namespace ti::sim
