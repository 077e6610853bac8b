// SPDX-License-Identifier: Apache-2.0
#include "cli/hardcases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "accel/scene_scale.hpp"
#include "base/error.hpp"
#include "cli/hardcase_file.hpp"
#include "scene/scaling.hpp"
#include "truth/bounds.hpp"
#include "truth/exact.hpp"
#include "truth/impl.hpp"
#include "truth/truth.hpp"

namespace ti {
namespace {

constexpr Format kBinary32{8, 23};

std::string ids_text(const std::vector<std::int32_t>& ids) {
  return fmt::format("{}", fmt::join(ids, " or "));
}

std::string hit_text(const Hit& hit) {
  if (!hit.is_hit()) {
    return hit.status == Status::Ok ? "miss"
                                    : fmt::format("miss, status {}", static_cast<int>(hit.status));
  }
  return fmt::format("hit {} at {}", hit.prim, hit.t);
}

/// The exact t of a case that has one: as it is written, or near it where that is long.
std::string t_text(const HardCase& c) {
  return c.exact_t.size() <= 24 ? c.exact_t
                                : fmt::format("{}", to_double(parse_rational(c.exact_t).value()));
}

/// Whether hit.t is the exact t of the case within the bound of the test of the reported triangle.
bool t_within_bound(const HardCase& c, const Hit& hit, const Format& format, TestKind test) {
  const BoundedOps ops(format);
  const auto constants =
      test_constants(c.mesh.corners(static_cast<std::size_t>(hit.prim)), format, test);
  if (!constants || !std::isfinite(hit.t)) {
    return false;
  }
  const TestBand band = test_band(ops, *constants, c.ray);
  if (!band.possible) {
    return false;
  }
  if (!std::isfinite(band.t.e)) {
    return true;
  }
  return abs(mpq_class(double{hit.t}) - parse_rational(c.exact_t).value()) <= mpq_class(band.t.e);
}

CaseOutcome outcome(bool pass) { return pass ? CaseOutcome::Pass : CaseOutcome::Fail; }

/// What passes by a rule passes by a policy.
void by_policy(CaseResult& result, const std::string& name) {
  if (result.pass()) result.outcome = CaseOutcome::Policy;
  result.text += fmt::format(" ({})", name);
}

/// What an engine of a format with a test is held to by the rule of a case that is in the format.
class Rules {
 public:
  Rules(const HardCase& c, const Hit& hit, const Format& format, TestKind test)
      : c_(c), hit_(hit), format_(format), test_(test) {}

  [[nodiscard]] CaseResult judge(CaseRule rule) const;

 private:
  [[nodiscard]] CaseResult miss() const {
    return {outcome(!hit_.is_hit()), "miss", hit_text(hit_), ""};
  }
  [[nodiscard]] CaseResult hit(const std::vector<std::int32_t>& ids) const;
  [[nodiscard]] CaseResult exact() const { return c_.exact_hit ? hit(c_.exact_ids) : miss(); }
  [[nodiscard]] CaseResult policy() const;
  [[nodiscard]] CaseResult watertight() const;
  [[nodiscard]] CaseResult self() const;

