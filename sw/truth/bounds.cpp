// SPDX-License-Identifier: Apache-2.0
#include "truth/bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ti {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kDoubleUnit = 0x1p-52;      // covers one rounding of a double twice over
constexpr double kSumSlack = 1.0 + 0x1p-40;  // for the few roundings of a bound itself

Point difference(const glm::vec3& a, const glm::vec3& b) {
  return {double{a.x} - double{b.x}, double{a.y} - double{b.y}, double{a.z} - double{b.z}};
}

/// n = e0 x e1 in double, or by integers when cancellation leaves fewer than 44 good bits of the
/// largest component.
Point normal(const Corners& triangle) {
  const auto e0 = difference(triangle[1], triangle[0]);
  const auto e1 = difference(triangle[2], triangle[0]);
  Point n{};
  double largest = 0.0;
  double terms = 0.0;
  for (std::size_t w = 0; w < 3; ++w) {
    const std::size_t u = (w + 1) % 3;
    const std::size_t v = (w + 2) % 3;
    n[w] = e0[u] * e1[v] - e0[v] * e1[u];
    largest = std::max(largest, std::abs(n[w]));
    terms = std::max(terms, std::abs(e0[u] * e1[v]) + std::abs(e0[v] * e1[u]));
  }
  if (largest > terms * 0x1p-6) {
    return n;
  }
  const auto exact = exact_normal(triangle);
  for (std::size_t w = 0; w < 3; ++w) {
    long exponent = 0;
    const double mantissa = mpz_get_d_2exp(&exponent, exact[w].get_mpz_t());
    n[w] = std::ldexp(mantissa, static_cast<int>(exponent) - 298);
  }
  return n;
}

}  // namespace

BoundedOps::BoundedOps(Format format)
    : u_(format.rounding_unit() + kDoubleUnit),
      stored_u_(std::ldexp(1.0, -format.frac_bits - 1) + kDoubleUnit),
      reciprocal_u_(std::max(2.0 * u_, format.reciprocal_unit() + kDoubleUnit)),
      eta_(format.underflow_unit()),
      sum_eta_(format.modes.flush ? eta_ : 0.0),
      max_(std::ldexp(2.0 - std::ldexp(1.0, -format.frac_bits), format.bias())),
      saturates_(format.modes.toward_zero) {}

Bounded BoundedOps::ranged(Bounded a) const {
  const double reach = std::abs(a.v) + a.e;
  return reach <= max_ ? Bounded{a.v, a.e * kSumSlack}
                       : Bounded{std::clamp(a.v, -max_, max_), kInf};
}

Bounded BoundedOps::stored(double value) const {
  return ranged({value, value == 0.0 ? 0.0 : stored_u_ * std::abs(value) + eta_});
}

Bounded BoundedOps::add(Bounded a, Bounded b) const {
  const double v = a.v + b.v;
  const double e = a.e + b.e;
  const bool exact = (a.v == 0.0 && a.e == 0.0) || (b.v == 0.0 && b.e == 0.0);
  return ranged({v, exact ? e : e + u_ * (std::abs(v) + e) + sum_eta_});
}

Bounded BoundedOps::mul(Bounded a, Bounded b) const {
  if ((a.v == 0.0 && a.e == 0.0 && b.e < kInf) || (b.v == 0.0 && b.e == 0.0 && a.e < kInf)) {
    return {0.0, 0.0};
  }
  if (a.e == kInf || b.e == kInf) {
    return {0.0, kInf};
  }
  const double v = a.v * b.v;
  const double e = std::abs(a.v) * b.e + std::abs(b.v) * a.e + a.e * b.e;
  return ranged({v, e + u_ * (std::abs(v) + e) + eta_});
}

Bounded BoundedOps::reciprocal(Bounded a) const {
  const double least = std::abs(a.v) - a.e;
  if (!(least > 0.0)) {
    return {0.0, kInf};
  }
  const double v = 1.0 / a.v;
  const double e = a.e / (std::abs(a.v) * least);
  return ranged({v, e + reciprocal_u_ * (std::abs(v) + e) + eta_});
}

