// SPDX-License-Identifier: Apache-2.0
#include "truth/exact.hpp"

#include <cmath>
#include <limits>

namespace ti {
namespace {

using Vec = Vec3<mpz_class>;

/// Exponent of the least positive binary32, so that every finite value scaled by its inverse is an
/// integer.
constexpr int kUnitExponent = -149;

mpz_class scaled(float x) {
  int exponent = 0;
  const float mantissa = std::frexp(x, &exponent);  // |mantissa| in [0.5, 1) with 24 bits
  mpz_class z(static_cast<double>(std::ldexp(mantissa, 24)));
  const int shift = exponent - 24 - kUnitExponent;
  if (shift >= 0) {
    return mpz_class(z << static_cast<unsigned>(shift));
  }
  mpz_tdiv_q_2exp(z.get_mpz_t(), z.get_mpz_t(),
                  static_cast<mp_bitcnt_t>(-shift));  // drops zeros of a subnormal only
  return z;
}

Vec scaled(const glm::vec3& p) { return {scaled(p.x), scaled(p.y), scaled(p.z)}; }

Vec minus(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

mpz_class dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// A determinant of three vectors and its bound.
struct QuickDet {
  double v, e;
};

/// A cross product, and the same with the sizes of all products added.
struct QuickCross {
  Point v, size;
};

QuickCross quick_cross(const Point& a, const Point& b) {
  QuickCross result;
  for (std::size_t i = 0; i < 3; ++i) {
    const double plus = a[(i + 1) % 3] * b[(i + 2) % 3];
    const double less = a[(i + 2) % 3] * b[(i + 1) % 3];
    result.v[i] = plus - less;
    result.size[i] = std::abs(plus) + std::abs(less);
  }
  return result;
}

QuickDet quick_det(const Point& a, const QuickCross& b) {
  const double size =
      std::abs(a[0]) * b.size[0] + std::abs(a[1]) * b.size[1] + std::abs(a[2]) * b.size[2];
  return {a[0] * b.v[0] + a[1] * b.v[1] + a[2] * b.v[2], 0x1p-49 * size};
}

/// The double nearest to num / den (within 1 ulp); den is not 0.
double quotient_of(const mpz_class& num, const mpz_class& den) {
  // get_d truncates and saturates in ways that depend on the exponent; scale to the middle of the
  // range instead.
  if (sgn(num) == 0) {
    return 0.0;
  }
  const auto bits = [](const mpz_class& z) {
    return static_cast<long>(mpz_sizeinbase(z.get_mpz_t(), 2));
  };
  const long shift = 64 - (bits(num) - bits(den));  // the quotient gets 64 or 65 bits
  mpz_class top = abs(num);
  mpz_class bottom = abs(den);
  if (shift >= 0) {
    top <<= static_cast<unsigned long>(shift);
  } else {
    bottom <<= static_cast<unsigned long>(-shift);
  }
  const mpz_class quotient = top / bottom;
  const double magnitude = std::ldexp(mpz_get_d(quotient.get_mpz_t()), static_cast<int>(-shift));
  return sgn(num) == sgn(den) ? magnitude : -magnitude;
}

}  // namespace

Vec3<mpz_class> exact_normal(const Corners& triangle) {
  const Vec p0 = scaled(triangle[0]);
  return cross(minus(scaled(triangle[1]), p0), minus(scaled(triangle[2]), p0));
}

std::optional<ExactMeeting> exact_meeting(const Ray& ray, const Corners& triangle) {
  const Vec p0 = scaled(triangle[0]);
  const Vec e1 = minus(scaled(triangle[1]), p0);
  const Vec e2 = minus(scaled(triangle[2]), p0);
  const Vec d = scaled(ray.d);
  const Vec p = cross(d, e2);
  mpz_class det = dot(e1, p);
  const int sign = sgn(det);
  if (sign == 0) {
    return std::nullopt;
  }
  const Vec s = minus(scaled(ray.o), p0);
  const mpz_class u = dot(s, p) * sign;
  if (sgn(u) < 0) {
    return std::nullopt;
  }
  const Vec q = cross(s, e1);
  const mpz_class v = dot(d, q) * sign;
  if (sgn(v) < 0) {
    return std::nullopt;
  }
  const mpz_class size = det * sign;
  const mpz_class w = size - u - v;
  if (sgn(w) < 0) {
    return std::nullopt;
  }
  ExactMeeting meeting;
  meeting.t = mpq_class(dot(e2, q), det);
  meeting.t.canonicalize();
  meeting.u = quotient_of(u, size);
  meeting.v = quotient_of(v, size);
  meeting.boundary = sgn(u) == 0 || sgn(v) == 0 || sgn(w) == 0;
  return meeting;
}

QuickMeeting quick_meeting(const Ray& ray, const Corners& triangle) {
  using Answer = QuickMeeting::Answer;
  const Point p0 = point_of(triangle[0]);
  const Point e1 = minus(point_of(triangle[1]), p0);
  const Point e2 = minus(point_of(triangle[2]), p0);
  const Point d = point_of(ray.d);
  const Point s = minus(point_of(ray.o), p0);
  const QuickCross p = quick_cross(d, e2);
  const QuickDet det = quick_det(e1, p);
  if (!(std::abs(det.v) > det.e)) return {};
  const double sign = det.v < 0.0 ? -1.0 : 1.0;
  const QuickDet u = quick_det(s, p);
  if (u.v * sign < -u.e) return {.answer = Answer::Misses};
  const QuickCross q = quick_cross(s, e1);
  const QuickDet v = quick_det(d, q);
  if (v.v * sign < -v.e) return {.answer = Answer::Misses};
  const double w = (det.v - u.v - v.v) * sign;
  const double w_error = 2.0 * (det.e + u.e + v.e);
  if (w < -w_error) return {.answer = Answer::Misses};
  if (!(u.v * sign > u.e && v.v * sign > v.e && w > w_error)) return {};
  const QuickDet depth = quick_det(e2, q);
  const double t = depth.v / det.v;
  const double error =
      1.001 * (depth.e + std::abs(t) * det.e) / (std::abs(det.v) - det.e) + 0x1p-52 * std::abs(t);
  // The weights are right to the sum of both relative errors, twice.
  const double weight_error = 2.0 * (u.e + v.e + det.e) / std::abs(det.v);
  return {Answer::Meets, t, error, u.v / det.v, v.v / det.v, weight_error};
}

bool between_ends(const Ray& ray, const mpq_class& t) {
  if (std::isnan(ray.tmin) || std::isnan(ray.tmax)) {
    return false;
  }
  const auto not_above = [&t](float bound) {  // bound <= t
    return std::isinf(bound) ? bound < 0.0F : mpq_class(static_cast<double>(bound)) <= t;
  };
  const auto not_below = [&t](float bound) {  // t <= bound
    return std::isinf(bound) ? bound > 0.0F : t <= mpq_class(static_cast<double>(bound));
  };
  return not_above(ray.tmin) && not_below(ray.tmax);
}

bool in_interval(const Ray& ray, const mpq_class& t) { return sgn(t) >= 0 && between_ends(ray, t); }

double to_double(const mpq_class& q) { return quotient_of(q.get_num(), q.get_den()); }

}  // namespace ti
