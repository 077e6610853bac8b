// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace ti {

using Point = std::array<double, 3>;
using Corners = std::array<Point, 3>;

/// Axis-parallel box, closed.
struct Box {
  Point lo{};
  Point hi{};

  /// The box moved outward by `distance` on all sides.
  [[nodiscard]] Box grown(double distance) const {
    Box box = *this;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lo[axis] -= distance;
      box.hi[axis] += distance;
    }
    return box;
  }

  [[nodiscard]] double half_area() const {
    const double x = hi[0] - lo[0];
    const double y = hi[1] - lo[1];
    const double z = hi[2] - lo[2];
    return x * y + y * z + z * x;
  }
};

/// Bounds of the part of `triangle` that lies in `box` (Sutherland and Hodgman 1974, in double);
/// false when no part does.
///
/// Each new corner is off by a few double ulps of the largest coordinate, so callers grow `box` by
/// more than that.
[[nodiscard]] bool clipped_bounds(const Corners& triangle, const Box& box, Box& bounds);

}  // namespace ti
