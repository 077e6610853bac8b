// SPDX-License-Identifier: Apache-2.0
#include "render/film.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace ti {

namespace {

constexpr double kKey = 0.18;
constexpr double kLamps = 0.01;  ///< share of the pixels, the brightest, that do not count

double luminance(const glm::vec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

float bend(double x) {
  return static_cast<float>(x <= 0.5 ? x : 1.0 - 0.5 * std::exp(-2.0 * (x - 0.5)));
}

}  // namespace

Film::Film(int width, int height)
    : width_(width),
      height_(height),
      sums_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), glm::dvec3(0.0)),
      samples_(sums_.size(), 0) {}

void Film::add(std::uint32_t pixel, const glm::dvec3& radiance) {
  // Written so that no number fails it.
  const bool good = radiance.x >= 0.0 && radiance.y >= 0.0 && radiance.z >= 0.0 &&
                    std::isfinite(radiance.x + radiance.y + radiance.z);
  if (!good)
    throw std::domain_error(fmt::format("pixel {} gets the radiance {} {} {}", pixel, radiance.x,
                                        radiance.y, radiance.z));
  sums_.at(pixel) += radiance;
  ++samples_[pixel];
}

void Film::clear(std::uint32_t pixel) {
  sums_.at(pixel) = glm::dvec3(0.0);
  samples_[pixel] = 0;
}

std::vector<glm::vec3> Film::radiance() const {
  std::vector<glm::vec3> out(sums_.size(), glm::vec3(0.0F));
  for (std::size_t i = 0; i < out.size(); ++i)
    if (samples_[i] != 0) out[i] = glm::vec3(sums_[i] / static_cast<double>(samples_[i]));
  return out;
}

double exposure_of(const std::vector<glm::vec3>& radiance) {
  std::vector<double> lit;
  for (const glm::vec3& c : radiance)
    if (const double l = luminance(c); l > 0.0 && std::isfinite(l)) lit.push_back(l);
  if (lit.empty()) return 1.0;
  std::sort(lit.begin(), lit.end());
  const auto lamps = static_cast<std::size_t>(kLamps * static_cast<double>(lit.size()));
  lit.resize(lit.size() - lamps);
  double sum = 0.0;
  for (const double l : lit) sum += std::log(l);
  return kKey / std::exp(sum / static_cast<double>(lit.size()));
}

std::vector<glm::vec3> tone_mapped(const std::vector<glm::vec3>& radiance, double exposure) {
  std::vector<glm::vec3> out;
  out.reserve(radiance.size());
  for (const glm::vec3& c : radiance)
    out.emplace_back(bend(exposure * c.x), bend(exposure * c.y), bend(exposure * c.z));
  return out;
}

}  // namespace ti