  const HardCase& c_;
  const Hit& hit_;
  Format format_;
  TestKind test_;
};

CaseResult Rules::hit(const std::vector<std::int32_t>& ids) const {
  CaseResult result{CaseOutcome::Fail, fmt::format("hit {} at {}", ids_text(ids), t_text(c_)),
                    hit_text(hit_), ""};
  if (!hit_.is_hit()) {
    return result;
  }
  if (std::find(ids.begin(), ids.end(), hit_.prim) == ids.end()) {
    result.text += ", another triangle";
  } else if (!t_within_bound(c_, hit_, format_, test_)) {
    result.text += ", t is beyond its bound";
  } else {
    result.outcome = CaseOutcome::Pass;
  }
  return result;
}

/// Whether the exact t of the case is beyond the largest number of the format.
bool t_overflows(const HardCase& c, const Format& format) {
  return c.exact_hit && std::isinf(round_to(format, to_double(parse_rational(c.exact_t).value())));
}

/// A choice that the machine makes where the case leaves one; the first that applies counts.
struct Policy {
  const char* name;
  bool (*applies)(const HardCase&, const Format&);
  bool miss;  ///< the outcome; otherwise the exact result
};

constexpr std::array<Policy, 4> kPolicies{{
    {"invalid ray: no axis has a finite 1/d",
     [](const HardCase& c, const Format& format) { return !valid_ray(c.ray, format); }, true},
    {"hits behind the origin do not count",
     [](const HardCase& c, const Format&) {
       return c.exact_hit && sgn(parse_rational(c.exact_t).value()) < 0;
     },
     true},
    {"t beyond the range is a miss", t_overflows, true},
    {"the interval is closed", [](const HardCase&, const Format&) { return true; }, false},
}};

const Policy& policy_of(const HardCase& c, const Format& format) {
  return *std::find_if(kPolicies.begin(), kPolicies.end(),
                       [&](const Policy& p) { return p.applies(c, format); });
}

CaseResult Rules::policy() const {
  const Policy& policy = policy_of(c_, format_);
  CaseResult result = policy.miss ? miss() : exact();
  by_policy(result, policy.name);
  return result;
}

/// Whether b lies on the segment from a to c, not at its ends.
bool strictly_between(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  if (a == b || b == c) {
    return false;
  }
  for (int k = 0; k < 3; ++k) {
    if (!(std::min(a[k], c[k]) <= b[k] && b[k] <= std::max(a[k], c[k]))) {
      return false;
    }
  }
  const auto normal = exact_normal({a, b, c});
  return std::all_of(normal.begin(), normal.end(), [](const mpz_class& x) { return sgn(x) == 0; });
}

/// Whether a corner lies inside an edge of another triangle: no test of single triangles is
/// watertight there.
bool has_t_junction(const Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Corners tri = mesh.corners(i);
    for (std::size_t k = 0; k < 3; ++k) {
      for (const glm::vec3& p : mesh.vertices) {
        if (strictly_between(tri[k], p, tri[(k + 1) % 3])) {
          return true;
        }
      }
    }
  }
  return false;
}

CaseResult Rules::watertight() const {
  CaseResult result = exact();
  if (!result.pass() && has_t_junction(c_.mesh)) {
    result.outcome = CaseOutcome::Policy;
    result.text += " (a T-junction: any result, but it ends)";
  }
  return result;
}

CaseResult Rules::self() const {
  CaseResult result = hit_.is_hit() ? exact() : miss();
  by_policy(result, "whoever spawns the ray moves its origin off the surface");
  return result;
}

CaseResult Rules::judge(CaseRule rule) const {
  switch (rule) {
    case CaseRule::Exact:
      return exact();
    case CaseRule::Watertight:
      return watertight();
    case CaseRule::NoHit:
      return miss();
    case CaseRule::Tie:
      return c_.exact_hit ? hit({*std::min_element(c_.exact_ids.begin(), c_.exact_ids.end())})
                          : miss();
    case CaseRule::Policy:
      return policy();
    case CaseRule::Self:
      return self();
  }
  return {};
}

/// Why `format` cannot hold the case of which `rounded` is what is left; empty: it can.
std::string why_absent(const HardCase& c, const HardCase& rounded, const Format& format,
                       TestKind test) {
  const auto overflows = [](float before, float after) {
    return std::isfinite(before) && !std::isfinite(after);
  };
  for (int k = 0; k < 3; ++k) {
    if (overflows(c.ray.o[k], rounded.ray.o[k]) || overflows(c.ray.d[k], rounded.ray.d[k])) {
      return "the ray overflows";
    }
  }
  if (overflows(c.ray.tmin, rounded.ray.tmin)) return "the ray overflows";
  if (valid_ray(c.ray, kBinary32) && !valid_ray(rounded.ray, format)) return "1/d overflows";
  for (std::size_t i = 0; i < c.mesh.triangles.size(); ++i) {
    // Woop's test has no constants, so it drops only what is not finite or has no area.
    if (!test_constants(c.mesh.corners(i), kBinary32, TestKind::Woop)) continue;
    const Corners corners = rounded.mesh.corners(i);
    if (test_constants(corners, format, test)) continue;
    const bool finite = std::all_of(corners.begin(), corners.end(), [](const glm::vec3& p) {
      return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    });
    if (!finite) return "a corner overflows";
    return test_constants(corners, format, TestKind::Woop) ? "a constant of the test overflows"
                                                           : "a triangle loses its area";
  }
  return "";
}

/// Other formats: by the rule on the rounded case, or by whatever the bounds of that format
/// explain.
CaseResult judge_rounded(const HardCase& c, const Hit& hit, const Format& format, TestKind test) {
  const HardCase rounded = rounded_case(c, format, test);
  // A miss is required there by an exact result too, and every t must be in the range.
  const CaseRule rule = t_overflows(rounded, format) ? CaseRule::Policy
                        : c.rule == CaseRule::NoHit  ? CaseRule::Exact
                                                     : c.rule;
  CaseResult result = Rules(rounded, hit, format, test).judge(rule);
  const Truth truth(c.mesh, format, "", Truth::kLooks, test);
  const Truth::ExactHit exact = truth.exact(c.ray);
  Hit reference;
  if (exact.hit) {
    reference.prim = exact.prims.front();
    reference.t = static_cast<float>(exact.t);
  }
  result.absent = why_absent(c, rounded, format, test);
  if (truth.judge(c.ray, hit, reference) == Verdict::Unexplained) {
    result.outcome = CaseOutcome::Fail;
    result.text += ", no bound explains it";
  } else if (!result.absent.empty()) {
    result.outcome = CaseOutcome::Absent;
    result.text += fmt::format(" ({})", result.absent);
  } else if (!result.pass()) {
    result.outcome = CaseOutcome::Bound;
    result.text += ", within the bounds";
  }
  return result;
}

/// The exact result of the mesh and the ray, tmin and tmax as they stand.
void set_exact(HardCase& c, const Format& format, TestKind test) {
  c.exact_hit = false;
  c.exact_ids.clear();
  c.exact_t.clear();
  const glm::vec3 sum = c.ray.o + c.ray.d;
  if (!std::isfinite(sum.x + sum.y + sum.z)) return;
  mpq_class least;
  for (std::size_t i = 0; i < c.mesh.triangles.size(); ++i) {
    const Corners triangle = c.mesh.corners(i);
    const auto met =
        test_constants(triangle, format, test) ? exact_meeting(c.ray, triangle) : std::nullopt;
    if (!met || !between_ends(c.ray, met->t)) continue;
    if (c.exact_hit && met->t > least) continue;
    if (!c.exact_hit || met->t < least) c.exact_ids.clear();
    least = met->t;
    c.exact_hit = true;
    c.exact_ids.push_back(static_cast<std::int32_t>(i));
  }
  if (c.exact_hit) c.exact_t = least.get_str();
}

}  // namespace

