// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "accel/image.hpp"
#include "base/format.hpp"
#include "scene/ray.hpp"
#include "truth/exact.hpp"

namespace ti {

/// A number with its bound: the exact value and every value that the format may compute for it lie
/// in [v - e, v + e].
struct Bounded {
  double v = 0.0;
  double e = 0.0;

  [[nodiscard]] double lo() const { return v - e; }
  [[nodiscard]] double hi() const { return v + e; }
};

/// Running error bounds of one format's operators.
///
/// Each result adds u of itself, products also eta; second-order terms are kept, so the bounds hold
/// for every M, and the rounding of the doubles that carry them is included. A value that may leave
/// the range has e = inf.
///
/// u is 2^-(M+1) to nearest and 2^-M toward zero; a reciprocal adds an ulp, or what Newton steps
/// leave. eta is that share of the least normal number
/// where subnormals are kept: then sums below it are exact. Where they are flushed it is the least
/// normal number itself, and sums add it too. Constants are rounded to nearest in every mode.
class BoundedOps {
 public:
  explicit BoundedOps(Format format);

  [[nodiscard]] Bounded stored(double value) const;  ///< a constant, rounded once
  [[nodiscard]] Bounded add(Bounded a, Bounded b) const;
  [[nodiscard]] Bounded sub(Bounded a, Bounded b) const { return add(a, {-b.v, b.e}); }
  [[nodiscard]] Bounded mul(Bounded a, Bounded b) const;
  [[nodiscard]] Bounded reciprocal(Bounded a) const;  ///< 1 ulp or more; e = inf when `a` may be 0

  [[nodiscard]] double u() const { return u_; }
  [[nodiscard]] double reciprocal_u() const { return reciprocal_u_; }
  [[nodiscard]] double eta() const { return eta_; }
  [[nodiscard]] bool saturates() const { return saturates_; }  ///< at the largest number
  [[nodiscard]] double max() const { return max_; }

 private:
  [[nodiscard]] Bounded ranged(Bounded a) const;

  double u_, stored_u_, reciprocal_u_, eta_, sum_eta_, max_;
  bool saturates_;
};

/// The constants of a triangle for its test, in double before they are rounded: Shevtsov's (2007),
/// `pw` of the test `Np` being n.p / n_w, or the corners, of Woop's.
struct TestConstants {
  TestKind test = TestKind::Local;
  Corners corners{};
  int w = 0;  ///< axis of the largest |n|, the lowest at a tie; u and v follow cyclically
  double nu = 0, nv = 0, pu = 0, pv = 0, pw = 0, e0u = 0, e0v = 0, e1u = 0, e1v = 0;
};

/// Constants of `triangle` to about 2^-44; none when its area is exactly zero, a corner is not
/// finite, or a constant overflows `format`: the triangles that the builder drops.
[[nodiscard]] std::optional<TestConstants> test_constants(const Corners& triangle, Format format,
                                                          TestKind test = TestKind::Local);

/// All that the test in the format can come to for one ray and triangle, tmin and tmax left aside.
struct TestBand {
  bool possible = false;  ///< some rounding accepts
  bool certain = false;   ///< every rounding accepts
  bool grazing =
      false;     ///< det or the sign of t is within its bound of zero, or a value may overflow
  Bounded t;     ///< e = inf when det may be zero
  Bounded u, v;  ///< barycentric weights of the second and third corner

  [[nodiscard]] double t_lo() const { return t.lo() > 0.0 ? t.lo() : 0.0; }
  [[nodiscard]] double t_hi() const { return t.hi(); }
};

/// The bounds of numerics: E_det, E_dett, E_Du, E_u, E_0, or those of Woop's edge functions, by
/// running the test of the engine on `Bounded` numbers. `ray` is in the format and valid.
[[nodiscard]] TestBand test_band(const BoundedOps& ops, const TestConstants& triangle,
                                 const Ray& ray);

/// Factors of the static form of the bounds, in rounding units u, twice what first order gives or
/// more, but for the last. A is the largest |p - o|, D the largest |d|, S the sum of the sizes of
/// two stored edges. `scripts/certify.py` proves them.
struct StaticBounds {
  double det = 18.0;      ///< of D
  double dett = 24.0;     ///< of A; of the test `Np` of all distances from the origin of space
  double inside = 108.0;  ///< detu, detv: of S A D
  double sum = 132.0;     ///< det - detu - detv: of both S, A D
  double sum_det = 30.0;  ///< and of D
  double corner = 12.0;   ///< a corner of Woop's test, and twice the error of a reciprocal: of A
  double weight = 4.0;    ///< an edge function: `may_meet` has the rest
};
inline constexpr StaticBounds kStaticBounds;

/// How far a corner of Woop's test may be seen from its place, of A.
[[nodiscard]] inline double static_corner(const BoundedOps& ops) {
  return kStaticBounds.corner * ops.u() + 2.0 * ops.reciprocal_u();
}

/// Whether the line of `ray` may meet the triangle by the static form of the same bounds; false
/// only when `test_band` cannot be `possible` and the exact test misses too. About ten times as
/// fast.
[[nodiscard]] bool may_meet(const BoundedOps& ops, const TestConstants& triangle, const Ray& ray);

}  // namespace ti
