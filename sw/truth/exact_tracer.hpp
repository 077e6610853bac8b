// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <vector>

#include "base/format.hpp"
#include "scene/mesh.hpp"
#include "scene/ray.hpp"

namespace ti {

/// Closest hits without any rounding, for rays in volume.
///
/// A thick ray of binary32 (`PaddedKdTree`) names the triangles that the exact ray may meet;
/// doubles with a proven bound decide nearly all of them (`quick_meeting`), integers of any length
/// the rest (`exact_meeting`). Vertices and rays are rounded to the format first, as an engine sees
/// them. Safe to call from several threads.
class ExactTracer {
 public:
  struct Hit {
    bool hit = false;
    double t = 0.0;                   ///< exact t to 2^-40 of itself
    std::vector<std::int32_t> prims;  ///< all of least t, ascending
    std::vector<glm::dvec2> weights;  ///< of their second and third corners, to 2^-40
  };

  ExactTracer(const Mesh& mesh, Format format);
  ~ExactTracer();
  ExactTracer(const ExactTracer&) = delete;
  ExactTracer& operator=(const ExactTracer&) = delete;

  /// A ray that no engine traces (`valid_ray`) hits nothing.
  [[nodiscard]] Hit trace(const Ray& ray) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ti