std::optional<TestConstants> test_constants(const Corners& triangle, Format format, TestKind test) {
  if (!(finite(triangle[0]) && finite(triangle[1]) && finite(triangle[2]))) {
    return std::nullopt;
  }
  const auto n = normal(triangle);
  std::size_t w = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    w = std::abs(n[k]) > std::abs(n[w]) ? k : w;
  }
  if (n[w] == 0.0) {
    return std::nullopt;
  }
  const std::size_t u = (w + 1) % 3;
  const std::size_t v = (w + 2) % 3;
  const auto e0 = difference(triangle[1], triangle[0]);
  const auto e1 = difference(triangle[2], triangle[0]);
  const Point p = point_of(triangle[0]);
  TestConstants c{.test = test,
                  .corners = triangle,
                  .w = static_cast<int>(w),
                  .nu = n[u] / n[w],
                  .nv = n[v] / n[w],
                  .pu = p[u],
                  .pv = p[v],
                  .pw = p[w],
                  .e0u = e0[u] / n[w],
                  .e0v = e0[v] / n[w],
                  .e1u = e1[u] / n[w],
                  .e1v = e1[v] / n[w]};
  if (test == TestKind::Woop) return c;
  if (test == TestKind::Np) c.pw = std::fma(c.nu, p[u], c.nv * p[v]) + p[w];
  for (const double x : {c.pw, c.e0u, c.e0v, c.e1u, c.e1v}) {
    if (!std::isfinite(round_to(format, x))) {
      return std::nullopt;
    }
  }
  return c;
}

namespace {

/// Axis of the largest |d|, the lowest at a tie.
int largest_axis(const glm::vec3& d) {
  int z = 0;
  if (std::abs(d[1]) > std::abs(d[z])) z = 1;
  if (std::abs(d[2]) > std::abs(d[z])) z = 2;
  return z;
}

/// Times the power of two that brings the largest weight into [2, 4), where the engine may be one
/// place off; it cuts what is then below the least normal number.
void level(const BoundedOps& ops, std::array<Bounded, 3>& weight) {
  double largest = 0.0;
  for (const Bounded& w : weight) {
    if (w.e == kInf) return;
    largest = std::max(largest, std::abs(w.v));
  }
  if (largest == 0.0) return;
  const int places = 1 - std::ilogb(largest);
  for (Bounded& w : weight)
    w = {std::ldexp(w.v, places), std::ldexp(w.e, places) + 4.0 * ops.eta()};
}

TestBand woop_band(const BoundedOps& ops, const Corners& corners, const Ray& ray) {
  const int iz = largest_axis(ray.d);
  const int ix = (iz + 1) % 3;
  const int iy = (iz + 2) % 3;
  const auto exactly = [](float x) { return Bounded{double{x}, 0.0}; };
  const Bounded sz = ops.reciprocal(exactly(ray.d[iz]));
  const Bounded sx = ops.mul(exactly(ray.d[ix]), sz);
  const Bounded sy = ops.mul(exactly(ray.d[iy]), sz);
  std::array<Bounded, 3> x, y, z;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto away = [&](int axis) {
      return ops.sub(exactly(corners[k][axis]), exactly(ray.o[axis]));
    };
    z[k] = away(iz);
    x[k] = ops.sub(away(ix), ops.mul(sx, z[k]));
    y[k] = ops.sub(away(iy), ops.mul(sy, z[k]));
  }
  std::array<Bounded, 3> weight;
  bool may_be[2] = {true, true};   // all 0 or more, all 0 or less
  bool must_be[2] = {true, true};  // whatever the rounding
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t b = (k + 1) % 3;
    const std::size_t c = (k + 2) % 3;
    weight[k] = ops.sub(ops.mul(x[c], y[b]), ops.mul(y[c], x[b]));
    may_be[0] = may_be[0] && weight[k].hi() >= 0.0;
    may_be[1] = may_be[1] && weight[k].lo() <= 0.0;
    must_be[0] = must_be[0] && weight[k].lo() >= 0.0;
    must_be[1] = must_be[1] && weight[k].hi() <= 0.0;
  }
  TestBand band;
  band.possible = may_be[0] || may_be[1];
  if (!band.possible) return band;
  level(ops, weight);
  const Bounded det = ops.add(ops.add(weight[0], weight[1]), weight[2]);
  const Bounded depth = ops.add(ops.add(ops.mul(weight[0], z[0]), ops.mul(weight[1], z[1])),
                                ops.mul(weight[2], z[2]));
  const Bounded r = ops.reciprocal(det);
  band.t = ops.mul(ops.mul(depth, r), sz);
  band.u = ops.mul(weight[1], r);
  band.v = ops.mul(weight[2], r);
  const bool open = r.e == kInf || band.t.e == kInf;
  band.certain = (must_be[0] || must_be[1]) && !open && band.t.lo() >= 0.0;
  band.grazing = open || band.t.lo() < 0.0;
  band.possible = open || band.t.hi() >= 0.0;
  return band;
}

