// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace ti {

/// A picture of counts, one a pixel.
struct HeatMap {
  std::string png;
  double top = 0.0;  ///< the count that has the brightest colour, as have all above it
};

/// Counts from 0 to that of the 999th of 1000 pixels, in the colours of viridis: dark blue, green,
/// yellow. `per_pixel` holds the sum of `spp` rays a pixel, row by row from the top.
[[nodiscard]] HeatMap heat_map(std::span<const std::uint64_t> per_pixel, int spp, int width,
                               int height);

}  // namespace ti
