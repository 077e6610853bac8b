// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "engine/engine.hpp"
#include "ti_config.hpp"

namespace ti::sim {

/// Cycles without a ray in or out or an answer of the memory after which the rays inside count as
/// lost: a ray that finds all its nodes in the caches shows nothing until the watchdog ends it.
[[nodiscard]] inline std::uint64_t patience(const RtlOptions& options) {
  constexpr double kCyclesPerStep = 256.0;
  const double quiet = 100'000.0 + kCyclesPerStep * config::kWatchdogSteps +
                       2.0 * options.memory_latency +
                       2.0 * config::kLineBytes / options.memory_bytes_per_cycle;
  const double share = options.stall_seed != 0 ? options.stall_share : 0.0;
  return static_cast<std::uint64_t>(quiet / (1.0 - share));
}

}  // namespace ti::sim
