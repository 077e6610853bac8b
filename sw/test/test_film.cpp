// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "render/film.hpp"

namespace ti {
namespace {

TEST_CASE("film: a pixel is the mean of its samples") {
  Film film(2, 2);
  film.add(1, {1.0, 2.0, 3.0});
  film.add(1, {3.0, 2.0, 0.0});
  film.add(3, {0.5, 0.0, 0.0});
  const auto radiance = film.radiance();
  CHECK(radiance[0] == glm::vec3(0.0F));
  CHECK(radiance[1] == glm::vec3(2.0F, 2.0F, 1.5F));
  CHECK(radiance[3] == glm::vec3(0.5F, 0.0F, 0.0F));
}

TEST_CASE("film: what is no light is refused") {
  Film film(2, 1);
  CHECK_THROWS_AS(film.add(2, {0, 0, 0}), std::out_of_range);
  for (const double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    CHECK_THROWS_AS(film.add(0, {0, bad, 0}), std::domain_error);
}

TEST_CASE("film: exposure follows the light, so that a picture does not depend on its unit") {
  std::vector<glm::vec3> picture;
  for (int i = 0; i < 300; ++i) picture.emplace_back(0.001F * static_cast<float>(i));
  std::vector<glm::vec3> bright = picture;
  for (glm::vec3& c : bright) c *= 1024.0F;
  CHECK(exposure_of(picture) == doctest::Approx(1024.0 * exposure_of(bright)));
  CHECK(exposure_of(std::vector<glm::vec3>(9, glm::vec3(0.36F))) == doctest::Approx(0.5));
  CHECK(exposure_of(std::vector<glm::vec3>(9, glm::vec3(0.0F))) == 1.0);
  // A lamp in the picture does not darken it.
  std::vector<glm::vec3> lamp(200, glm::vec3(0.18F));
  lamp[7] = glm::vec3(1e6F);
  CHECK(exposure_of(lamp) == doctest::Approx(1.0));
}

TEST_CASE("film: tones stay in 0 to 1, in their order, without a step") {
  std::vector<glm::vec3> ramp;
  for (int i = 0; i <= 4000; ++i) ramp.emplace_back(0.001F * static_cast<float>(i));
  const auto toned = tone_mapped(ramp, 1.0);
  for (std::size_t i = 1; i < toned.size(); ++i) {
    REQUIRE(toned[i].x > toned[i - 1].x);
    REQUIRE(toned[i].x - toned[i - 1].x < 0.0011F);
  }
  CHECK(toned[400].x == doctest::Approx(0.4F));
  CHECK(toned.back().x < 1.0F);
}

}  // namespace
}  // namespace ti
