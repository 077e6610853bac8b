// SPDX-License-Identifier: Apache-2.0
#include "make_memory.hpp"

#include <cstdint>
#include <limits>

#include "base/error.hpp"
#include "dram/dram_memory.hpp"
#include "fixed_memory.hpp"
#include "ti_config.hpp"

namespace ti::sim {

std::unique_ptr<Memory> make_memory(std::span<const std::uint8_t> image,
                                    const RtlOptions& options) {
  const bool loses = options.lose_every != 0 || options.late_every != 0;
  if (options.memory == MemoryKind::Dram && (loses || options.spoil_every != 0))
    throw Error("answers are lost, late or spoilt by --mem fixed and ideal alone");
  if (loses && config::kReadTimeout == 0) {
    throw Error(
        "a ray whose answer is lost or late ends only where read_timeout is not 0: give "
        "SET=read_timeout=1000");
  }
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
                            .lose_every = options.lose_every,
                            .late_every = options.late_every,
                            .late_cycles = std::uint64_t{4} * config::kReadTimeout,
                            .spoil_every = options.spoil_every,
                            .shuffle_seed = options.stall_seed});
}

}  // namespace ti::sim