/// Static form of `woop_band`.
bool may_meet_woop(const BoundedOps& ops, const Corners& corners, const Ray& ray) {
  const int iz = largest_axis(ray.d);
  const int ix = (iz + 1) % 3;
  const int iy = (iz + 2) % 3;
  const double sx = double{ray.d[ix]} / double{ray.d[iz]};
  const double sy = double{ray.d[iy]} / double{ray.d[iz]};
  std::array<double, 3> x{}, y{};
  double far = 0.0;
  double wide = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double z = double{corners[k][iz]} - double{ray.o[iz]};
    const double ax = double{corners[k][ix]} - double{ray.o[ix]};
    const double ay = double{corners[k][iy]} - double{ray.o[iy]};
    x[k] = ax - sx * z;
    y[k] = ay - sy * z;
    far = std::max({far, std::abs(z), std::abs(ax), std::abs(ay)});
    wide = std::max({wide, std::abs(x[k]), std::abs(y[k])});
  }
  // Inverses of the largest numbers, and products near the end of the range, are not spoken of.
  if (!(8.0 * far * far <= ops.max()) || std::abs(double{ray.d[iz]}) * 4.0 > 1.0 / ops.eta() ||
      !(std::abs(double{ray.d[iz]}) > 4.0 / ops.max()) ||
      1.0 / std::abs(double{ray.d[iz]}) < ops.eta() * 0x1p26) {
    return true;
  }
  const double seen = static_corner(ops) * far + 32.0 * ops.eta();
  const double tolerance =
      kStaticBounds.weight * (seen + ops.u() * wide) * (wide + seen) + 32.0 * ops.eta();
  bool plus = true;
  bool minus = true;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t b = (k + 1) % 3;
    const std::size_t c = (k + 2) % 3;
    const double weight = x[c] * y[b] - y[c] * x[b];
    plus = plus && weight >= -tolerance;
    minus = minus && weight <= tolerance;
  }
  return plus || minus;
}

}  // namespace

TestBand test_band(const BoundedOps& ops, const TestConstants& tri, const Ray& ray) {
  if (tri.test == TestKind::Woop) return woop_band(ops, tri.corners, ray);
  const int iu = (tri.w + 1) % 3;
  const int iv = (tri.w + 2) % 3;
  const auto exactly = [](float x) { return Bounded{double{x}, 0.0}; };
  const Bounded nu = ops.stored(tri.nu);
  const Bounded nv = ops.stored(tri.nv);
  const Bounded du = exactly(ray.d[iu]);
  const Bounded dv = exactly(ray.d[iv]);
  const Bounded au = ops.sub({tri.pu, 0.0}, exactly(ray.o[iu]));
  const Bounded av = ops.sub({tri.pv, 0.0}, exactly(ray.o[iv]));

  const Bounded det = ops.add(ops.add(ops.mul(nu, du), ops.mul(nv, dv)), exactly(ray.d[tri.w]));
  const Bounded ow = exactly(ray.o[tri.w]);
  const Bounded dett =
      tri.test == TestKind::Np
          ? ops.sub(ops.stored(tri.pw), ops.add(ops.add(ops.mul(nu, exactly(ray.o[iu])),
                                                        ops.mul(nv, exactly(ray.o[iv]))),
                                                ow))
          : ops.add(ops.add(ops.mul(nu, au), ops.mul(nv, av)), ops.sub({tri.pw, 0.0}, ow));
  const Bounded big_u = ops.sub(ops.mul(du, dett), ops.mul(au, det));
  const Bounded big_v = ops.sub(ops.mul(dv, dett), ops.mul(av, det));
  const Bounded detu =
      ops.sub(ops.mul(ops.stored(tri.e1v), big_u), ops.mul(ops.stored(tri.e1u), big_v));
  const Bounded detv =
      ops.sub(ops.mul(ops.stored(tri.e0u), big_v), ops.mul(ops.stored(tri.e0v), big_u));
  const Bounded sum = ops.add(detu, detv);

  TestBand band;
  if (det.v == 0.0 && det.e == 0.0) {
    return band;
  }
  if (!(std::abs(det.v) > det.e)) {
    // The sign of det is open: only what holds for both signs excludes the triangle.
    const bool opposite =
        (detu.lo() > 0.0 && detv.hi() < 0.0) || (detu.hi() < 0.0 && detv.lo() > 0.0);
    const bool outside = std::abs(sum.v) - sum.e > std::abs(det.v) + det.e;
    const double least_t = (std::abs(dett.v) - dett.e) / (std::abs(det.v) + det.e) *
                               (1.0 - 6.0 * ops.u() - ops.reciprocal_u()) -
                           ops.eta();
    band.possible = !opposite && !outside && (ops.saturates() || !(least_t > ops.max()));
    band.grazing = true;
    band.t = band.u = band.v = {0.0, kInf};
    return band;
  }
  const double s = det.v < 0.0 ? -1.0 : 1.0;
  const Bounded r = ops.reciprocal(det);
  band.t = ops.mul(dett, r);
  band.u = ops.mul(detu, r);
  band.v = ops.mul(detv, r);
  const std::array<Bounded, 4> inside{Bounded{s * dett.v, dett.e}, Bounded{s * detu.v, detu.e},
                                      Bounded{s * detv.v, detv.e},
                                      Bounded{s * (det.v - sum.v), det.e + sum.e}};
  band.possible =
      std::all_of(inside.begin(), inside.end(), [](const Bounded& x) { return x.hi() >= 0.0; });
  const bool sided =
      std::all_of(inside.begin(), inside.end(), [](const Bounded& x) { return x.lo() >= 0.0; });
  band.certain = sided && r.e < kInf && band.t.e < kInf;
  band.grazing =
      band.possible && (inside[0].lo() < 0.0 || r.e == kInf || band.t.e == kInf || sum.e == kInf);
  return band;
}

