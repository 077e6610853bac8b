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

/// How an engine has the case.
ScaledFormat format_of(const HardCase& c, const Format& format, TestKind test) {
  return {format, scene_scale(largest_coordinate(c.mesh), format, test)};
}

/// Whether hit.t is the exact t of the case within the bound of the test of the reported triangle.
bool t_within_bound(const HardCase& c, const Hit& hit, TestKind test) {
  const BoundedOps ops(kBinary32);
  const ScaledFormat format = format_of(c, kBinary32, test);
  const Mesh mesh = scaled(c.mesh, format);
  const auto constants =
      test_constants(mesh.corners(static_cast<std::size_t>(hit.prim)), kBinary32, test);
  if (!constants || !std::isfinite(hit.t)) {
    return false;
  }
  const TestBand band = test_band(ops, *constants, scaled(c.ray, format.scale));
  if (!band.possible) {
    return false;
  }
  if (!std::isfinite(band.t.e)) {
    return true;
  }
  const mpq_class off = abs(mpq_class(double{hit.t}) - parse_rational(c.exact_t).value());
  return off * mpq_class(std::ldexp(1.0, format.scale)) <= mpq_class(band.t.e);
}

CaseResult expect_miss(const Hit& hit) { return {!hit.is_hit(), false, "miss", hit_text(hit)}; }

CaseResult expect_hit(const HardCase& c, const Hit& hit, TestKind test,
                      const std::vector<std::int32_t>& ids) {
  CaseResult result{false, false, fmt::format("hit {} at {}", ids_text(ids), c.exact_t),
                    hit_text(hit)};
  if (!hit.is_hit()) {
    return result;
  }
  if (std::find(ids.begin(), ids.end(), hit.prim) == ids.end()) {
    result.text += ", another triangle";
  } else if (!t_within_bound(c, hit, test)) {
    result.text += ", t is beyond its bound";
  } else {
    result.pass = true;
  }
  return result;
}

CaseResult expect_exact(const HardCase& c, const Hit& hit, TestKind test) {
  return c.exact_hit ? expect_hit(c, hit, test, c.exact_ids) : expect_miss(hit);
}

/// A choice that the machine makes where the case leaves one; the first that applies counts.
struct Policy {
  const char* name;
  bool (*applies)(const HardCase&);
  bool miss;  ///< the outcome; otherwise the exact result
};

constexpr std::array<Policy, 4> kPolicies{{
    {"invalid ray: no axis has a finite 1/d",
     [](const HardCase& c) { return !valid_ray(c.ray, kBinary32); }, true},
    {"hits behind the origin do not count",
     [](const HardCase& c) { return c.exact_hit && sgn(parse_rational(c.exact_t).value()) < 0; },
     true},
    {"t beyond the range is a miss",
     [](const HardCase& c) {
       return c.exact_hit &&
              std::isinf(round_to(kBinary32, to_double(parse_rational(c.exact_t).value())));
     },
     true},
    {"the interval is closed", [](const HardCase&) { return true; }, false},
}};

CaseResult expect_policy(const HardCase& c, const Hit& hit, TestKind test) {
  const auto* policy = std::find_if(kPolicies.begin(), kPolicies.end(),
                                    [&c](const Policy& p) { return p.applies(c); });
  CaseResult result = policy->miss ? expect_miss(hit) : expect_exact(c, hit, test);
  result.policy = true;
  result.text += fmt::format(" ({})", policy->name);
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

CaseResult expect_watertight(const HardCase& c, const Hit& hit, TestKind test) {
  CaseResult result = expect_exact(c, hit, test);
  if (!result.pass && has_t_junction(c.mesh)) {
    result.pass = result.policy = true;
    result.text += " (a T-junction: any result, but it ends)";
  }
  return result;
}

CaseResult expect_self(const HardCase& c, const Hit& hit, TestKind test) {
  CaseResult result = hit.is_hit() ? expect_exact(c, hit, test) : expect_miss(hit);
  result.policy = true;
  result.text += " (whoever spawns the ray moves its origin off the surface)";
  return result;
}

/// Shorter formats: exact arithmetic on the rounded case, and whatever the bounds of that format
/// explain.
CaseResult judge_rounded(const HardCase& c, const Hit& hit, const Format& format, TestKind test) {
  const ScaledFormat its = format_of(c, format, test);
  const Truth truth(scaled(c.mesh, its), format, "", Truth::kLooks, test);
  const Ray ray = scaled(c.ray, its.scale);
  const Truth::ExactHit exact = truth.exact(ray);
  Hit reference;
  if (exact.hit) {
    reference.prim = exact.prims.front();
    reference.t = static_cast<float>(exact.t);
  }
  const Verdict verdict = truth.judge(ray, scaled(hit, its.scale), reference);
  CaseResult result{verdict != Verdict::Unexplained, false, "miss", hit_text(hit)};
  if (exact.hit) {
    result.required = fmt::format("hit {} at {} within the bounds", ids_text(exact.prims),
                                  std::ldexp(exact.t, -its.scale));
  }
  return result;
}

}  // namespace

CaseResult judge_case(const HardCase& c, const Hit& hit, const Format& format, TestKind test) {
  if (hit.is_hit() && static_cast<std::size_t>(hit.prim) >= c.mesh.triangles.size()) {
    return {false, false, "a triangle of the case", hit_text(hit)};
  }
  if (!(format == kBinary32)) {
    return judge_rounded(c, hit, format, test);
  }
  switch (c.rule) {
    case CaseRule::Exact:
      return expect_exact(c, hit, test);
    case CaseRule::Watertight:
      return expect_watertight(c, hit, test);
    case CaseRule::NoHit:
      return expect_miss(hit);
    case CaseRule::Tie:
      return c.exact_hit ? expect_hit(c, hit, test,
                                      {*std::min_element(c.exact_ids.begin(), c.exact_ids.end())})
                         : expect_miss(hit);
    case CaseRule::Policy:
      return expect_policy(c, hit, test);
    case CaseRule::Self:
      return expect_self(c, hit, test);
  }
  return {};
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
    failures += result.pass ? 0 : 1;
    fmt::print("{:>4}  {:<58} {:<10} {:<8} {:<34} {}\n", c.n, c.name, rule_name(c.rule),
               !result.pass ? "FAIL" : (result.policy ? "policy" : "pass"), result.required,
               result.text);
  }
  fmt::print("{} cases, {} failed\n", cases.size(), failures);
  return failures;
}

}  // namespace ti
