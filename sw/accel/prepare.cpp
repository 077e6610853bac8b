// SPDX-License-Identifier: Apache-2.0
#include "accel/prepare.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "base/vec.hpp"

namespace ti {
namespace {

/// x + y as value + error, exactly (Knuth).
struct Pair {
  double value;
  double error;
};

Pair exact_sum(double x, double y) {
  const double sum = x + y;
  const double y_part = sum - x;
  return {sum, (x - (sum - y_part)) + (y - y_part)};
}

Pair exact_product(double x, double y) {
  const double product = x * y;
  return {product, std::fma(x, y, -product)};
}

/// A sum without rounding: Shewchuk's growing expansion, whose terms are all zero exactly when the
/// sum is. A double has room for every product of two differences of floats, so nothing overflows
/// or underflows.
class ExactSum {
 public:
  void add(double term) {
    for (std::size_t i = 0; i < count_; ++i) {
      const Pair pair = exact_sum(term, terms_[i]);
      terms_[i] = pair.error;
      term = pair.value;
    }
    terms_[count_++] = term;
  }

  [[nodiscard]] bool is_zero() const {
    for (std::size_t i = 0; i < count_; ++i) {
      if (terms_[i] != 0.0) return false;
    }
    return true;
  }

 private:
  std::array<double, 16> terms_{};
  std::size_t count_ = 0;
};

void add_product(ExactSum& sum, Pair x, Pair y, double sign) {
  for (const double factor : {x.value, x.error}) {
    for (const double other : {y.value, y.error}) {
      const Pair product = exact_product(sign * factor, other);
      sum.add(product.value);
      sum.add(product.error);
    }
  }
}

/// ab - cd with an error of at most 1.5 ulp (Kahan; Jeannerod, Louvet, Muller 2013).
double difference_of_products(double a, double b, double c, double d) {
  const double cd = c * d;
  const double error = std::fma(-c, d, cd);
  return std::fma(a, b, -cd) + error;
}

Point edge(const Corners& corners, std::size_t end) {
  const Point a = point_of(corners[0]);
  const Point b = point_of(corners[end]);
  return {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
}

/// Computes the records; false when a constant is not finite in the format.
bool make_records(const Corners& corners, Format format, TestKind test, ImagePlane& plane,
                  ImageBary& bary, RangeLosses& losses) {
  const Point first = edge(corners, 1);
  const Point second = edge(corners, 2);
  const Point normal{difference_of_products(first[1], second[2], first[2], second[1]),
                     difference_of_products(first[2], second[0], first[0], second[2]),
                     difference_of_products(first[0], second[1], first[1], second[0])};
  std::size_t w = 0;
  if (std::abs(normal[1]) > std::abs(normal[w])) w = 1;
  if (std::abs(normal[2]) > std::abs(normal[w])) w = 2;
  const std::size_t u = (w + 1) % 3;
  const std::size_t v = (w + 2) % 3;

  bool finite = true;
  const auto rounded = [&](double value) {
    const std::uint32_t bits = round_to_bits(format, value);
    const double stored = value_of_bits(format, bits);
    losses.add(format, value, stored);
    finite = finite && std::isfinite(stored);
    return bits;
  };
  const Point origin = point_of(corners[0]);
  plane.nu = rounded(normal[u] / normal[w]);
  plane.nv = rounded(normal[v] / normal[w]);
  plane.pu = rounded(origin[u]);
  plane.pv = rounded(origin[v]);
  const double np =
      std::fma(normal[u] / normal[w], origin[u], normal[v] / normal[w] * origin[v]) + origin[w];
  plane.pw = rounded(test == TestKind::Np ? np : origin[w]);
  plane.axis = static_cast<std::uint32_t>(w);
  plane.prim = 0;
  plane.reserved = 0;
  bary.e0u = rounded(first[u] / normal[w]);
  bary.e0v = rounded(first[v] / normal[w]);
  bary.e1u = rounded(second[u] / normal[w]);
  bary.e1v = rounded(second[v] / normal[w]);
  return finite;
}

bool finite(const Corners& corners) {
  return ti::finite(corners[0]) && ti::finite(corners[1]) && ti::finite(corners[2]);
}

/// Whether a triangle names each vertex.
std::vector<std::uint8_t> named_vertices(const Mesh& mesh) {
  std::vector<std::uint8_t> named(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t index : mesh.triangles[i]) {
      if (index >= named.size()) {
        throw Error("mesh: triangle " + std::to_string(i) + " names vertex " +
                    std::to_string(index) + " of " + std::to_string(named.size()) +
                    ": repair the mesh file");
      }
      named[index] = 1;
    }
  }
  return named;
}

/// How many different places there are.
std::size_t count_places(std::vector<Vec3<float>>& places) {
  std::sort(places.begin(), places.end());
  return static_cast<std::size_t>(std::unique(places.begin(), places.end()) - places.begin());
}

/// The vertices of a mesh, scaled and rounded; counts what that does to those that triangles name.
std::vector<glm::vec3> rounded_vertices(const Mesh& mesh, const ScaledFormat& format,
                                        RangeAudit& range) {
  const std::vector<std::uint8_t> named = named_vertices(mesh);
  std::vector<glm::vec3> rounded(mesh.vertices.size());
  std::vector<Vec3<float>> before;
  std::vector<Vec3<float>> after;
  bool exact = true;
  for (std::size_t i = 0; i < rounded.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double given = std::ldexp(double{mesh.vertices[i][axis]}, format.scale);
      const double stored = round_to(format.numbers, given);
      rounded[i][axis] = static_cast<float>(stored) + 0.0F;  // + 0: no -0
      if (named[i] == 0) continue;
      exact = exact && given == stored;
      range.coordinates.add(format.numbers, given, stored);
      if (std::abs(stored) < format.numbers.least_normal())
        range.moved = std::max(range.moved, std::ldexp(std::abs(given - stored), -format.scale));
    }
    if (named[i] == 0 || !ti::finite(rounded[i])) continue;
    const glm::vec3& p = mesh.vertices[i];
    before.push_back({p.x + 0.0F, p.y + 0.0F, p.z + 0.0F});
    after.push_back({rounded[i].x, rounded[i].y, rounded[i].z});
  }
  if (!exact) range.merged = static_cast<std::uint32_t>(count_places(before) - count_places(after));
  return rounded;
}

}  // namespace

