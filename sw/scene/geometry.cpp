// SPDX-License-Identifier: Apache-2.0
#include "scene/geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "base/format_grid.hpp"
#include "base/vec.hpp"

namespace ti {

namespace {

using Triangle = std::array<glm::dvec3, 3>;

/// Triangle `hit.prim` of the mesh.
Triangle triangle_of(const Mesh& mesh, const Hit& hit) {
  const auto& corner = mesh.triangles.at(static_cast<std::size_t>(hit.prim));
  return {mesh.vertices[corner[0]], mesh.vertices[corner[1]], mesh.vertices[corner[2]]};
}

Surface surface_of(const Triangle& p, const Ray& ray, const Hit& hit) {
  const double u = hit.u;
  const double v = hit.v;
  const glm::dvec3 d = ray.d;
  Surface s;
  s.position = (1.0 - u - v) * p[0] + u * p[1] + v * p[2];
  const glm::dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
  const double length = glm::length(n);
  s.normal = length > 0.0 ? n / length : -glm::normalize(d);
  if (glm::dot(s.normal, d) > 0.0) s.normal = -s.normal;
  return s;
}

/// How far an origin must stand off the plane of its own triangle, along the unit normal n.
///
/// With r the largest relative error of an operation, L the longest extent of the triangle along an
/// axis, w the axis of the largest |n| and N = |n_u| + |n_v|, distances along n; second-order terms
/// are in the constants.
/// - The point. Its error is at most gamma_7 sum |b_i p_i| on each axis, projected on n (Pharr,
///   Jakob, Humphreys, "Physically Based Rendering", 4th edition, 6.8.4), were it interpolated in
///   the format. In double it is 2^-29 of that and 2^-50 |p_i| for 1 - u - v. The rest covers the
///   neighbours, whose vertices are rounded too. Errors of u and v move the point within the plane
///   only, as the three weights add up to 1.
/// - Rounding the origin to the format moves it by up to 2 r |o| on each axis, always to the side
/// of
///   n: it needs nothing.
/// - The sign of dett in pass (a). Its error is r (5 |nu au| + 5 |nv av| + 2 |aw|), where
///   |aw| <= |nu au| + |nv av| in the plane: 7 r N L.
/// - A grazing ray whose det comes out with the wrong sign. The error of det is
///   r (4 |nu du| + 4 |nv dv| + |dw|) and that of the rounded direction the same with 1, hence
///   7 r N D, D the largest |d|. Such a ray meets the plane after D t = offset / (7 r N). At
///   three times L, so 21 r N L, it has left the triangle by more than pass (b) can be wrong.
/// - Underflow adds less than 64 times the largest error of a result below the least normal number,
///   times 1 + L.
/// - Woop's test has the sign of t from the sum of weights times ways, which is n . (p - o), the
///   distance times twice the area. Underflow adds less than 64 times as much to it. It is divided
///   by the length of the direction at last, and must not vanish then, even of a plane through the
///   origin of space: 2^-10 r L.
double stand_off(const Triangle& p, const Hit& hit, const glm::dvec3& normal,
                 const ScaledFormat& engine) {
  const Format& format = engine.numbers;
  const double r = format.rounding_unit();
  const double gamma = kStandOffPoint * r / (1.0 - kStandOffPoint * r);
  constexpr double kWeightError = 0x1p-50;  // of a double 1 - u - v, and what follows from it
  constexpr double kUnderflow = 64.0;
  const double least = format.underflow_unit();
  const std::array<double, 3> weight{1.0 - hit.u - hit.v, hit.u, hit.v};
  const glm::dvec3 n = glm::abs(normal);
  glm::dvec3 error(0.0);
  for (std::size_t i = 0; i < 3; ++i) {
    error += (gamma * std::abs(weight[i]) + kWeightError) * glm::abs(p[i]);
  }
  const glm::dvec3 extent =
      glm::max(p[0], glm::max(p[1], p[2])) - glm::min(p[0], glm::min(p[1], p[2]));
  const double longest = std::max({extent.x, extent.y, extent.z});
  const double across = n.x + n.y + n.z - std::max({n.x, n.y, n.z});
  const double underflow = kUnderflow * least * (1.0 + longest);
  const double distance = glm::dot(n, error) + kStandOffTest * r * across * longest + underflow;
  const double area = glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
  if (!engine.by_area || !(area > 0.0)) return distance;
  return distance + underflow / area + 0x1p-10 * r * longest;
}

}  // namespace

double Bounds::diagonal() const { return glm::length(high - low); }

std::optional<Bounds> bounds_of(const Mesh& mesh) {
  std::optional<Bounds> bounds;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::dvec3 p[3] = {mesh.vertex(i, 0), mesh.vertex(i, 1), mesh.vertex(i, 2)};
    if (!finite(p[0]) || !finite(p[1]) || !finite(p[2])) continue;
    if (!bounds) bounds = {p[0], p[0]};
    for (const glm::dvec3& q : p) {
      bounds->low = glm::min(bounds->low, q);
      bounds->high = glm::max(bounds->high, q);
    }
  }
  return bounds;
}

glm::dvec3 area_vector(const Mesh& mesh, std::size_t i) {
  const glm::dvec3 p0 = mesh.vertex(i, 0);
  return glm::cross(glm::dvec3(mesh.vertex(i, 1)) - p0, glm::dvec3(mesh.vertex(i, 2)) - p0);
}

Surface surface_at(const Mesh& mesh, const Ray& ray, const Hit& hit) {
  return surface_of(triangle_of(mesh, hit), ray, hit);
}

Departure departure(const Mesh& mesh, const Ray& ray, const Hit& hit, const ScaledFormat& format) {
  const Format& numbers = format.numbers;
  Triangle p = triangle_of(mesh, hit);
  if (!(numbers == Format{}) || format.scale != 0) {
    for (glm::dvec3& corner : p) {
      for (int axis = 0; axis < 3; ++axis)
        corner[axis] = round_to(numbers, std::ldexp(corner[axis], format.scale));
    }
  }
  const Surface s = surface_of(p, ray, hit);
  const glm::dvec3 place = s.position + s.normal * stand_off(p, hit, s.normal, format);
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const FormatGrid grid(numbers);
  Departure out{.origin = {}, .normal = s.normal};
  for (int axis = 0; axis < 3; ++axis) {
    const double n = s.normal[axis];
    const float x = n > 0.0   ? grid.at_least(place[axis])
                    : n < 0.0 ? grid.at_most(place[axis])
                              : static_cast<float>(round_to(numbers, place[axis]));
    out.origin[axis] = std::ldexp(x, -format.scale);
    // Where that is not exact it is below the least normal binary32.
    const float back = std::ldexp(out.origin[axis], format.scale);
    if (n * (double{x} - double{back}) > 0.0)
      out.origin[axis] = std::nextafter(out.origin[axis], n > 0.0 ? kInf : -kInf);
  }
  return out;
}

}  // namespace ti
