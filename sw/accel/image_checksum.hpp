// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace ti {

/// CRC-32 (zlib) of an image with its checksum word taken as 0; `bytes` has at least a header.
[[nodiscard]] std::uint32_t image_checksum(std::span<const std::uint8_t> bytes);

}  // namespace ti
