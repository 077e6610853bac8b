// SPDX-License-Identifier: Apache-2.0
// The bounds hold what a format computes; the judge excuses nothing else.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "embree_devices.hpp"
#include "portable_random.hpp"
#include "reference_test.hpp"
#include "support.hpp"
#include "truth/truth.hpp"
#include "truth_test.hpp"

namespace {

using namespace ti;
using namespace ti::test;
using reference::Engine;
using reference::sphere;

/// Relative error of a quotient of exact numbers in Embree, which multiplies with a reciprocal:
/// RCPPS or VRCP14PS, off by at most 1.5 * 2^-12 (Intel SDM vol. 2 and AMD APM vol. 4, "RCPPS"),
/// and one Newton step r + r (1 - a r) (Embree, common/simd/vfloat4_sse2.h).  In units of 2^-24 the
/// step leaves 1.5^2 = 2.25; without FMA a r is rounded, then the sum, then the product: 5.25,
/// below 6 with the terms of higher order.  Which bits come out depends on the processor.
constexpr double kEmbreeQuotient = 6 * 0x1p-24;

bool is_quotient(float got, double exact) {
  return std::abs(double{got} - exact) <= kEmbreeQuotient * std::abs(exact);
}

std::int32_t exact_first(const Truth& truth, const Ray& ray) {
  const Truth::ExactHit exact = truth.exact(ray);
  return exact.hit ? exact.prims.front() : -1;
}
TEST_CASE(
    "Embree reports the numbering of the mesh, our weights, and any-hit rays as hit or miss") {
  const Truth truth(two_squares(), kF32, each_embree_device());
  std::vector<Ray> rays{up(1.5F, 0.5F), up(0.5F, 1.5F), up(5, 5), up(1.5F, 0.5F)};
  rays[1].tmin = 1.5F;
  rays[3].any = true;
  const auto hits = truth.trace(rays);
  CHECK(hits[0].prim == 0);
  CHECK(is_quotient(hits[0].t, 1.0));
  CHECK(is_quotient(hits[0].u, 0.5));   // weight of the second corner (2, 0)
  CHECK(is_quotient(hits[0].v, 0.25));  // weight of the third corner (2, 2)
  CHECK(hits[1].prim == 3);
  CHECK(is_quotient(hits[1].t, 2.0));
  CHECK(is_quotient(hits[1].u, 0.25));  // (2, 2)
  CHECK(is_quotient(hits[1].v, 0.5));   // (0, 2)
  CHECK_FALSE(hits[2].is_hit());
  CHECK(hits[3].prim == 0);
  CHECK(hits[3].t == 0.0F);
}

TEST_CASE("invalid rays must be misses, valid ones must not be called invalid") {
  const Truth truth(two_squares(), kF32, each_embree_device());
  const Hit hit{1.0F, 0.5F, 0.25F, 0, Status::Ok, 0};
  Hit invalid;
  invalid.status = Status::InvalidRay;
  std::vector<Ray> bad(6, up(1.5F, 0.5F));
  bad[0].o.x = kNan;
  bad[1].d.y = kInf;
  bad[2].tmin = kNan;
  bad[3].tmax = kNan;
  bad[4].d = {0, -0.0F, 0};
  bad[5].d = {0, 0, 0x1p-128F};  // 1/d overflows
  for (const Ray& ray : bad) {
    CHECK(judge(truth, ray, invalid) == Verdict::Agree);
    CHECK(judge(truth, ray, hit) == Verdict::Unexplained);
    CHECK_FALSE(truth.exact(ray).hit);
  }
  CHECK(judge(truth, up(1.5F, 0.5F), invalid) == Verdict::Unexplained);
  CHECK(judge(truth, up(5, 5), invalid) == Verdict::Unexplained);
}

TEST_CASE("the judge agrees with good hits and names each corruption Unexplained") {
  const Truth truth(two_squares(), kF32, each_embree_device());
  const Ray ray = up(1.5F, 0.5F);
  const Hit good{1.0F, 0.5F, 0.25F, 0, Status::Ok, 0};
  CHECK(judge(truth, ray, good) == Verdict::Agree);
  const auto with = [&good](auto change) {
    Hit hit = good;
    change(hit);
    return hit;
  };
  CHECK(judge(truth, ray, with([](Hit& h) { h.prim = 1; })) == Verdict::Unexplained);
  CHECK(judge(truth, ray, with([](Hit& h) { h.prim = 9; })) == Verdict::Unexplained);
  CHECK(judge(truth, ray, with([](Hit& h) { h.t = 1.001F; })) == Verdict::Unexplained);
  CHECK(judge(truth, ray, with([](Hit& h) { h.t = kInf; })) == Verdict::Unexplained);
  CHECK(judge(truth, ray, with([](Hit& h) { h.t = kNan; })) == Verdict::Unexplained);
  CHECK(judge(truth, ray, with([](Hit& h) { std::swap(h.u, h.v); })) == Verdict::Unexplained);
  CHECK(judge(truth, ray, with([](Hit& h) { h.prim = 2, h.t = 2.0F; })) == Verdict::Unexplained);
  CHECK(judge(truth, ray, with([](Hit& h) { h.status = Status::Watchdog; })) ==
        Verdict::Unexplained);
  CHECK(judge(truth, ray, {}) == Verdict::Unexplained);
  CHECK(judge(truth, up(5, 5), good) == Verdict::Unexplained);
  Ray any = ray;
  any.any = true;
  CHECK(judge(truth, any, {0, 0, 0, 0, Status::Ok, 0}) == Verdict::Agree);
  CHECK(judge(truth, any, {}) == Verdict::Unexplained);
  any.o.x = 5;
  CHECK(judge(truth, any, {0, 0, 0, 0, Status::Ok, 0}) == Verdict::Unexplained);
}

TEST_CASE("a lost hit is Unexplained even where Embree is wrong in another way") {
  const Truth truth(two_squares(), kF32);
  const Ray ray = up(1.5F, 0.5F);  // hits 0, then 2
  const Hit farther{2.0F, 0.5F, 0.25F, 2, Status::Ok, 0};
  CHECK(truth.judge(ray, farther, {2.0F, 0, 0, 3, Status::Ok, 0}) == Verdict::Unexplained);
  CHECK(truth.judge(ray, farther, {}) == Verdict::Unexplained);
  CHECK(truth.judge(ray, {}, {1.0F, 0, 0, 1, Status::Ok, 0}) == Verdict::Unexplained);
}

TEST_CASE("a hit one unit outside the closed interval is Unexplained, on its ends it agrees") {
  const Truth truth(two_squares(), kF32, each_embree_device());
  Ray ray = up(1.5F, 0.5F);
  ray.tmin = ray.tmax = 1.0F;
  const Hit hit{1.0F, 0.5F, 0.25F, 0, Status::Ok, 0};
  const Verdict closed = judge(truth, ray, hit);
  CHECK((closed == Verdict::Agree || closed == Verdict::EmbreeWrong));
  ray.tmin = ray.tmax = std::nextafter(1.0F, 2.0F);
  CHECK(judge(truth, ray, hit) == Verdict::Unexplained);
}

TEST_CASE("equal triangles: the lowest id, a higher one is Unexplained whatever Embree says") {
  Mesh mesh = two_squares();
  mesh.triangles.push_back(mesh.triangles[0]);
  mesh.triangles.push_back({2, 1, 0});  // triangle 0 wound the other way: its t may round otherwise
  const Truth truth(mesh, kF32);
  const Ray ray = up(1.5F, 0.5F);
  const Hit low{1.0F, 0.5F, 0.25F, 0, Status::Ok, 0};
  Hit high = low;
  high.prim = 4;
  for (const std::int32_t embree : {0, 4, 5}) {
    CHECK(truth.judge(ray, low, {1.0F, 0.5F, 0.25F, embree, Status::Ok, 0}) ==
          (embree == 0 ? Verdict::Agree : Verdict::Tie));
    CHECK(truth.judge(ray, high, {1.0F, 0.5F, 0.25F, embree, Status::Ok, 0}) ==
          Verdict::Unexplained);
  }
}

TEST_CASE("one ulp from an edge a miss or a false hit is an Edge, well away it is Unexplained") {
  const Mesh mesh = [] {
    Mesh m;
    m.vertices = {{0.1F, 0.2F, 1.3F}, {2.7F, 0.3F, 1.1F}, {0.4F, 2.9F, 1.7F}};
    m.triangles = {{0, 1, 2}};
    return m;
  }();
  const Truth truth(mesh, kF32);
  Ray ray{{0.3F, 0.7F, -2.1F}, 0.0F, {0, 0, 0}, kInf, false};
  const auto aim = [&](double u, double v) {
    for (int k = 0; k < 3; ++k) {
      ray.d[k] = static_cast<float>((1 - u - v) * double{mesh.vertices[0][k]} +
                                    u * double{mesh.vertices[1][k]} +
                                    v * double{mesh.vertices[2][k]} - double{ray.o[k]});
    }
  };
  for (const double along : {0.2, 0.5, 0.8}) {
    aim(along, 1.0 - along);
    CHECK(truth.judge(ray, {}, {1.0F, 0, 0, 0, Status::Ok, 0}) != Verdict::Unexplained);
    CHECK(truth.judge(
              ray,
              {1.0F, static_cast<float>(along), static_cast<float>(1.0 - along), 0, Status::Ok, 0},
              {}) != Verdict::Unexplained);
    aim(along, 1.0 - along - 1e-4);
    CHECK(truth.judge(ray, {}, {1.0F, 0, 0, 0, Status::Ok, 0}) == Verdict::Unexplained);
    aim(along, 1.0 - along + 1e-4);
    CHECK(truth.judge(ray,
                      {1.0F, static_cast<float>(along), static_cast<float>(1.0001 - along), 0,
                       Status::Ok, 0},
                      {}) == Verdict::Unexplained);
  }
  // Exactly one of hit and miss is right; the other is the Edge.
  aim(0.5, 0.5);
  const bool hit = truth.exact(ray).hit;
  const Verdict wrong = hit ? truth.judge(ray, {}, {1.0F, 0.5F, 0.5F, 0, Status::Ok, 0})
                            : truth.judge(ray, {1.0F, 0.5F, 0.5F, 0, Status::Ok, 0}, {});
  CHECK(wrong == Verdict::Edge);
}

TEST_CASE("a ray almost in the plane is Grazing") {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, -1}, {0, 1, -1}};
  mesh.triangles = {{0, 1, 2}};
  const Truth truth(mesh, kF32);
  const Ray ray{{-3, -3, 7}, 0.0F, {1, 1, std::nextafter(-2.0F, -3.0F)}, kInf, false};
  CHECK_FALSE(truth.exact(ray).hit);
  const Ray hit_ray{{-0.25F, -0.25F, std::nextafter(0.5F, 1.0F)},
                    0.0F,
                    {1, 1, std::nextafter(-2.0F, 0.0F)},
                    kInf,
                    false};
  const Verdict verdict = truth.judge(hit_ray, {}, {1.0F, 0, 0, 0, Status::Ok, 0});
  CHECK((verdict == Verdict::Grazing || verdict == Verdict::EmbreeWrong));
}