HardCase scaled_case(const HardCase& c, int scale) {
  if (scale == 0) return c;
  HardCase moved = c;
  moved.mesh = scaled(c.mesh, {kBinary32, scale});
  moved.ray = scaled(c.ray, scale);
  if (c.exact_hit) {
    mpq_class t = parse_rational(c.exact_t).value();
    t *= mpq_class(std::ldexp(1.0, scale));
    moved.exact_t = t.get_str();
  }
  return moved;
}

HardCase rounded_case(const HardCase& c, const Format& format, TestKind test) {
  HardCase rounded = c;
  rounded.ray = round_ray(c.ray, format);
  for (glm::vec3& p : rounded.mesh.vertices) {
    for (int k = 0; k < 3; ++k) p[k] = static_cast<float>(round_to(format, p[k]));
  }
  set_exact(rounded, format, test);
  return rounded;
}

std::string oracle_of(const HardCase& c) {
  switch (c.rule) {
    case CaseRule::Policy:
      return fmt::format("policy: {}", policy_of(c, kBinary32).name);
    case CaseRule::Self:
      return "exact, or a miss";
    case CaseRule::Watertight:
      return has_t_junction(c.mesh) ? "it ends" : "exact, any of the ids";
    case CaseRule::Tie:
      return "exact, the lowest id";
    case CaseRule::Exact:
    case CaseRule::NoHit:
      break;
  }
  return "exact";
}

CaseResult judge_case(const HardCase& given, const Hit& found, const Format& format,
                      TestKind test) {
  if (found.is_hit() && static_cast<std::size_t>(found.prim) >= given.mesh.triangles.size()) {
    return {CaseOutcome::Fail, "a triangle of the case", hit_text(found), ""};
  }
  const int scale = scene_scale(largest_coordinate(given.mesh), format, test);
  const HardCase c = scaled_case(given, scale);
  const Hit hit = scaled(found, scale);
  return format == kBinary32 ? Rules(c, hit, format, test).judge(c.rule)
                             : judge_rounded(c, hit, format, test);
}

int run_hardcases(const std::vector<HardCase>& cases, const CaseTracer& trace, const Format& format,
                  TestKind test) {
  int failures = 0;
  fmt::print("{:>4}  {:<58} {:<10} {:<8} {:<34} {}\n", "n", "name", "rule", "result", "required",
             "got");
  for (const HardCase& c : cases) {
    CaseResult result;
    try {
      result = judge_case(c, trace(c.mesh, c.ray), format, test);
    } catch (const Error& error) {
      result.text = error.what();
    }
    failures += result.pass() ? 0 : 1;
    fmt::print("{:>4}  {:<58} {:<10} {:<8} {:<34} {}\n", c.n, c.name, rule_name(c.rule),
               kOutcomeNames[static_cast<std::size_t>(result.outcome)], result.required,
               result.text);
  }
  fmt::print("{} cases, {} failed\n", cases.size(), failures);
  return failures;
}

}  // namespace ti
