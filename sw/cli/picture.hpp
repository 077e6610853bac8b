// SPDX-License-Identifier: Apache-2.0
//
// The parts of `render`.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cli/traced_run.hpp"
#include "render/moved_region.hpp"

namespace ti {

struct Size {
  int width, height;

  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

/// Throws `Error` for anything but WIDTHxHEIGHT in the limits.
[[nodiscard]] Size parse_size(const std::string& text);

/// Adds a picture of a count a pixel, of `samples` rays each.
void add_heat_map(Files& files, const char* what, const std::vector<std::uint64_t>& per_pixel,
                  int samples, const Size& size);

/// The tiles of 8x8 pixels of a picture, and the rays on which each depends.
class Tiles {
 public:
  explicit Tiles(const Size& size);

  [[nodiscard]] std::size_t count() const { return rays_.size(); }
  [[nodiscard]] std::size_t of(std::uint32_t pixel) const;

  /// Whether each tile has a ray that may meet what moved.
  [[nodiscard]] std::vector<std::uint8_t> met(const MovedRegion& region) const;

  void forget(std::size_t tile) { rays_[tile].clear(); }
  void add(std::uint32_t pixel, const Ray& cut) { rays_[of(pixel)].push_back(cut); }

 private:
  Size size_;
  std::size_t across_;
  std::vector<std::vector<Ray>> rays_;
};

/// What paths are traced on: a session, in the waves that were asked for. Counts for each pixel.
class Tracing {
 public:
  /// With `tiles` it remembers the rays of each.
  Tracing(const Arguments& arguments, std::size_t pixels, Report& report, Tiles* tiles)
      : waves_(arguments.waves),
        keep_rays_(arguments.dump),
        report_(report),
        tiles_(tiles),
        steps_(pixels),
        tests_(pixels) {}

  /// The hits of rays in a session.
  std::vector<Hit> trace(Session& session, std::span<const Ray> rays,
                         std::span<const std::uint32_t> pixels);

  [[nodiscard]] const std::vector<std::uint64_t>& steps() const { return steps_; }
  [[nodiscard]] const std::vector<std::uint64_t>& tests() const { return tests_; }
  [[nodiscard]] const std::vector<Ray>& rays() const { return rays_; }

 private:
  int waves_;
  bool keep_rays_;
  Report& report_;
  Tiles* tiles_;
  std::vector<std::uint64_t> steps_;
  std::vector<std::uint64_t> tests_;
  std::vector<Ray> rays_;
};

}  // namespace ti
