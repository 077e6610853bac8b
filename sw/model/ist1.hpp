// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "accel/image.hpp"
#include "base/vec.hpp"

namespace ti::model {

/// Where on the ray a test counts: outside, pass (a) may drop it.
template <class F>
struct TestRange {
  F near;  ///< 0 or more
  F far;
};

/// Units in the last place by which the range test of pass (a) errs on the side of keeping.
/// `ti_ist1_verdict` has the proof.
template <class F>
[[nodiscard]] std::uint32_t cull_ulps() {
  return F::reciprocal_half_ulps() + 3;
}

/// What pass (a) leaves for pass (b).
template <class F>
struct AfterA {
  F det, dett, audet, av;
};

/// What pass (b) leaves for pass (c).
template <class F>
struct AfterB {
  F det, dett, detu, detv;
};

namespace detail {

template <class F>
[[nodiscard]] std::uint32_t exponent(F x) {
  return (x.bits() & ~F::kSignBit) >> F::kFracBits;
}
template <class F>
[[nodiscard]] bool is_normal(F x) {
  return x.is_finite() && exponent(x) != 0;
}
template <class F>
[[nodiscard]] F magnitude(F x) {
  return x.signbit() ? -x : x;
}
/// Zero, or of the same sign.
template <class F>
[[nodiscard]] bool agrees(F x, F sign_of) {
  return x.is_zero() || (!x.is_nan() && x.signbit() == sign_of.signbit());
}

}  // namespace detail

/// The axis w as the engine takes it: the two lowest bits, 3 as 2.
[[nodiscard]] inline std::size_t axis_of(const ImagePlane& plane) {
  return std::min(plane.axis & 3U, 2U);
}

/// Pass (a), ray against plane (Shevtsov et al. 2007); nothing when the test is done.
///
/// Bit-exact model of `ti_ist1_pipe`, pass (a): det = (nu du + nv dv) + dw; dett = (nu au + nv av)
/// + aw with a = p - o, of the test `Np` as published np - ((nu ou + nv ov) + ow). Both culls are
/// conservative: `range.far` drops a test only where the rounded t must exceed it, `range.near`
/// only where dett / det is less.
template <TestKind kKind, class F>
[[nodiscard]] std::optional<AfterA<F>> pass_a(const ImagePlane& plane, const Vec3<F>& o,
                                              const Vec3<F>& d, const TestRange<F>& range) {
  const std::size_t w = axis_of(plane);
  const std::size_t u = (w + 1) % 3;
  const std::size_t v = (w + 2) % 3;
  const F nu = F::from_bits(plane.nu);
  const F nv = F::from_bits(plane.nv);
  const F det = (nu * d[u] + nv * d[v]) + d[w];
  const F au = F::from_bits(plane.pu) - o[u];
  const F av = F::from_bits(plane.pv) - o[v];
  const F pw = F::from_bits(plane.pw);
  const F dett = kKind == TestKind::Np ? pw - ((nu * o[u] + nv * o[v]) + o[w])
                                       : (nu * au + nv * av) + (pw - o[w]);
  const F nearest = detail::magnitude(range.near * det);
  const F farthest = detail::magnitude(range.far * det);
  const F size = detail::magnitude(dett);

  if (det.is_zero() || !det.is_finite() || !dett.is_finite()) return std::nullopt;
  if (!detail::agrees(dett, det)) return std::nullopt;
  const int top = 2 * F::kBias;  // largest exponent field of a number
  const int det_field = static_cast<int>(detail::exponent(det));
  bool far_counts = det_field <= top - 2 && detail::is_normal(range.far);
  if (F::modes().toward_zero) {  // neither 1 / det nor t may end at the largest number
    far_counts = far_counts && det_field > 0 && static_cast<int>(detail::exponent(range.far)) < top;
  }
  if (far_counts && detail::is_normal(farthest) && farthest.ulps_up(cull_ulps<F>()) < size)
    return std::nullopt;
  if (detail::is_normal(nearest) && size.ulps_up(cull_ulps<F>()) < nearest) return std::nullopt;
  return AfterA<F>{det, dett, au * det, av};
}

/// Pass (b), inside test; nothing when the test is done.
///
/// Bit-exact model of `ti_ist1_pipe`, pass (b).
template <class F>
[[nodiscard]] std::optional<AfterB<F>> pass_b(const ImagePlane& plane, const ImageBary& bary,
                                              const Vec3<F>& d, const AfterA<F>& a) {
  const std::size_t u = (axis_of(plane) + 1) % 3;
  const std::size_t v = (axis_of(plane) + 2) % 3;
  const F du = d[u] * a.dett - a.audet;
  const F dv = d[v] * a.dett - a.av * a.det;
  const F detu = F::from_bits(bary.e1v) * du - F::from_bits(bary.e1u) * dv;
  const F detv = F::from_bits(bary.e0u) * dv - F::from_bits(bary.e0v) * du;
  if (!detail::agrees(detu, a.det) || !detail::agrees(detv, a.det)) return std::nullopt;
  if (!(detail::magnitude(detu + detv) <= detail::magnitude(a.det))) return std::nullopt;
  return AfterB<F>{a.det, a.dett, detu, detv};
}

}  // namespace ti::model
