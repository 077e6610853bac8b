// SPDX-License-Identifier: Apache-2.0
#include "accel/clip.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace ti {
namespace {

/// A convex polygon; a triangle cut by six planes has at most nine corners.
struct Polygon {
  std::array<Point, 9> corners;
  std::size_t count = 0;

  void add(const Point& corner) { corners[count++] = corner; }
};

/// Where the edge from `a` to `b` meets the plane; never outside the edge's own bounds.
Point meet(const Point& a, const Point& b, std::size_t axis, double plane) {
  const double share = (plane - a[axis]) / (b[axis] - a[axis]);
  Point point;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [lo, hi] = std::minmax(a[i], b[i]);
    point[i] = std::clamp(a[i] + share * (b[i] - a[i]), lo, hi);
  }
  point[axis] = plane;
  return point;
}

/// Keeps the part of `in` on the side of the plane where sign * (x - plane) <= 0.
void cut(const Polygon& in, std::size_t axis, double plane, double sign, Polygon& out) {
  out.count = 0;
  const Point* before = &in.corners[in.count - 1];
  bool before_inside = sign * (*before)[axis] <= sign * plane;
  for (std::size_t i = 0; i < in.count; ++i) {
    const Point* corner = &in.corners[i];
    const bool inside = sign * (*corner)[axis] <= sign * plane;
    if (inside != before_inside) out.add(meet(*before, *corner, axis, plane));
    if (inside) out.add(*corner);
    before = corner;
    before_inside = inside;
  }
}

}  // namespace

bool clipped_bounds(const Corners& triangle, const Box& box, Box& bounds) {
  Polygon first;
  Polygon second;
  for (const glm::vec3& corner : triangle) first.add(point_of(corner));
  Polygon* polygon = &first;
  Polygon* spare = &second;

  for (std::size_t axis = 0; axis < 3; ++axis) {
    double lo = polygon->corners[0][axis];
    double hi = lo;
    for (std::size_t i = 1; i < polygon->count; ++i) {
      lo = std::min(lo, polygon->corners[i][axis]);
      hi = std::max(hi, polygon->corners[i][axis]);
    }
    if (lo > box.hi[axis] || hi < box.lo[axis]) return false;
    if (lo < box.lo[axis]) {
      cut(*polygon, axis, box.lo[axis], -1.0, *spare);
      std::swap(polygon, spare);
    }
    if (hi > box.hi[axis] && polygon->count > 0) {
      cut(*polygon, axis, box.hi[axis], 1.0, *spare);
      std::swap(polygon, spare);
    }
    if (polygon->count == 0) return false;
  }

  bounds.lo = bounds.hi = polygon->corners[0];
  for (std::size_t i = 1; i < polygon->count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.lo[axis] = std::min(bounds.lo[axis], polygon->corners[i][axis]);
      bounds.hi[axis] = std::max(bounds.hi[axis], polygon->corners[i][axis]);
    }
  }
  return true;
}

}  // namespace ti
