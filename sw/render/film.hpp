// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace ti {

/// Linear radiance of the samples of a picture, summed a pixel.
class Film {
 public:
  Film(int width, int height);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  /// Adds a sample; sums are in the order of the calls. Throws `std::out_of_range` for a pixel that
  /// the picture does not have, and `std::domain_error` for a radiance that is negative or no
  /// number.
  void add(std::uint32_t pixel, const glm::dvec3& radiance);

  /// Forgets the samples of a pixel.
  void clear(std::uint32_t pixel);

  /// The mean of each pixel's samples, [height][width]; black where there is none.
  [[nodiscard]] std::vector<glm::vec3> radiance() const;

 private:
  int width_;
  int height_;
  std::vector<glm::dvec3> sums_;
  std::vector<std::uint32_t> samples_;
};

/// The factor that puts the log-average luminance of a picture at a middle grey (Reinhard et al.,
/// Photographic Tone Reproduction for Digital Images, SIGGRAPH 2002, section 3, key 0.18). Black
/// pixels and the brightest hundredth, where the camera looks into a lamp, do not count; 1 when all
/// are black.
[[nodiscard]] double exposure_of(const std::vector<glm::vec3>& radiance);

/// Exposed and bent towards white in place of breaking off there: x up to 0.5, then
/// 1 - exp(1 - 2 x) / 2, continuous in value and slope. Linear, 0 to 1.
[[nodiscard]] std::vector<glm::vec3> tone_mapped(const std::vector<glm::vec3>& radiance,
                                                 double exposure);

}  // namespace ti
