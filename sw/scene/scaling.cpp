// SPDX-License-Identifier: Apache-2.0
#include "scene/scaling.hpp"

#include <cmath>

namespace ti {

Mesh scaled(const Mesh& mesh, const ScaledFormat& format) {
  Mesh out = mesh;
  if (format.scale == 0) return out;
  for (glm::vec3& place : out.vertices) {
    for (int axis = 0; axis < 3; ++axis) {
      const double x = std::ldexp(double{place[axis]}, format.scale);
      place[axis] = static_cast<float>(round_to(format.numbers, x));
    }
  }
  return out;
}

Ray scaled(const Ray& ray, int scale) {
  Ray out = ray;
  for (int axis = 0; axis < 3; ++axis) out.o[axis] = std::ldexp(ray.o[axis], scale);
  out.tmin = std::ldexp(ray.tmin, scale);
  out.tmax = std::ldexp(ray.tmax, scale);
  return out;
}

Hit scaled(const Hit& hit, int scale) {
  Hit out = hit;
  out.t = std::ldexp(hit.t, scale);
  if (!hit.is_hit() || std::isfinite(out.t)) return out;
  return {.status = hit.status, .steps = hit.steps};
}

}  // namespace ti
