// SPDX-License-Identifier: Apache-2.0
#include "cli/picture.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "base/parallel.hpp"
#include "render/heat_map.hpp"

namespace ti {

namespace {

constexpr std::size_t kTile = 8;  ///< pixels on a side

}  // namespace

Size parse_size(const std::string& text) {
  int width = 0;
  int height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 1 ||
      height < 1 || width > kMaxSide || height > kMaxSide) {
    throw Error(
        fmt::format("SIZE={}: give a size as WIDTHxHEIGHT, each from 1 to {}, such as 256x256",
                    text, kMaxSide));
  }
  return {width, height};
}

void add_heat_map(Files& files, const char* what, const std::vector<std::uint64_t>& per_pixel,
                  int samples, const Size& size) {
  HeatMap map = heat_map(per_pixel, samples, size.width, size.height);
  fmt::print("{0}.png: {0} a sample of a pixel, from 0 (dark) to {1:.0f} and more (bright)\n", what,
             map.top);
  files.add(fmt::format("{}.png", what), std::move(map.png));
}

Tiles::Tiles(const Size& size)
    : size_(size),
      across_((static_cast<std::size_t>(size.width) + kTile - 1) / kTile),
      rays_(across_ * ((static_cast<std::size_t>(size.height) + kTile - 1) / kTile)) {}

std::size_t Tiles::of(std::uint32_t pixel) const {
  const auto width = static_cast<std::size_t>(size_.width);
  return pixel / width / kTile * across_ + pixel % width / kTile;
}

std::vector<std::uint8_t> Tiles::met(const MovedRegion& region) const {
  std::vector<std::uint8_t> out(rays_.size());
  parallel_pieces(rays_.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      out[i] = std::any_of(rays_[i].begin(), rays_[i].end(),
                           [&region](const Ray& ray) { return region.met_by(ray); })
                   ? 1
                   : 0;
  });
  return out;
}

std::vector<Hit> Tracing::trace(Session& session, std::span<const Ray> rays,
                                std::span<const std::uint32_t> pixels) {
  const std::size_t before = report_.total.hits.size();
  check_ray_count("this picture with its effects", before + rays.size());
  trace_waves(session, rays, waves_, report_);
  const Wave& total = report_.total;
  for (std::size_t i = before; i < total.hits.size(); ++i) {
    const std::uint32_t pixel = pixels[i - before];
    steps_[pixel] += total.hits[i].steps;
    if (!total.tests.empty()) tests_[pixel] += total.tests[i];
    if (tiles_ != nullptr) tiles_->add(pixel, cut_at(rays[i - before], total.hits[i]));
  }
  if (keep_rays_) rays_.insert(rays_.end(), rays.begin(), rays.end());
  const auto first = total.hits.begin() + static_cast<std::ptrdiff_t>(before);
  return {first, total.hits.end()};
}

}  // namespace ti
