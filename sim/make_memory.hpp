// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "engine/engine.hpp"
#include "memory.hpp"

namespace ti::sim {

/// The memory that the options name, with the bytes of an image and a port a core. Throws `Error`
/// for a DRAM in a build without DRAMsim3.
[[nodiscard]] std::unique_ptr<Memory> make_memory(std::span<const std::uint8_t> image,
                                                  const RtlOptions& options);

}  // namespace ti::sim