bool may_meet(const BoundedOps& ops, const TestConstants& tri, const Ray& ray) {
  if (ops.u() > 0x1p-7) {
    return true;  // the static form is of first order: too loose a proof for very short fractions
  }
  if (tri.test == TestKind::Woop) return may_meet_woop(ops, tri.corners, ray);
  const int iu = (tri.w + 1) % 3;
  const int iv = (tri.w + 2) % 3;
  const double du = ray.d[iu];
  const double dv = ray.d[iv];
  const double dw = ray.d[tri.w];
  const double au = tri.pu - ray.o[iu];
  const double av = tri.pv - ray.o[iv];
  const double aw = tri.corners[0][tri.w] - ray.o[tri.w];
  const double det = tri.nu * du + tri.nv * dv + dw;
  const double dett = tri.nu * au + tri.nv * av + aw;
  // As published, dett grows with the distance from the origin of space instead.
  const double space = tri.test == TestKind::Np ? std::abs(tri.pw) + std::abs(ray.o[iu]) +
                                                      std::abs(ray.o[iv]) + std::abs(ray.o[tri.w])
                                                : 0.0;
  const double big_u = du * dett - au * det;
  const double big_v = dv * dett - av * det;
  const double detu = tri.e1v * big_u - tri.e1u * big_v;
  const double detv = tri.e0u * big_v - tri.e0v * big_u;

  const double a = std::max({std::abs(au), std::abs(av), std::abs(aw), space});
  const double d = std::max({std::abs(du), std::abs(dv), std::abs(dw)});
  const double s0 = std::abs(tri.e0u) + std::abs(tri.e0v);
  const double s1 = std::abs(tri.e1u) + std::abs(tri.e1v);
  if (6.0 * (s0 + s1 + 1.0) * (a + 1.0) * (d + 1.0) > ops.max()) {
    return true;  // may overflow: the bounds below do not speak of that
  }
  // And the underflow of every product, and of every sum where that is flushed.
  const double u = ops.u();
  const double tiny = 64.0 * ops.eta() * (1.0 + s0 + s1) * (1.0 + a) * (1.0 + d);
  const double tol_u = kStaticBounds.inside * u * s1 * a * d + tiny;
  const double tol_v = kStaticBounds.inside * u * s0 * a * d + tiny;
  const double tol_w =
      kStaticBounds.sum * u * (s0 + s1) * a * d + kStaticBounds.sum_det * u * d + tiny;
  const double w = det - detu - detv;
  const double tol_det = kStaticBounds.det * u * d + tiny;
  const double tol_t = kStaticBounds.dett * u * a + tiny;
  const bool plus =
      det >= -tol_det && detu >= -tol_u && detv >= -tol_v && w >= -tol_w && dett >= -tol_t;
  const bool minus =
      det <= tol_det && detu <= tol_u && detv <= tol_v && w <= tol_w && dett <= tol_t;
  return plus || minus;
}

}  // namespace ti
