// SPDX-License-Identifier: Apache-2.0
//
// Points of a scene are `glm` vectors. `Vec3` is for work that goes axis by axis, and for numbers
// that glm does not know.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <glm/vec3.hpp>

namespace ti {

/// Three values, [0] = x.
template <class T>
using Vec3 = std::array<T, 3>;

/// A point whose axes are worked on one by one.
using Point = Vec3<double>;

[[nodiscard]] inline Point point_of(const glm::vec3& p) { return {p.x, p.y, p.z}; }

template <class T, glm::qualifier Q>
[[nodiscard]] bool finite(const glm::vec<3, T, Q>& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

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

}  // namespace ti