TEST_CASE("the bounds hold all that a format computes, and the exact result") {
  constexpr unsigned kSeed = 20260101;
  CAPTURE(kSeed);
  constexpr Modes kZero{.toward_zero = true};
  constexpr Modes kFlush{.flush = true};
  constexpr Modes kBoth{.toward_zero = true, .flush = true};
  for (const Format format :
       {kF32, Format{7, 16}, Format{5, 10}, Format{8, 10}, Format{4, 6}, Format{6, 4},
        Format{8, 23, kBoth}, Format{5, 10, kZero}, Format{5, 10, kFlush}, Format{6, 4, kBoth}}) {
    CAPTURE(name_of(format));
    std::mt19937 rng(kSeed);
    const auto unit = [&rng] { return 2.0F * test::unit_random(rng) - 1.0F; };
    const BoundedOps ops(format);
    int certain = 0;
    int open = 0;
    for (int i = 0; i < 20000; ++i) {
      const float flatness =
          i % 3 == 0 ? std::ldexp(1.0F, -format.frac_bits / 2) : 1.0F;  // every third a sliver
      // Every fifth so small that products underflow.
      const float scale = i % 5 == 0 ? std::ldexp(1.0F, (1 - format.bias()) / 2) : 1.0F;
      Mesh mesh;
      mesh.vertices = {scale * on_sphere(rng), scale * on_sphere(rng), {}};
      mesh.vertices[2] = mesh.vertices[0] + 0.4F * (mesh.vertices[1] - mesh.vertices[0]) +
                         scale * flatness * on_sphere(rng);
      mesh.triangles = {{0, 1, 2}};
      // Aimed near the triangle, at an edge every second time.
      const float u = 0.5F + 0.6F * unit();
      const float v = i % 2 == 0 ? 1.0F - u : 0.5F + 0.6F * unit();
      const glm::vec3 target =
          (1.0F - u - v) * mesh.vertices[0] + u * mesh.vertices[1] + v * mesh.vertices[2];
      const glm::vec3 origin = 2.0F * scale * on_sphere(rng);
      const Ray ray = round_ray({origin, 0.0F, target - origin, kInf, false}, format);
      Corners tri;
      for (std::size_t k = 0; k < 3; ++k) {
        tri[k] = round_ray({mesh.vertices[k], 0, {}, 0, false}, format).o;
      }
      const auto constants = test_constants(tri, format);
      if (!constants) {
        continue;
      }
      const TestBand band = test_band(ops, *constants, ray);
      const auto result = Engine(mesh, format).test(0, ray);
      const auto met = exact_meeting(ray, tri);
      const bool ahead = met && sgn(met->t) >= 0;
      const bool accepted = result && std::isfinite(result->t);
      CAPTURE(i);
      CHECK((!accepted || band.possible));
      CHECK((!ahead || band.possible));
      CHECK((!band.possible || may_meet(ops, *constants, ray)));
      CHECK((!band.certain || (accepted && ahead)));
      if (accepted && std::isfinite(band.t.e)) {
        CHECK(std::abs(result->t - band.t.v) <= band.t.e);
        CHECK(std::abs(result->u - band.u.v) <= band.u.e);
        CHECK(std::abs(result->v - band.v.v) <= band.v.e);
      }
      certain += band.certain ? 1 : 0;
      open += band.possible && !band.certain ? 1 : 0;
    }
    CHECK(open > 0);
    CHECK((certain > 0 || format.frac_bits < 6));
    CHECK((format.frac_bits < 23 || open < 14000));
  }
}

