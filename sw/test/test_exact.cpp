// SPDX-License-Identifier: Apache-2.0
// What doubles tell of a meeting is what integers find.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "reference_test.hpp"
#include "scene/aimed_rays.hpp"
#include "truth/exact.hpp"

namespace ti {
namespace {

using Answer = QuickMeeting::Answer;

constexpr std::array<Aim, 5> kAims{Aim::Uniform, Aim::Edges, Aim::Vertices, Aim::Grazing, Aim::Far};

/// Checks one meeting; whether doubles could tell.
bool agrees(const Ray& ray, const Corners& triangle) {
  const QuickMeeting quick = quick_meeting(ray, triangle);
  const auto exact = exact_meeting(ray, triangle);
  if (quick.answer == Answer::Open) return false;
  REQUIRE((quick.answer == Answer::Meets) == exact.has_value());
  if (!exact) return true;
  REQUIRE_FALSE(exact->boundary);
  REQUIRE(abs(mpq_class(quick.t) - exact->t) <= mpq_class(quick.error));
  return true;
}

TEST_CASE("quick meetings are those of integers, for rays at edges and vertices too") {
  const Mesh mesh = reference::sphere(2);
  for (const Aim aim : kAims) {
    const AimedRays rays(mesh, aim, 5);
    int open = 0;
    for (std::uint64_t i = 0; i < 60; ++i) {
      for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
        open += agrees(rays(i), mesh.corners(k)) ? 0 : 1;
    }
    CHECK(open < 200);  // of 60 rays and 320 triangles: few but at vertices
  }
}

TEST_CASE("quick meetings are those of integers for numbers of every size") {
  std::mt19937 random(3);
  const auto number = [&random](int low, int high) {
    const int exponent = low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
    const float size = std::ldexp(1.0F + static_cast<float>(random() % 8) / 8.0F, exponent);
    return random() % 2 == 0 ? size : -size;
  };
  int told = 0;
  for (const auto& [low, high] : {std::pair{-149, -140}, {-20, 20}, {100, 126}, {-149, 126}}) {
    for (int i = 0; i < 3000; ++i) {
      const auto point = [&] {
        return glm::vec3(number(low, high), number(low, high), number(low, high));
      };
      const Ray ray{.o = point(), .d = point()};
      const glm::vec3 shared = point();
      const Corners triangle{shared, point(), random() % 8 == 0 ? shared : point()};
      told += agrees(ray, triangle) ? 1 : 0;
    }
  }
  CHECK(told > 8000);
}

TEST_CASE("a ray in the plane, along an edge or through a corner is left to integers") {
  const Corners triangle{glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)};
  for (const Ray& ray : {Ray{.o = {-1, 0, 0}, .d = {1, 0, 0}}, Ray{.o = {0, 0, -1}, .d = {0, 0, 1}},
                         Ray{.o = {0.5F, 0, -1}, .d = {0, 0, 1}}})
    CHECK(quick_meeting(ray, triangle).answer == Answer::Open);
  const Ray inside{.o = {0.25F, 0.25F, -2}, .d = {0, 0, 1}};
  CHECK(quick_meeting(inside, triangle).answer == Answer::Meets);
  CHECK(quick_meeting(inside, triangle).t == 2.0);
}

}  // namespace
}  // namespace ti
