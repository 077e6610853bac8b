// SPDX-License-Identifier: Apache-2.0
#include "make_memory.hpp"

#include <limits>

#include "dram/dram_memory.hpp"
#include "fixed_memory.hpp"
#include "ti_config.hpp"

namespace ti::sim {

std::unique_ptr<Memory> make_memory(std::span<const std::uint8_t> image,
                                    const RtlOptions& options) {
  if (options.memory == MemoryKind::Dram) {
    return make_dram_memory(image, {.ports = config::kCores,
                                    .line_bytes = config::kLineBytes,
                                    .clock_mhz = options.clock_mhz,
                                    .error_every = options.error_every,
                                    .shuffle_seed = options.stall_seed});
  }
  const bool ideal = options.memory == MemoryKind::Ideal;
  constexpr double kNoLimit = std::numeric_limits<double>::infinity();
  return std::make_unique<FixedMemory>(
      image,
      FixedMemory::Settings{.ports = config::kCores,
                            .latency = ideal ? 1 : options.memory_latency,
                            .bytes_per_cycle = ideal ? kNoLimit : options.memory_bytes_per_cycle,
                            .line_bytes = config::kLineBytes,
                            .error_every = options.error_every,
                            .shuffle_seed = options.stall_seed});
}

}  // namespace ti::sim
