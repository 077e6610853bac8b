// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmpxx.h>

#include <cstdint>
#include <optional>

#include "base/vec.hpp"
#include "scene/mesh.hpp"
#include "scene/ray.hpp"

namespace ti {

/// Where the line of a ray meets a triangle, without any rounding.
struct ExactMeeting {
  mpq_class t;            ///< distance in units of the ray's direction, any sign
  double u = 0.0;         ///< weight of the second corner, rounded to double within 1 ulp
  double v = 0.0;         ///< of the third
  bool boundary = false;  ///< on an edge or a vertex
};

/// Twice the area vector of `triangle` as exact integers in units of 2^-298; all zero exactly when
/// the area is zero.
[[nodiscard]] Vec3<mpz_class> exact_normal(const Corners& triangle);

/// Meeting of the line of `ray` (o and d finite; tmin and tmax are not looked at) with the closed
/// `triangle`, both sides; none when it passes outside, lies in the plane, or the triangle has no
/// area.
///
/// Moeller and Trumbore's form on integers: every finite binary32 is a multiple of 2^-149, so the
/// products are exact.
[[nodiscard]] std::optional<ExactMeeting> exact_meeting(const Ray& ray, const Corners& triangle);

/// What doubles can tell of the meeting of the line of a ray with a closed triangle.
struct QuickMeeting {
  enum class Answer : std::uint8_t { Misses, Meets, Open };
  Answer answer = Answer::Open;  ///< Open: only integers can tell
  double t = 0.0;                ///< of Meets
  double error = 0.0;            ///< |t - exact t| is at most this
  double u = 0.0;                ///< of Meets, the weights of the second corner
  double v = 0.0;                ///< and the third,
  double weight_error = 0.0;     ///< each off by at most this
};

/// The same question as `exact_meeting` by the same form in doubles. Misses and Meets are proven:
/// each determinant is a sum of products of three numbers that has seen eight roundings at most, so
/// its error is below 16 x 2^-53 of the sum of their sizes. Nothing of binary32 over- or underflows
/// there. Numbers must be finite.
[[nodiscard]] QuickMeeting quick_meeting(const Ray& ray, const Corners& triangle);

/// Whether t lies in the closed interval from tmin to tmax. NaN bounds hold nothing.
[[nodiscard]] bool between_ends(const Ray& ray, const mpq_class& t);

/// The same for a hit, whose t is not negative.
[[nodiscard]] bool in_interval(const Ray& ray, const mpq_class& t);

/// The double nearest to `q` (within 1 ulp), infinite when out of range.
[[nodiscard]] double to_double(const mpq_class& q);

}  // namespace ti