TEST_CASE("over a closed mesh everything an honest engine reports is explained") {
  constexpr unsigned kSeed = 7;
  CAPTURE(kSeed);
  for (const Format format : {kF32, Format{7, 16}, Format{5, 10}}) {
    CAPTURE(format.frac_bits);
    std::mt19937 rng(kSeed);
    const Mesh mesh = sphere(2);
    const Engine engine(mesh, format);
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    for (int i = 0; i < 6000; ++i) {
      const glm::vec3 origin = (i % 2 == 0 ? 0.3F : 3.0F) * on_sphere(rng);
      const glm::vec3 corner = mesh.vertices[rng() % mesh.vertices.size()];
      rays.push_back({origin, 0.0F, i % 3 == 0 ? corner - origin : 0.8F * on_sphere(rng) - origin,
                      kInf, i % 5 == 0});
      hits.push_back(engine.trace(rays.back()));
    }
    for (const std::string& device : embree_devices()) {
      CAPTURE(device);
      const TruthReport report = Truth(mesh, format, device).compare(rays, hits);
      CHECK(report.rays == 6000);
      CHECK(report.agree + report.embree_wrong + report.tie + report.edge + report.grazing == 6000);
      CHECK(report.agree > 3000);
      CHECK(report.unexplained == 0);
      for (const std::string& line : report.examples) {
        MESSAGE(line);
      }
    }
  }
}

