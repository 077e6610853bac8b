// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "accel/image.hpp"
#include "base/vec.hpp"
#include "model/ist2.hpp"
#include "model/rd.hpp"
#include "model/work.hpp"

namespace ti::model {

/// What IST1 leaves for IST2: the edge functions, each the weight of a corner, and the way of each
/// corner along z.
template <class F>
struct Edges {
  std::array<F, 3> weight, z;
};

/// ab - cd with each product rounded. It is never of the wrong sign, as rounding is monotone,
/// though it may be 0; fused with a product the difference would be: the two triangles of an edge
/// then fuse one product each, not the same.
template <class F>
[[nodiscard]] F difference_of_products(F a, F b, F c, F d) {
  return a * b - c * d;
}

/// The corners seen along the ray, and whether the ray passes between them; nothing when it does
/// not.
///
/// Bit-exact model of `ti_woop_pipe`. With A, B, C the corners less o: Ax = A.x - sx A.z, Ay = A.y
/// - sy A.z, and so on; U = Cx By - Cy Bx, V = Ax Cy - Ay Cx, W = Bx Ay - By Ax. A corner has the
/// same (x, y) in each of its triangles, and no weight has the wrong sign, only a false 0, which
/// counts as inside: no ray passes between two triangles.
template <class F>
[[nodiscard]] std::optional<Edges<F>> edge_functions(const std::array<Vec3<F>, 3>& corners,
                                                     const Vec3<F>& o, const Shear<F>& shear) {
  const std::size_t ix = (shear.z + 1) % 3;
  const std::size_t iy = (shear.z + 2) % 3;
  std::array<F, 3> x, y;
  Edges<F> edges;
  for (std::size_t k = 0; k < 3; ++k) {
    edges.z[k] = corners[k][shear.z] - o[shear.z];
    x[k] = (corners[k][ix] - o[ix]) - shear.sx * edges.z[k];
    y[k] = (corners[k][iy] - o[iy]) - shear.sy * edges.z[k];
  }
  bool above = false;
  bool below = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t b = (k + 1) % 3;
    const std::size_t c = (k + 2) % 3;
    edges.weight[k] = difference_of_products(x[c], y[b], y[c], x[b]);
    if (edges.weight[k].is_nan()) return std::nullopt;
    above = above || edges.weight[k] > F{};
    below = below || edges.weight[k] < F{};
  }
  if (above && below) return std::nullopt;
  return edges;
}

/// The weights times the power of two that puts the largest into [2, 4). What is then below the
/// least normal number is cut toward zero; three zeros, and weights with an infinity, stay as they
/// are. So neither the sum of weights, its reciprocal nor a product with a way leaves the range of
/// the format, however small or large the triangle is; and a mean of ways of
/// the least number keeps its sign, which it would not with weights of 1, 1/2 and 1/2.
///
/// Bit-exact model of `ti_woop_level`.
template <class F>
[[nodiscard]] std::array<F, 3> level(const std::array<F, 3>& weight) {
  std::array<double, 3> size{};
  double largest = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    size[k] = std::abs(double{weight[k].to_float()});
    largest = std::max(largest, size[k]);
  }
  if (largest == 0.0 || std::isinf(largest)) return weight;
  const int places = 1 - std::ilogb(largest);
  const double normal = std::ldexp(1.0, 1 - F::kBias);
  const double least = std::ldexp(normal, -F::kFracBits);
  std::array<F, 3> out;
  for (std::size_t k = 0; k < 3; ++k) {
    double value = std::ldexp(size[k], places);
    if (value < normal) value = F::modes().flush ? 0.0 : std::floor(value / least) * least;
    const F result = F::from_double(value);
    out[k] = weight[k].signbit() ? -result : result;
  }
  return out;
}

/// Distance and barycentric coordinates; nothing when t is not finite or less than 0.
///
/// Bit-exact model of `ti_woop_ist2`: with U, V, W brought to one size (`level`), t = ((U Az +
/// V Bz) + W Cz) * r * sz with r = 1 / ((U + V) + W).
template <class F>
[[nodiscard]] std::optional<Candidate<F>> pass_c(const Edges<F>& edges, F sz) {
  const auto [a, b, c] = level(edges.weight);
  const F r = reciprocal((a + b) + c);
  const F t = (((a * edges.z[0] + b * edges.z[1]) + c * edges.z[2]) * r) * sz;
  if (!t.is_finite() || t < F{}) return std::nullopt;
  return Candidate<F>{t, b * r, c * r};
}

/// The triangle records of an image and Woop's test of them. A test takes one pass in IST1, counted
/// as pass (a), and where the ray passes between the corners one in IST2, pass (c).
template <class F>
class WoopTest {
 public:
  static constexpr TestKind kKind = TestKind::Woop;

  /// Without `early_exit` each test goes on to IST2.
  WoopTest(const Image& image, bool early_exit) : early_exit_(early_exit) {
    records_.reserve(image.parts().triangle_count);
    for (std::uint32_t i = 0; i < image.parts().triangle_count; ++i) {
      const ImageCorners packed = image.corners(i);
      Record record{{}, packed.prim};
      for (std::size_t k = 0; k < 9; ++k)
        record.corners[k / 3][k % 3] = F::from_bits(packed.p[k / 3][k % 3]);
      records_.push_back(record);
    }
  }

  /// Number of records.
  [[nodiscard]] std::size_t size() const { return records_.size(); }
  /// Number of the triangle in the mesh.
  [[nodiscard]] std::uint32_t prim(std::uint32_t record) const { return records_[record].prim; }

  /// Nothing when the triangle is missed.
  [[nodiscard]] std::optional<Candidate<F>> test(std::uint32_t record, const FpRay<F>& ray,
                                                 const Clipped<F>& clipped, const TestRange<F>&,
                                                 Work& work) const {
    ++work.a_tests;
    const auto edges = edge_functions(records_[record].corners, ray.o, clipped.shear);
    if (edges || !early_exit_) ++work.c_tests;
    return edges ? pass_c(*edges, clipped.shear.sz) : std::nullopt;
  }

 private:
  struct Record {
    std::array<Vec3<F>, 3> corners;
    std::uint32_t prim;
  };
  std::vector<Record> records_;
  bool early_exit_;
};

}  // namespace ti::model
