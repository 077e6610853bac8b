// SPDX-License-Identifier: Apache-2.0
#include "accel/scene_scale.hpp"

#include <algorithm>
#include <cmath>

namespace ti {
namespace {

/// Places of room that origins of rays get in the window of Woop's test, where the format has them:
/// up to 2^10 sizes of the scene away.
constexpr int kFar = 10;

int floor_of(double x) { return static_cast<int>(std::floor(x)); }
int ceil_of(double x) { return static_cast<int>(std::ceil(x)); }

/// Woop's test of a triangle that a ray hits. Places are below 2^a, so they differ by less than
/// E = 2^(a+1) on each axis; the way z of a corner along the ray is below 2^k E for an origin that
/// is 2^k times as far away. The shear is at most 1.
/// - Corners are seen within 2 E of the ray: products are at most 4 E^2 and weights, differences of
///   two, below 2^(2a+5), a number where 2a + 5 <= bias.
/// - Weights are brought to [2, 4) (`model::level`), so det is in [2, 12) and has an inverse. The
///   sum of weights times ways is at most 12 2^k E < 2^(a+k+5), a number where a + k <= bias - 4.
/// - The smallest triangle has edges of e = 2^(a-1-M), a unit in the last place of the largest
///   coordinates. Its weights add up to e^2 and keep their bits where e^2 >= 2^(1-bias).
ScaleWindow woop_window(const Format& format) {
  const int bias = format.bias();
  const int near = std::min(floor_of((bias - 5) / 2.0), bias - 4);
  const int far = std::min(near, bias - 4 - kFar);
  const int low = std::min(near, ceil_of(format.frac_bits + 1 + (1 - bias) / 2.0));
  return {low, std::max(low, far)};
}

/// Shevtsov's test, with n.p or a vertex. Its constants are an edge over a component of the normal,
/// from about 1 / E to 1 / e, and |n_u|, |n_v| <= 1 after the division.
/// - dett is at most 3 E, n.p too; du dett - au det at most 6 E |d| < 2^(a+4) for |d| <= 1, below
///   the largest number where a <= bias - 4. Then 1 / E is a normal number too.
/// - 1 / e = 2^(M+1-a), e a unit in the last place of the largest coordinates, is below 2^bias
/// where
///   a >= M + 2 - bias; then e is a normal number too.
ScaleWindow plane_window(const Format& format) {
  const int high = format.bias() - 4;
  return {std::min(high, format.frac_bits + 2 - format.bias()), high};
}

}  // namespace

ScaleWindow scale_window(const Format& format, TestKind test) {
  return test == TestKind::Woop ? woop_window(format) : plane_window(format);
}

int scene_scale(double largest, const Format& format, TestKind test) {
  if (!std::isfinite(largest) || largest == 0.0) return 0;
  const ScaleWindow window = scale_window(format, test);
  int size = 0;
  (void)std::frexp(largest, &size);
  const bool inside = window.low <= size && size <= window.high;
  return inside ? 0 : window.middle() - size;
}

double largest_coordinate(const Mesh& mesh) {
  double largest = 0.0;
  for (const auto& corners : mesh.triangles) {
    for (const std::uint32_t corner : corners) {
      if (corner >= mesh.vertices.size()) continue;  // the builder names it
      for (int axis = 0; axis < 3; ++axis) {
        const double x = std::abs(double{mesh.vertices[corner][axis]});
        if (std::isfinite(x)) largest = std::max(largest, x);
      }
    }
  }
  return largest;
}

double largest_coordinate(const Box& box) {
  double largest = 0.0;
  for (const Point& corner : {box.lo, box.hi}) {
    for (const double x : corner) {
      if (std::isfinite(x)) largest = std::max(largest, std::abs(x));
    }
  }
  return largest;
}

}  // namespace ti
