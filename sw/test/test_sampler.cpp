// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "render/sampler.hpp"

namespace ti {
namespace {

std::vector<glm::dvec2> samples(Dimension dimension, int count, std::uint32_t pixel = 7) {
  std::vector<glm::dvec2> out;
  for (int i = 0; i < count; ++i)
    out.push_back(Sampler(1, pixel, static_cast<std::uint32_t>(i)).get2(dimension));
  return out;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double sum_ab = 0.0;
  double sum_a = 0.0;
  double sum_b = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum_ab += (a[i] - 0.5) * (b[i] - 0.5);
    sum_a += (a[i] - 0.5) * (a[i] - 0.5);
    sum_b += (b[i] - 0.5) * (b[i] - 0.5);
  }
  return sum_ab / std::sqrt(sum_a * sum_b);
}

TEST_CASE("sampler: each power of two of samples has one point in each elementary interval") {
  for (const int power : {0, 1, 2, 4, 7, 10}) {
    const int count = 1 << power;
    for (const Dimension dimension : {Dimension{0, Purpose::Pixel}, Dimension{3, Purpose::Diffuse},
                                      Dimension{1, Purpose::Light}}) {
      const auto points = samples(dimension, count);
      for (int columns = 0; columns <= power; ++columns) {
        const int across = 1 << columns;
        const int down = count / across;
        std::set<std::pair<int, int>> boxes;
        for (const glm::dvec2& p : points)
          boxes.insert({static_cast<int>(p.x * across), static_cast<int>(p.y * down)});
        CHECK(boxes.size() == points.size());
      }
    }
  }
}

TEST_CASE("sampler: numbers are in [0, 1) and belong to what they are for") {
  const Sampler sampler(1, 5, 3);
  CHECK(sampler.get2({0, Purpose::Pixel}) == Sampler(1, 5, 3).get2({0, Purpose::Pixel}));
  CHECK(sampler.get1({0, Purpose::Pixel}) == sampler.get2({0, Purpose::Pixel}).x);
  CHECK(sampler.get2({0, Purpose::Pixel}) != sampler.get2({1, Purpose::Pixel}));
  CHECK(sampler.get2({0, Purpose::Pixel}) != sampler.get2({0, Purpose::Lens}));
  CHECK(sampler.get2({0, Purpose::Pixel}) != Sampler(1, 6, 3).get2({0, Purpose::Pixel}));
  CHECK(sampler.get2({0, Purpose::Pixel}) != Sampler(2, 5, 3).get2({0, Purpose::Pixel}));
  for (std::uint32_t i = 0; i < 10000; ++i) {
    const glm::dvec2 p = Sampler(i, i, i).get2({static_cast<int>(i % 9), Purpose::Glossy});
    REQUIRE(p.x >= 0.0);
    REQUIRE(p.x < 1.0);
    REQUIRE(p.y >= 0.0);
    REQUIRE(p.y < 1.0);
    REQUIRE(p.x * 0x1p32 == std::floor(p.x * 0x1p32));
    REQUIRE(p.y * 0x1p32 == std::floor(p.y * 0x1p32));
  }
}

TEST_CASE("sampler: every machine draws these numbers") {
  // Of another program, which takes Sobol's columns from binomials and reverses bits as text.
  struct Drawn {
    std::uint64_t seed;
    std::uint32_t pixel, sample;
    Dimension dimension;
    std::uint32_t x, y;
  };
  for (const Drawn& d : {
           Drawn{1, 0, 0, {0, Purpose::Pixel}, 0xA1980CE1U, 0xF5824FAEU},
           {1, 0, 1, {0, Purpose::Pixel}, 0x76E82213U, 0x0021F31DU},
           {1, 5, 3, {0, Purpose::Lens}, 0xF1922EB8U, 0x0C9505B7U},
           {1, 65535, 1023, {3, Purpose::Diffuse}, 0x2AB2AC8DU, 0xEF7AFD45U},
           {~0ULL, ~0U, ~0U, {7, Purpose::Occlusion}, 0xD0102FE9U, 0xD7D37720U},
           {42, 1234567, 17, {1, Purpose::Light}, 0xB385671FU, 0xEECC4B8DU},
       }) {
    const glm::dvec2 p = Sampler(d.seed, d.pixel, d.sample).get2(d.dimension);
    CHECK(p.x * 0x1p32 == d.x);
    CHECK(p.y * 0x1p32 == d.y);
  }
}

/// Pearson's statistic of pairs in 16 x 16 equal boxes: for uniform, independent pairs its mean is
/// 255 and its standard deviation 22.6.
template <typename Pair>
double spread(int count, const Pair& pair) {
  std::vector<int> boxes(256, 0);
  for (int i = 0; i < count; ++i) {
    const glm::dvec2 p = pair(static_cast<std::uint32_t>(i));
    ++boxes[static_cast<std::size_t>(p.x * 16.0) * 16 + static_cast<std::size_t>(p.y * 16.0)];
  }
  const double expected = count / 256.0;
  double sum = 0.0;
  for (const int n : boxes) sum += (n - expected) * (n - expected) / expected;
  return sum;
}

TEST_CASE("sampler: each sample alone is uniform over the pixels, and so is each pair of them") {
  constexpr int kPixels = 1 << 15;
  const auto at = [](std::uint32_t pixel, std::uint32_t sample, Dimension d) {
    return Sampler(1, pixel, sample).get2(d);
  };
  const Dimension pixel{0, Purpose::Pixel};
  for (const std::uint32_t sample : {0U, 1U, 2U, 255U}) {
    // The two numbers of a point, those of two purposes, two bounces and of neighbours.
    for (const double statistic : {
             spread(kPixels, [&](std::uint32_t i) { return at(i, sample, pixel); }),
             spread(kPixels,
                    [&](std::uint32_t i) {
                      return glm::dvec2(at(i, sample, pixel).x,
                                        at(i, sample, {0, Purpose::Lens}).x);
                    }),
             spread(kPixels,
                    [&](std::uint32_t i) {
                      return glm::dvec2(at(i, sample, {1, Purpose::Diffuse}).y,
                                        at(i, sample, {2, Purpose::Diffuse}).y);
                    }),
             spread(kPixels,
                    [&](std::uint32_t i) {
                      return glm::dvec2(at(2 * i, sample, pixel).x, at(2 * i + 1, sample, pixel).x);
                    }),
         }) {
      CHECK(statistic > 255.0 - 5.0 * 22.6);
      CHECK(statistic < 255.0 + 5.0 * 22.6);
    }
  }
}

TEST_CASE("sampler: dimensions and pixels are not correlated") {
  constexpr int kCount = 4096;
  const auto pixel = samples({0, Purpose::Pixel}, kCount);
  const auto lens = samples({0, Purpose::Lens}, kCount);
  const auto later = samples({1, Purpose::Pixel}, kCount);
  const auto other = samples({0, Purpose::Pixel}, kCount, 8);
  const auto column = [](const std::vector<glm::dvec2>& points, int axis) {
    std::vector<double> out;
    for (const glm::dvec2& p : points) out.push_back(p[axis]);
    return out;
  };
  const double bound = 4.0 / std::sqrt(kCount);  // four standard deviations of independent numbers
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) {
      for (const auto& points : {lens, later, other})
        CHECK(std::abs(correlation(column(pixel, a), column(points, b))) < bound);
    }
  }
  CHECK(std::abs(correlation(column(pixel, 0), column(pixel, 1))) < bound);
}