bool has_zero_area(const Corners& corners) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const Pair a = exact_sum(corners[1][u], -corners[0][u]);
    const Pair b = exact_sum(corners[2][v], -corners[0][v]);
    const Pair c = exact_sum(corners[1][v], -corners[0][v]);
    const Pair d = exact_sum(corners[2][u], -corners[0][u]);
    const double left = a.value * b.value;
    const double right = c.value * d.value;
    // Far from zero: the error of `left - right` is below 8 half ulps of its two terms.
    constexpr double kBound = 4.0 * std::numeric_limits<double>::epsilon();
    if (std::abs(left - right) > kBound * (std::abs(left) + std::abs(right))) return false;
    ExactSum sum;
    add_product(sum, a, b, 1.0);
    add_product(sum, c, d, -1.0);
    if (!sum.is_zero()) return false;
  }
  return true;
}

PreparedTriangles prepare_triangles(const Mesh& mesh, const ScaledFormat& format, TestKind test) {
  const bool constants = test != TestKind::Woop;
  PreparedTriangles prepared;
  prepared.corners.reserve(mesh.triangles.size());
  prepared.prims.reserve(mesh.triangles.size());
  prepared.planes.reserve(constants ? mesh.triangles.size() : 0);
  prepared.barys.reserve(constants ? mesh.triangles.size() : 0);
  const std::vector<glm::vec3> rounded = rounded_vertices(mesh, format, prepared.range);

  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Corners given = mesh.corners(i);
    Corners corners;
    for (std::size_t corner = 0; corner < 3; ++corner)
      corners[corner] = rounded[mesh.triangles[i][corner]];
    ImagePlane plane{};
    ImageBary bary{};
    if (!finite(corners)) {
      ++prepared.dropped_nonfinite;
      if (finite(given)) ++prepared.range.dropped_overflow;
    } else if (has_zero_area(corners)) {
      ++prepared.dropped_zero_area;
      if (!has_zero_area(given)) ++prepared.range.dropped_rounded;
    } else if (constants && !make_records(corners, format.numbers, test, plane, bary,
                                          prepared.range.constants)) {
      ++prepared.dropped_nonfinite;
      ++prepared.range.dropped_overflow;
    } else {
      plane.prim = static_cast<std::uint32_t>(i);
      prepared.corners.push_back(corners);
      prepared.prims.push_back(plane.prim);
      if (!constants) continue;
      prepared.planes.push_back(plane);
      prepared.barys.push_back(bary);
    }
  }
  return prepared;
}

}  // namespace ti
