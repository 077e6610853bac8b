// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmpxx.h>

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

/// Whether t lies in the closed interval of `ray` and is not negative. NaN bounds hold nothing.
[[nodiscard]] bool in_interval(const Ray& ray, const mpq_class& t);

/// The double nearest to `q` (within 1 ulp), infinite when out of range.
[[nodiscard]] double to_double(const mpq_class& q);

}  // namespace ti
