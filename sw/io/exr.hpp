// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <string>

namespace ti {

/// The bytes of an OpenEXR picture of linear colours, rows from the top: one part of scan lines,
/// channels B, G, R of float32, which keep every bit, by lossless ZIP in blocks of 16 lines. No
/// chromaticities are written, so colours are of Rec. 709 as the format's own default is. Throws
/// `Error` when the colours do not fill `width` x `height`, each 1 to `kMaxSide`, or are more than
/// `kMaxRays`.
[[nodiscard]] std::string exr_of(std::span<const glm::vec3> linear, int width, int height);

}  // namespace ti
