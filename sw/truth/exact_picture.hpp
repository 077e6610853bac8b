// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "model/tracer.hpp"
#include "scene/camera.hpp"
#include "scene/scene.hpp"
#include "truth/exact_tracer.hpp"

namespace ti {

/// What is seen through the middles of pixels, shaded, and how many of them are wrong.
struct ShadedPicture {
  std::vector<glm::vec3> pixels;  ///< linear grey, [height][width]
  std::uint64_t wrong = 0;        ///< another triangle than the exact ones, or a false hit or miss
};

/// The picture of the scene as it is given, in binary32, without any rounding after that: what a
/// machine's picture is held against.
///
/// A pixel is one ray. It is lit by a lamp at the eye: |n d| / (1 + (t / m)^2), n the normal of the
/// triangle, d the direction, t the distance, m the median of the exact distances; black where
/// nothing is hit. So it depends on the triangle and on t, and on no sample. Keeps references to
/// what it is given.
class ExactPicture {
 public:
  /// `exact` is of the mesh of the scene in binary32.
  ExactPicture(const Scene& scene, const ExactTracer& exact, int width, int height);

  [[nodiscard]] const ShadedPicture& picture() const { return picture_; }

  /// The picture of an engine, which has scene and rays in `format`; nothing where its
  /// steps and tests are more than `most_work`, judged by 64 pixels.
  [[nodiscard]] std::optional<ShadedPicture> of(const Tracer& model, const ScaledFormat& format,
                                                double most_work = 1e18) const;

  /// Where points of the mesh stand in the picture, those that do, in pixels; `seen` where nothing
  /// is in front of them (within a fiftieth of the distance).
  struct Place {
    double x = 0.0, y = 0.0;
    bool seen = false;
  };
  [[nodiscard]] std::vector<Place> places_of(std::span<const glm::dvec3> points) const;

 private:
  [[nodiscard]] glm::vec3 shade(std::size_t pixel, std::int32_t prim, double t) const;

  const Mesh& mesh_;
  int width_;
  int height_;
  CameraRays camera_;
  std::vector<Ray> rays_;
  std::vector<ExactTracer::Hit> hits_;
  double median_ = 1.0;
  ShadedPicture picture_;
};

}  // namespace ti
