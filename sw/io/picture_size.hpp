// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>

#include "base/error.hpp"
#include "base/limits.hpp"

namespace ti {

/// Throws `Error` unless `values`, three a pixel, fill a picture of `width` x `height`, each 1 to
/// `kMaxSide`, with at most `kMaxRays` pixels.
inline void check_picture(std::size_t values, int width, int height) {
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    throw Error(fmt::format("a picture of {}x{} cannot be written; choose 1 to {} a side", width,
                            height, kMaxSide));
  }
  check_ray_count(fmt::format("a picture of {}x{}", width, height),
                  static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height));
  if (values != 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    throw Error(fmt::format("{} values do not fill {}x{} pixels; give three a pixel", values, width,
                            height));
  }
}

}  // namespace ti
