// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
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

/// The constants of a ray for Woop's test (Woop, Benthin, Wald 2013): z is the axis of its largest
/// |d|, the lowest at a tie, x and y follow cyclically.
template <class F>
struct Shear {
  std::size_t z = 0;
  F sx, sy;  ///< dx * inv z, dy * inv z
  F sz;      ///< inv z
};

/// Bit-exact model of `ti_rd_shear`.
template <class F>
[[nodiscard]] Shear<F> shear_of(const Vec3<F>& d, const Vec3<F>& inv) {
  const auto larger = [&d](std::size_t a, std::size_t b) {
    return (d[a].bits() & ~F::kSignBit) > (d[b].bits() & ~F::kSignBit);
  };
  std::size_t z = 0;
  if (larger(1, z)) z = 1;
  if (larger(2, z)) z = 2;
  return {z, d[(z + 1) % 3] * inv[z], d[(z + 2) % 3] * inv[z], inv[z]};
}

/// Where a ray begins for its way through the tree: `least` makes each t of a plane the least that
/// rounding may come to, `most` the greatest. Both are o for a ray that is not thick.
template <class F>
struct Origins {
  Vec3<F> least, most;
};

/// Places by which the exponent of the distance A of the farthest plane of the scene box goes down
/// to that of the thickness of a ray.
///
/// What that covers, in units of u A with u = 2^-(M+1), where an operation is wrong by a units (1
/// to nearest, 2 toward zero) and a reciprocal by H (its half ulps):
/// - a corner as Woop's test sees it, 6 a + H: the difference a; the shear, of its constant H + a,
///   the way along z a, the product a, the last difference, of at most 2 A, 2 a;
/// - its way along z, 2 a + H: difference, inverse, product;
/// - t from weights and ways, 7 a + H: the products and sums of det and depth, the reciprocal, two
///   products;
/// - a plane of the tree, 2 a + H: difference, inverse, product.
/// In sum 17 a + 4 H, 21 by division to nearest; the thickness is the power of two that is not
/// less. This is of first order; `docs/certificates.md` has the proof with all orders, and where it
/// holds. A format too short for a thickness below A is refused by `scripts/configure.py`.
template <class F>
[[nodiscard]] std::uint32_t thickness_places() {
  const std::uint32_t covered =
      (F::modes().toward_zero ? 34U : 17U) + 4U * F::reciprocal_half_ulps();
  const int places = F::kFracBits + 1 - std::bit_width(covered - 1U);
  return static_cast<std::uint32_t>(places > 0 ? places : 0);
}

namespace detail {

/// The next number above x, or below; x is finite.
template <class F>
[[nodiscard]] F next_above(F x) {
  if (x.is_zero()) return F::from_bits(F::modes().flush ? std::uint32_t{1} << F::kFracBits : 1U);
  return x.signbit() ? x.ulps_down(1) : x.ulps_up(1);
}
template <class F>
[[nodiscard]] F next_below(F x) {
  return -next_above(-x);
}

}  // namespace detail

/// A thick ray: one that meets every cell of which the ray, or a triangle as the test sees it, lies
/// within the rounding errors.
///
/// Bit-exact model of `ti_rd_thick`. The distance A is the largest |plane - o| of the scene box;
/// the thickness has the fraction of A and an exponent `thickness_places` lower, at least that of
/// the least normal number; each component of the origins is o -+ thickness, rounded, then moved
/// outward by one more ulp. Where numbers are subnormal each error is half the least of them, and
/// the thickness 2^M of it.
template <class F>
[[nodiscard]] Origins<F> thick_origins(const Box<F>& box, const Vec3<F>& o, const Vec3<F>& d) {
  std::uint32_t farthest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const F plane : {box.lo[axis], box.hi[axis]}) {
      const std::uint32_t size = (plane - o[axis]).bits() & ~F::kSignBit;
      if (size > farthest) farthest = size;
    }
  }
  const std::uint32_t one = std::uint32_t{1} << F::kFracBits;  // of an exponent
  const std::uint32_t exponent = farthest / one;
  const std::uint32_t places = thickness_places<F>();
  const std::uint32_t lower = exponent > places ? exponent - places : 1;
  const F thickness = F::from_bits(lower * one + farthest % one);
  Origins<F> origins;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const F below = detail::next_below(o[axis] - thickness);
    const F above = detail::next_above(o[axis] + thickness);
    const bool negative = d[axis].signbit();
    origins.least[axis] = negative ? below : above;
    origins.most[axis] = negative ? above : below;
  }
  return origins;
}

/// What RD makes of a ray.
template <class F>
struct Clipped {
  bool miss = false;
  Status status = Status::Ok;
  Vec3<F> inv;
  F tmin, tmax;  ///< interval of the traversal, 0 <= tmin < tmax unless `miss`
  Origins<F> origins;
  Shear<F> shear;  ///< of Woop's test
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
/// infinite sets no bound. Near planes are measured from `origins.least`, far ones from
/// `origins.most`.
template <class F>
[[nodiscard]] Clipped<F> clip(const Box<F>& box, const FpRay<F>& ray, const Origins<F>& origins) {
  Clipped<F> out;
  bool bad = ray.tmin.is_nan() || ray.tmax.is_nan();
  bool outside = false;
  int parallel_axes = 0;
  F tmin = ray.tmin.signbit() ? F{} : ray.tmin;
  F tmax = ray.tmax;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bad = bad || !ray.o[axis].is_finite() || !ray.d[axis].is_finite();
    const F inv = reciprocal(ray.d[axis]);
    const bool negative = inv.signbit();
    const F to_near = (negative ? box.hi : box.lo)[axis] - origins.least[axis];
    const F to_far = (negative ? box.lo : box.hi)[axis] - origins.most[axis];
    out.inv[axis] = inv;
    if (inv.is_inf()) {
      ++parallel_axes;
      outside =
          outside || (negative ? to_near < F{} || to_far > F{} : to_near > F{} || to_far < F{});
      continue;
    }
    const F near_t = to_near * inv;
    const F far_t = to_far * inv;
    if (tmin < near_t) tmin = near_t;
    if (far_t < tmax) tmax = far_t;
  }
  const bool behind = tmax < F{};
  out.origins = origins;
  out.tmin = tmin.ulps_down(outward_ulps<F>());
  out.tmax = (tmax.signbit() ? F{} : tmax).ulps_up(outward_ulps<F>());
  const bool invalid = bad || parallel_axes == 3;
  out.status = invalid ? Status::InvalidRay : Status::Ok;
  out.miss = invalid || outside || behind || !(ray.tmin <= ray.tmax) || !(out.tmin <= out.tmax);
  return out;
}

}  // namespace ti::model
