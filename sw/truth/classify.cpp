// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "truth/impl.hpp"

namespace ti {
namespace {

/// What is known of one triangle for one ray.
struct Candidate {
  const TruthTriangle* triangle = nullptr;
  TestBand band;
  bool range_possible = false;  ///< some rounding of t lies in the ray's interval
  bool range_certain = false;   ///< every rounding does
  bool exact_hit = false;       ///< in exact arithmetic, interval included
  mpq_class exact_t;

  [[nodiscard]] bool may_be_hit() const { return band.possible && range_possible; }
  [[nodiscard]] bool must_be_hit() const { return band.certain && range_certain; }
};

/// Why a triangle may go either way.
Verdict reason(const Candidate& c) {
  return c.band.grazing || (c.band.certain && !c.range_certain) ? Verdict::Grazing : Verdict::Edge;
}

bool within(double value, const Bounded& bound) {
  return bound.e == std::numeric_limits<double>::infinity() || std::abs(value - bound.v) <= bound.e;
}

bool inside_interval(const Ray& ray, float t) {
  return t >= 0.0F && t >= ray.tmin && t <= ray.tmax;
}

/// Whether t, u and v of `hit` can come out of the test of that triangle.
bool plausible(const Ray& ray, const Hit& hit, const TestBand& band) {
  return band.possible && std::isfinite(hit.t) && inside_interval(ray, hit.t) &&
         within(hit.t, band.t) && within(hit.u, band.u) && within(hit.v, band.v);
}

Candidate look(const BoundedOps& ops, const Ray& ray, const TruthTriangle& triangle,
               const Corners& corners) {
  Candidate c;
  c.triangle = &triangle;
  c.band = test_band(ops, triangle.constants, ray);
  if (!c.band.possible) {
    return c;
  }
  const double least = std::max(0.0, double{ray.tmin});
  const double most = std::min(ops.max(), double{ray.tmax});
  c.range_possible = c.band.t_hi() >= least && c.band.t_lo() <= most;
  c.range_certain = c.band.t.lo() >= double{ray.tmin} && c.band.t_hi() <= most;
  if (c.range_possible) {
    if (const auto meeting = exact_meeting(ray, corners); meeting && in_interval(ray, meeting->t)) {
      c.exact_hit = true;
      c.exact_t = meeting->t;
    }
  }
  return c;
}

/// A reported triangle: `mine` is what is known of it.
Verdict judge_hit(const std::vector<Candidate>& all, const Candidate& mine,
                  const std::vector<const Candidate*>& nearest, const Hit& hit, const Hit& embree) {
  const bool lost = std::any_of(all.begin(), all.end(), [&](const Candidate& c) {
    return &c != &mine && c.must_be_hit() && c.band.t_hi() < double{hit.t};
  });
  if (lost) {
    return Verdict::Unexplained;
  }
  if (!mine.exact_hit) {
    return reason(mine);
  }
  if (mine.exact_t == nearest.front()->exact_t) {
    const bool embree_ties = std::any_of(nearest.begin(), nearest.end(), [&](const Candidate* c) {
      return c->triangle->prim == embree.prim;
    });
    return embree_ties ? Verdict::Tie : Verdict::EmbreeWrong;
  }
  // A nearer triangle was passed over: it may lie within the bound of t, or its own test may go
  // either way.
  const auto excused = std::find_if(nearest.begin(), nearest.end(),
                                    [](const Candidate* c) { return !c->must_be_hit(); });
  return excused == nearest.end() ? Verdict::Tie : reason(**excused);
}

/// A reported miss, or a reported hit of an any-hit ray where Embree has none.
Verdict judge_presence(const std::vector<Candidate>& all,
                       const std::vector<const Candidate*>& nearest, bool reported) {
  const bool must =
      std::any_of(all.begin(), all.end(), [](const Candidate& c) { return c.must_be_hit(); });
  if (!reported && must) {
    return Verdict::Unexplained;
  }
  if (reported != nearest.empty()) {
    return Verdict::EmbreeWrong;
  }
  if (!reported) {
    return reason(*nearest.front());
  }
  const auto possible =
      std::find_if(all.begin(), all.end(), [](const Candidate& c) { return c.may_be_hit(); });
  return possible == all.end() ? Verdict::Unexplained : reason(*possible);
}

}  // namespace

bool Truth::Impl::loses(const Ray& ray, const Hit& hit, const Hit& embree_hit) const {
  if (!embree_hit.is_hit() || (ray.any && hit.is_hit())) {
    return false;
  }
  Ray closest = ray;
  closest.any = false;
  const TruthTriangle* nearest = find(ray.any ? trace(closest).prim : embree_hit.prim);
  if (nearest == nullptr) {
    return false;
  }
  const Candidate c = look(ops, ray, *nearest, corners_of(nearest->prim));
  return c.must_be_hit() && (!hit.is_hit() || c.band.t_hi() < double{hit.t});
}

std::optional<Verdict> Truth::Impl::judge_quickly(const Ray& ray, const Hit& hit,
                                                  const Hit& embree_hit) const {
  if (hit.status != Status::Ok && hit.is_hit()) {
    return Verdict::Unexplained;
  }
  const bool valid = valid_ray(ray, format);
  if (valid && hit.status == Status::InvalidRay) {
    return Verdict::Unexplained;
  }
  if (!valid) {
    return hit.is_hit() ? Verdict::Unexplained : Verdict::Agree;
  }
  if (!hit.is_hit() && !embree_hit.is_hit()) {
    return Verdict::Agree;
  }
  if (ray.any && hit.is_hit() && embree_hit.is_hit()) {
    return Verdict::Agree;
  }
  if (hit.is_hit() && !ray.any) {
    const TruthTriangle* reported = find(hit.prim);
    if (reported == nullptr || reported->has_lower_twin) {
      return Verdict::Unexplained;
    }
    const TestBand band = test_band(ops, reported->constants, ray);
    if (!plausible(ray, hit, band)) {
      return Verdict::Unexplained;
    }
    if (hit.prim == embree_hit.prim) {
      return band.grazing ? Verdict::Grazing : Verdict::Agree;
    }
  }

  if (loses(ray, hit, embree_hit)) {
    return Verdict::Unexplained;
  }
  return std::nullopt;
}

Verdict Truth::Impl::judge(const Ray& ray, const Hit& hit, const Hit& embree_hit) const {
  if (const auto verdict = judge_quickly(ray, hit, embree_hit)) {
    return *verdict;
  }
  const TruthTriangle* reported = hit.is_hit() && !ray.any ? find(hit.prim) : nullptr;
  std::vector<Candidate> all;
  for (const std::size_t index : candidates(ray)) {
    Candidate c = look(ops, ray, triangles[index], corners_of(triangles[index].prim));
    if (c.may_be_hit()) {
      all.push_back(std::move(c));
    }
  }
  std::vector<const Candidate*> nearest;
  for (const Candidate& c : all) {
    if (!c.exact_hit) {
      continue;
    }
    if (!nearest.empty() && c.exact_t < nearest.front()->exact_t) {
      nearest.clear();
    }
    if (nearest.empty() || c.exact_t == nearest.front()->exact_t) {
      nearest.push_back(&c);
    }
  }
  if (reported == nullptr) {
    return judge_presence(all, nearest, hit.is_hit());
  }
  const auto mine = std::find_if(all.begin(), all.end(),
                                 [reported](const Candidate& c) { return c.triangle == reported; });
  return mine == all.end() ? Verdict::Unexplained : judge_hit(all, *mine, nearest, hit, embree_hit);
}

Truth::ExactHit Truth::Impl::exact(const Ray& ray) const {
  ExactHit best;
  if (!valid_ray(ray, format)) {
    return best;
  }
  mpq_class least;
  for (const std::size_t index : candidates(ray)) {
    const std::int32_t prim = triangles[index].prim;
    const auto meeting = exact_meeting(ray, corners_of(prim));
    if (!meeting || !in_interval(ray, meeting->t) || (best.hit && meeting->t > least)) {
      continue;
    }
    if (!best.hit || meeting->t < least) {
      best = ExactHit{};
      best.hit = true;
      least = meeting->t;
    }
    best.prims.push_back(prim);
    best.on_boundary = best.on_boundary || meeting->boundary;
  }
  if (best.hit) {
    best.t = to_double(least);
  }
  return best;
}

Truth::ExactHit Truth::exact(const Ray& ray) const {
  return impl_->exact(round_ray(ray, impl_->format));
}

}  // namespace ti
