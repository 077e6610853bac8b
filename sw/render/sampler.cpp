// SPDX-License-Identifier: Apache-2.0
#include "render/sampler.hpp"

#include <cmath>

namespace ti {

namespace {

/// SplitMix64's finalizer (Steele, Lea, Flood 2014).
std::uint64_t mix(std::uint64_t z) {
  z += 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

std::uint32_t reversed(std::uint32_t x) {
  x = (x >> 1 & 0x55555555U) | (x & 0x55555555U) << 1;
  x = (x >> 2 & 0x33333333U) | (x & 0x33333333U) << 2;
  x = (x >> 4 & 0x0F0F0F0FU) | (x & 0x0F0F0F0FU) << 4;
  x = (x >> 8 & 0x00FF00FFU) | (x & 0x00FF00FFU) << 8;
  return x >> 16 | x << 16;
}

/// Each bit is changed by the bits below it alone: reversed, a tree of random swaps.
std::uint32_t laine_karras(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3D20ADEAU;
  x += seed;
  x *= (seed >> 16) | 1U;
  x ^= x * 0x05526C56U;
  x ^= x * 0x53A22864U;
  return x;
}

/// Owen's nested uniform scramble of the binary digits behind the point.
std::uint32_t scrambled(std::uint32_t x, std::uint32_t seed) {
  return reversed(laine_karras(reversed(x), seed));
}

/// Sobol's second dimension: the columns of Pascal's triangle modulo 2.
std::uint32_t sobol_1(std::uint32_t index) {
  std::uint32_t result = 0;
  for (std::uint32_t column = 0x80000000U; index != 0; index >>= 1) {
    if ((index & 1U) != 0) result ^= column;
    column ^= column >> 1;
  }
  return result;
}

double fraction(std::uint32_t bits) { return static_cast<double>(bits) * 0x1p-32; }

std::uint64_t key(std::uint64_t pixel, Dimension d) {
  const auto place = static_cast<std::uint64_t>(d.bounce) << 32;
  return mix(pixel ^ mix(place | static_cast<std::uint64_t>(d.purpose)));
}

}  // namespace

Sampler::Sampler(std::uint64_t seed, std::uint32_t pixel, std::uint32_t sample)
    : pixel_(mix(mix(seed) ^ pixel)), sample_(sample) {}

double Sampler::get1(Dimension dimension) const { return get2(dimension).x; }

glm::dvec2 Sampler::get2(Dimension dimension) const {
  const std::uint64_t k = key(pixel_, dimension);
  const std::uint64_t l = mix(k);
  // The order of the points is scrambled as the points are, so that each block of 2^m samples stays
  // a block of the sequence.
  const std::uint32_t index = scrambled(sample_, static_cast<std::uint32_t>(k));
  return {fraction(scrambled(reversed(index), static_cast<std::uint32_t>(k >> 32))),
          fraction(scrambled(sobol_1(index), static_cast<std::uint32_t>(l)))};
}

glm::dvec2 disc(const glm::dvec2& u) {
  const double x = 2.0 * u.x - 1.0;
  const double y = 2.0 * u.y - 1.0;
  if (x == 0.0 && y == 0.0) return {0.0, 0.0};
  constexpr double kQuarter = 3.14159265358979323846 / 4.0;
  const bool wide = std::abs(x) > std::abs(y);
  const double radius = wide ? x : y;
  const double angle = wide ? kQuarter * (y / x) : 2.0 * kQuarter - kQuarter * (x / y);
  return radius * glm::dvec2(std::cos(angle), std::sin(angle));
}

}  // namespace ti