TEST_CASE("sampler: a smooth integral converges much faster than random numbers do") {
  // Error of the mean of x y over 1024 samples: random numbers give 0.22 / 32 = 0.0069.
  double squares = 0.0;
  constexpr int kPixels = 64;
  for (std::uint32_t pixel = 0; pixel < kPixels; ++pixel) {
    double sum = 0.0;
    for (const glm::dvec2& p : samples({2, Purpose::Diffuse}, 1024, pixel)) sum += p.x * p.y;
    const double error = sum / 1024.0 - 0.25;
    squares += error * error;
  }
  CHECK(std::sqrt(squares / kPixels) < 0.0069 / 20.0);
}

TEST_CASE("sampler: the map to the disc keeps areas") {
  int inside = 0;
  double radius = 0.0;
  constexpr int kSide = 256;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const glm::dvec2 p = disc({(i + 0.5) / kSide, (j + 0.5) / kSide});
      const double r2 = p.x * p.x + p.y * p.y;
      REQUIRE(r2 < 1.0);
      inside += r2 < 0.25 ? 1 : 0;
      radius += r2;
    }
  }
  CHECK(inside / double(kSide * kSide) == doctest::Approx(0.25).epsilon(0.01));
  CHECK(radius / double(kSide * kSide) == doctest::Approx(0.5).epsilon(0.001));
  CHECK(disc({0.5, 0.5}) == glm::dvec2(0.0));
}

}  // namespace
}  // namespace ti
