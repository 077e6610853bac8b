// SPDX-License-Identifier: Apache-2.0
// No ray that leaves a triangle meets it again, neither exactly nor by the test of the model, in
// any number format, near the origin and far from it.
#include <doctest/doctest.h>
#include <gmpxx.h>

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "accel/prepare.hpp"
#include "model/fp.hpp"
#include "model/ist1.hpp"
#include "model/ist2.hpp"
#include "scene/geometry.hpp"
#include "scene/random.hpp"
#include "scene/rays.hpp"
#include "truth/exact.hpp"
#include "volume.hpp"

namespace {

using namespace ti;

constexpr std::size_t kTriangles = 40;
constexpr std::size_t kRays = test::volume(20000);

/// Triangles of about `size`, tilted in all ways, with their centre at `middle`; `aspect` times as
/// long as high, or any up to 10 for 0.
Mesh tilted(double size, const glm::dvec3& middle, double aspect, std::uint64_t seed) {
  Mesh mesh;
  for (std::size_t i = 0; mesh.triangles.size() < kTriangles; ++i) {
    Random random(seed, i);
    const glm::dvec3 e0 = random.ball();
    glm::dvec3 e1 = random.ball();
    if (glm::length(glm::cross(e0, e1)) < 0.2) continue;
    if (aspect > 0.0) {
      const glm::dvec3 across = glm::normalize(glm::cross(glm::cross(e0, e1), e0));
      e1 = 0.4 * e0 + across * (glm::length(e0) / aspect);
    }
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const glm::dvec3 p = middle - size * (e0 + e1) / 3.0;
    mesh.vertices.insert(mesh.vertices.end(),
                         {glm::vec3(p), glm::vec3(p + size * e0), glm::vec3(p + size * e1)});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

glm::vec3 rounded(const glm::dvec3& p, Format format) {
  return {round_to(format, p.x), round_to(format, p.y), round_to(format, p.z)};
}

/// The test of the model on one triangle.
template <class F>
std::optional<Hit> test(const PreparedTriangles& prepared, std::size_t triangle, const Ray& ray) {
  const auto vec = [](const glm::vec3& p) {
    return Vec3<F>{F::from_double(p.x), F::from_double(p.y), F::from_double(p.z)};
  };
  const Vec3<F> d = vec(ray.d);
  const F far = F::from_double(std::numeric_limits<double>::infinity());
  const auto a = model::pass_a<TestKind::Local>(prepared.planes[triangle], vec(ray.o), d,
                                                model::TestRange<F>{F{}, far});
  if (!a) return {};
  const auto b = model::pass_b(prepared.planes[triangle], prepared.barys[triangle], d, *a);
  if (!b) return {};
  const auto c = model::pass_c(*b);
  if (!c) return {};
  return Hit{.t = c->t.to_float(),
             .u = c->u.to_float(),
             .v = c->v.to_float(),
             .prim = static_cast<std::int32_t>(prepared.planes[triangle].prim)};
}

mpq_class dot(const Vec3<mpz_class>& n, const glm::vec3& p) {
  return n[0] * mpq_class(p.x) + n[1] * mpq_class(p.y) + n[2] * mpq_class(p.z);
}

/// Rays that meet what they leave.
struct SelfHits {
  std::size_t rays = 0, plane = 0, exact = 0, model = 0;
};

/// Shoots at the triangles, lets one ray leave each hit, and tests it against the triangle it
/// leaves.
template <class F>
SelfHits self_hits(const Mesh& mesh, double size, bool grazing = false) {
  const Format format{F::kExpBits, F::kFracBits, F::modes()};
  const PreparedTriangles prepared = prepare_triangles(mesh, format, TestKind::Local);
  REQUIRE(prepared.planes.size() == kTriangles);
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  for (std::size_t i = 0; hits.size() < kRays; ++i) {
    REQUIRE(i < 40 * kRays);
    Random random(5, i);
    const std::size_t at = i % kTriangles;
    const glm::dvec3 p[3] = {mesh.vertex(at, 0), mesh.vertex(at, 1), mesh.vertex(at, 2)};
    const double a = std::sqrt(random.uniform());
    const double b = a * random.uniform();
    // All over the triangle from afar, and ever nearer to its centre from nearby: there a point and
    // a distance are small although the vertices are not.
    const double near = std::exp2(-16.0 * random.uniform());
    const glm::dvec3 centre = (p[0] + p[1] + p[2]) / 3.0;
    const glm::dvec3 target =
        centre + near * (p[0] + a * (p[1] - p[0]) + b * (p[2] - p[1]) - centre);
    const glm::dvec3 origin = target + 2.0 * size * near * random.ball();
    const Ray ray{.o = rounded(origin, format),
                  .d = rounded(glm::normalize(target - origin), format)};
    if (const auto hit = test<F>(prepared, at, ray)) {
      rays.push_back(ray);
      hits.push_back(*hit);
    }
  }
  std::vector<Ray> leaving = diffuse_rays(mesh, format, rays, hits, 9);
  REQUIRE(leaving.size() == kRays);
  SelfHits count;
  for (std::size_t i = 0; i < kRays; ++i) {
    const auto at = static_cast<std::size_t>(hits[i].prim);
    Ray ray = leaving[i];
    if (grazing) {  // along the plane, off it by a few units in the last place either way
      const glm::dvec3 n = departure(mesh, rays[i], hits[i], format).normal;
      Random random(11, i);
      const glm::dvec3 along = glm::normalize(glm::cross(n, random.ball()));
      ray.d = glm::vec3(along + n * (0.5 * random.uniform() * std::exp2(-F::kFracBits)));
    }
    ray.o = rounded(ray.o, format);
    ray.d = rounded(ray.d, format);
    const Corners corners{rounded(mesh.vertex(at, 0), format), rounded(mesh.vertex(at, 1), format),
                          rounded(mesh.vertex(at, 2), format)};
    const auto n = exact_normal(corners);
    const mpq_class height = dot(n, corners[0]) - dot(n, ray.o);
    const mpq_class rate = dot(n, ray.d);
    // Rounding may turn a grazing direction into the plane; then it must be past the triangle
    // there.
    const bool leaves = sgn(rate) * sgn(dot(n, rays[i].d)) <= 0;
    ++count.rays;
    count.plane += leaves && (sgn(height) == 0 || sgn(height) == sgn(rate)) ? 1 : 0;
    const auto met = exact_meeting(ray, corners);
    count.exact += met && sgn(met->t) >= 0 ? 1 : 0;
    count.model += test<F>(prepared, at, ray) ? 1 : 0;
  }
  return count;
}

template <class F>
void check_none(double size, double away, double aspect = 0.0) {
  CAPTURE(aspect);
  CAPTURE(F::kFracBits);
  CAPTURE(away);
  for (const bool grazing : {false, true}) {
    CAPTURE(grazing);
    const SelfHits count =
        self_hits<F>(tilted(size, {away, -0.7 * away, 0.4 * away}, aspect, 1), size, grazing);
    CAPTURE(count.plane);
    CAPTURE(count.exact);
    CAPTURE(count.model);
    CHECK(count.rays == kRays);
    CHECK(count.plane + count.exact + count.model == 0);
  }
}

TEST_CASE("no ray meets the triangle of 2,000 units that it leaves") {
  check_none<Fp<8, 23>>(2000.0, 0.0);
  check_none<Fp<8, 23>>(2000.0, 1e6);
  check_none<Fp<7, 16>>(2000.0, 0.0);
  check_none<Fp<7, 16>>(2000.0, 1e5);
  check_none<Fp<5, 10>>(2000.0, 0.0);
  check_none<Fp<5, 10>>(2000.0, 2e4);
}

TEST_CASE("no ray meets the small triangle that it leaves, far from the origin or near it") {
  check_none<Fp<8, 23>>(1.0, 0.0);
  check_none<Fp<8, 23>>(1.0, 1e4);
  check_none<Fp<7, 16>>(1.0, 1e2);
  check_none<Fp<5, 10>>(1.0, 4.0);
}

TEST_CASE("no ray meets the sliver that it leaves") {
  check_none<Fp<8, 23>>(2000.0, 0.0, 0x1p19);
  check_none<Fp<8, 23>>(2000.0, 0.0, 0x1p16);
  check_none<Fp<7, 16>>(2000.0, 0.0, 0x1p12);
  check_none<Fp<7, 16>>(2000.0, 0.0, 0x1p9);
  check_none<Fp<5, 10>>(2000.0, 0.0, 0x1p6);
  check_none<Fp<5, 10>>(2000.0, 0.0, 0x1p3);
}

TEST_CASE("no ray meets the triangle that it leaves where operations round toward zero, or flush") {
  constexpr Modes kZero{.toward_zero = true};
  constexpr Modes kBoth{.toward_zero = true, .flush = true};
  check_none<Fp<8, 23, kBoth>>(2000.0, 1e6);
  check_none<Fp<8, 23, kBoth>>(1.0, 1e4);
  check_none<Fp<7, 16, kZero>>(2000.0, 0.0, 0x1p9);
  check_none<Fp<5, 10, kBoth>>(2000.0, 0.0);
  check_none<Fp<5, 10, kZero>>(1.0, 4.0);
}

TEST_CASE("rays leave in numbers of the engine's format") {
  const Format format{5, 10};
  const Mesh mesh = tilted(1.0, {}, 0.0, 3);
  const Ray ray{.o = {0.0F, 0.0F, 5.0F}, .d = {0.0F, 0.0F, -1.0F}};
  const Hit hit{.t = 5.0F, .u = 0.3F, .v = 0.3F, .prim = 0};
  const Departure out = departure(mesh, ray, hit, format);
  CHECK(out.origin == rounded(out.origin, format));
  CHECK(glm::distance(glm::dvec3(out.origin), surface_at(mesh, ray, hit).position) > 0x1p-10);
}

}  // namespace