TEST_CASE("a triangle that the engine skips is Unexplained wherever it is hit well inside") {
  constexpr unsigned kSeed = 11;
  CAPTURE(kSeed);
  std::mt19937 rng(kSeed);
  const Mesh mesh = sphere(2);
  const Engine engine(mesh, kF32);
  const Truth truth(mesh, kF32, each_embree_device());
  for (std::size_t prim = 0; prim < mesh.triangles.size(); ++prim) {
    const glm::vec3 centre =
        (mesh.vertex(prim, 0) + mesh.vertex(prim, 1) + mesh.vertex(prim, 2)) / 3.0F;
    const glm::vec3 origin = (prim % 2 == 0 ? 0.3F * on_sphere(rng) : 3.0F * centre);
    Ray ray{origin, 0.0F, centre - origin, kInf, false};
    const auto id = static_cast<std::int32_t>(prim);
    CHECK(judge(truth, ray, engine.trace(ray)) == Verdict::Agree);
    CHECK(exact_first(truth, ray) == id);
    CHECK(judge(truth, ray, engine.trace(ray, id)) == Verdict::Unexplained);
    ray.tmax = 1.5F;
    ray.any = true;
    CHECK(judge(truth, ray, engine.trace(ray, id)) == Verdict::Unexplained);
  }
}

TEST_CASE("a report counts rays without an answer and gives at most eight lines to paste") {
  const Truth truth(two_squares(), kF32, each_embree_device());
  const std::vector<Ray> rays(20, up(1.5F, 0.5F));
  const std::vector<Hit> hits(15);
  const TruthReport report = truth.compare(rays, hits);
  CHECK(report.unexplained == 20);
  REQUIRE(report.examples.size() == 8);
  CHECK(report.examples[0].starts_with(R"({"ray": 0, "o": ["3FC00000", "3F000000", "00000000"])"));
}

}  // namespace
