// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <string>

namespace ti {

/// The bytes of an 8-bit PNG of linear colours, row by row from the top, encoded as sRGB (clamped
/// to [0, 1]). Throws `Error` when they do not fill `width` x `height`, each 1 to `kMaxSide`, or
/// are more than `kMaxRays`.
[[nodiscard]] std::string png_of(std::span<const glm::vec3> linear, int width, int height);

/// The same of red, green and blue as they stand in the file.
[[nodiscard]] std::string png_of(std::span<const unsigned char> rgb, int width, int height);

}  // namespace ti
