// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/vec.hpp"
#include "scene/ray.hpp"

namespace ti::model {

/// The scene box, padded by the builder.
template <class F>
struct Box {
  Vec3<F> lo, hi;
};

/// A ray in the number format.
template <class F>
struct FpRay {
  Vec3<F> o, d;
  F tmin, tmax;
  bool any = false;
};

/// What RD makes of a ray.
template <class F>
struct Clipped {
  bool miss = false;
  Status status = Status::Ok;
  Vec3<F> inv;
  F tmin, tmax;  ///< interval of the traversal, 0 <= tmin < tmax unless `miss`
};

/// Units in the last place by which the interval of a ray grows at each end. `ti_rd_clip` has the
/// proof.
template <class F>
[[nodiscard]] std::uint32_t outward_ulps() {
  return F::reciprocal_half_ulps() + (F::modes().toward_zero ? 6 : 3);
}

/// Set-up of a ray: inverse direction and the interval inside the scene box, moved outward.
///
/// Bit-exact model of `ti_rd_clip`. Slabs after Kay and Kajiya 1986; an axis whose inverse is
/// infinite sets no bound.
template <class F>
[[nodiscard]] Clipped<F> clip(const Box<F>& box, const FpRay<F>& ray) {
  Clipped<F> out;
  bool bad = ray.tmin.is_nan() || ray.tmax.is_nan();
  bool outside = false;
  int parallel_axes = 0;
  F tmin = ray.tmin.signbit() ? F{} : ray.tmin;
  F tmax = ray.tmax;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bad = bad || !ray.o[axis].is_finite() || !ray.d[axis].is_finite();
    const F inv = reciprocal(ray.d[axis]);
    const F to_lo = box.lo[axis] - ray.o[axis];
    const F to_hi = box.hi[axis] - ray.o[axis];
    out.inv[axis] = inv;
    if (inv.is_inf()) {
      ++parallel_axes;
      outside = outside || to_lo > F{} || to_hi < F{};
      continue;
    }
    const bool negative = inv.signbit();
    const F near_t = (negative ? to_hi : to_lo) * inv;
    const F far_t = (negative ? to_lo : to_hi) * inv;
    if (tmin < near_t) tmin = near_t;
    if (far_t < tmax) tmax = far_t;
  }
  const bool behind = tmax < F{};
  out.tmin = tmin.ulps_down(outward_ulps<F>());
  out.tmax = (tmax.signbit() ? F{} : tmax).ulps_up(outward_ulps<F>());
  const bool invalid = bad || parallel_axes == 3;
  out.status = invalid ? Status::InvalidRay : Status::Ok;
  out.miss = invalid || outside || behind || !(ray.tmin <= ray.tmax) || !(out.tmin <= out.tmax);
  return out;
}

}  // namespace ti::model
