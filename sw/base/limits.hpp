// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/error.hpp"

namespace ti {

/// Most rays, and most pixels, that are held at a time. A ray, its hits and what judges them take
/// about 110 bytes, so that these fit in 8 GiB.
constexpr std::size_t kMaxRays = std::size_t{1} << 26;

/// Most pixels on a side of a picture; keeps every size inside the PNG writer below 2^31.
constexpr int kMaxSide = 16384;

/// Most frames of an animation.
constexpr int kMaxFrames = 100000;

/// Throws `Error` when an animation has more frames than that; `what` starts its sentence.
inline void check_frames(const std::string& what, double frames) {
  if (frames <= kMaxFrames) return;
  throw Error(fmt::format("{}: its animation has more than {} frames; take fewer a second", what,
                          kMaxFrames));
}

/// Throws `Error` when `a` * `b` rays are more than `kMaxRays`; `what` starts its sentence.
inline void check_ray_count(const std::string& what, std::uint64_t a, std::uint64_t b = 1) {
  if (b == 0 || a <= kMaxRays / b) return;
  throw Error(
      fmt::format("{}: more than {} rays (2^26, about 7 GB) do not fit in one run; ask for "
                  "fewer, or for a smaller picture",
                  what, kMaxRays));
}

}  // namespace ti
