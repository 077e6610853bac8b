// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/film.hpp"
#include "scene/random.hpp"

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

TEST_CASE("film: a refusal names the pixel and keeps the picture as it was") {
  Film film(20, 20);
  film.add(137, {1.0, 2.0, 3.0});
  try {
    film.add(137, {0.5, std::nan(""), 0.5});
    FAIL("NaN is taken for light");
  } catch (const std::domain_error& e) {
    CHECK(std::string(e.what()).find("pixel 137 ") != std::string::npos);
  }
  CHECK(film.radiance()[137] == glm::vec3(1.0F, 2.0F, 3.0F));
}

TEST_CASE("film: a pixel has the same bits whatever comes between its samples") {
  constexpr std::uint32_t kPixels = 16;
  constexpr std::uint32_t kSamples = 50;
  const auto light = [](std::uint32_t pixel, std::uint32_t sample) {
    Random random(pixel, sample);
    const double scale = std::exp2(40.0 * random.uniform() - 20.0);
    return scale * glm::dvec3(random.uniform(), random.uniform(), random.uniform());
  };
  Film by_pixel(4, 4);
  Film by_sample(4, 4);
  for (std::uint32_t p = 0; p < kPixels; ++p)
    for (std::uint32_t s = 0; s < kSamples; ++s) by_pixel.add(p, light(p, s));
  for (std::uint32_t s = 0; s < kSamples; ++s)
    for (std::uint32_t p = 0; p < kPixels; ++p)
      by_sample.add(kPixels - 1 - p, light(kPixels - 1 - p, s));
  CHECK(by_pixel.radiance() == by_sample.radiance());
}

TEST_CASE("film: sums are of double, so that many dim samples count beside a bright one") {
  Film film(1, 1);
  film.add(0, glm::dvec3(0x1p24));
  for (int i = 1; i < 1 << 12; ++i) film.add(0, glm::dvec3(0.5));
  CHECK(film.radiance()[0].x == static_cast<float>((0x1p24 + 0.5 * 4095) / 4096));
}

TEST_CASE("film: exposure follows the light, so that a picture does not depend on its unit") {
  std::vector<glm::vec3> picture;
  for (int i = 0; i < 300; ++i) picture.emplace_back(0.001F * static_cast<float>(i));
  std::vector<glm::vec3> bright = picture;
  for (glm::vec3& c : bright) c *= 1024.0F;
  CHECK(exposure_of(picture) == doctest::Approx(1024.0 * exposure_of(bright)));
  CHECK(exposure_of(std::vector<glm::vec3>(9, glm::vec3(0.36F))) == doctest::Approx(0.5));
  CHECK(exposure_of(std::vector<glm::vec3>(9, glm::vec3(0.0F))) == 1.0);
  // Black pixels do not count.
  std::vector<glm::vec3> half(10, glm::vec3(0.0F));
  half[3] = half[8] = glm::vec3(0.72F);
  CHECK(exposure_of(half) == doctest::Approx(0.25));
  // The mean is that of logarithms: of 1 and 4 it is 2.
  std::vector<glm::vec3> uneven(10, glm::vec3(1.0F));
  for (std::size_t i = 0; i < 5; ++i) uneven[i] = glm::vec3(4.0F);
  CHECK(exposure_of(uneven) == doctest::Approx(0.09));
  CHECK(exposure_of({}) == 1.0);
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
  CHECK(toned[1000].x == doctest::Approx(1.0 - 0.5 * std::exp(-1.0)));
  // Exposed before it is bent; a black picture stays black.
  CHECK(tone_mapped(ramp, 0.25)[4000].x == toned[1000].x);
  CHECK(tone_mapped({glm::vec3(0.0F)}, exposure_of({glm::vec3(0.0F)}))[0] == glm::vec3(0.0F));
}

}  // namespace
}  // namespace ti
