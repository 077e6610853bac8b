// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <span>

namespace ti {

/// Writes linear colours, row by row from the top, as an 8-bit sRGB PNG (clamped to [0, 1]).
void save_png(const std::filesystem::path& path, std::span<const glm::vec3> linear, int width,
              int height);

}  // namespace ti
