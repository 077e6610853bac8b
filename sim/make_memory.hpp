// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/engine.hpp"
#include "memory.hpp"

namespace ti::sim {

/// The memory that the options name, with an image and a port a core. Throws `Error` for a DRAM in
/// a build without DRAMsim3.
[[nodiscard]] std::unique_ptr<Memory> make_memory(const Image& image, const RtlOptions& options);

}  // namespace ti::sim
