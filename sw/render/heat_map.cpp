// SPDX-License-Identifier: Apache-2.0
#include "render/heat_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "io/png.hpp"

namespace ti {
namespace {

/// Viridis (Smith and van der Walt 2015, CC0) at nine even places; between them it is linear.
constexpr std::array<std::array<double, 3>, 9> kViridis{{{68, 1, 84},
                                                         {71, 44, 122},
                                                         {59, 81, 139},
                                                         {44, 113, 142},
                                                         {33, 144, 141},
                                                         {39, 173, 129},
                                                         {92, 200, 99},
                                                         {170, 220, 50},
                                                         {253, 231, 37}}};

}  // namespace

HeatMap heat_map(std::span<const std::uint64_t> per_pixel, int spp, int width, int height) {
  std::vector<std::uint64_t> sorted(per_pixel.begin(), per_pixel.end());
  std::sort(sorted.begin(), sorted.end());
  const std::uint64_t top = sorted.empty() ? 0 : sorted[(sorted.size() - 1) * 999 / 1000];

  std::vector<unsigned char> rgb;
  rgb.reserve(3 * per_pixel.size());
  for (const std::uint64_t count : per_pixel) {
    const double share =
        top == 0 ? 0.0 : std::min(1.0, static_cast<double>(count) / static_cast<double>(top));
    const double place = share * (kViridis.size() - 1);
    const auto low = std::min(static_cast<std::size_t>(place), kViridis.size() - 2);
    const double part = place - static_cast<double>(low);
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = kViridis[low][c] + part * (kViridis[low + 1][c] - kViridis[low][c]);
      rgb.push_back(static_cast<unsigned char>(std::lround(value)));
    }
  }
  return {png_of(rgb, width, height), static_cast<double>(top) / spp};
}

}  // namespace ti
