// SPDX-License-Identifier: Apache-2.0
#include "scene/aimed_rays.hpp"

#include <algorithm>
#include <cmath>

#include "scene/geometry.hpp"
#include "scene/random.hpp"

namespace ti {

constexpr double kFarOctaves = 9.965784284662087;  // of 1,000

AimedRays::AimedRays(const Mesh& mesh, Aim aim, std::uint64_t seed)
    : mesh_(mesh), aim_(aim), seed_(seed) {
  const Bounds bounds = bounds_of(mesh).value_or(Bounds{});
  centre_ = bounds.centre();
  radius_ = bounds.diagonal() > 0.0 ? 0.5 * bounds.diagonal() : 1.0;
}

Ray AimedRays::operator()(std::uint64_t index) const {
  Random random(seed_, index);
  if (aim_ == Aim::Uniform) {
    const glm::dvec3 from = centre_ + 1.2 * radius_ * random.ball();
    return {.o = glm::vec3(from), .d = glm::vec3(glm::normalize(random.ball()))};
  }
  const std::size_t count = mesh_.triangles.size();
  const auto prim =
      std::min(static_cast<std::size_t>(random.uniform() * static_cast<double>(count)), count - 1);
  const int corner = static_cast<int>(random.uniform() * 3.0);
  const glm::dvec3 a(mesh_.vertex(prim, corner));
  const glm::dvec3 b(mesh_.vertex(prim, (corner + 1) % 3));
  const glm::dvec3 c(mesh_.vertex(prim, (corner + 2) % 3));
  const bool at_vertex = aim_ == Aim::Vertices || (aim_ == Aim::Far && random.uniform() < 0.5);
  glm::dvec3 place = at_vertex ? a : a + random.uniform() * (b - a);
  glm::dvec3 o = centre_ + 1.2 * radius_ * random.ball();
  if (aim_ == Aim::Far) {
    const double away = radius_ * portable_exp2(kFarOctaves * random.uniform());
    o = centre_ + away * glm::normalize(random.ball());
  } else if (aim_ == Aim::Grazing) {
    place += random.uniform() * (c - place);
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const double length = glm::length(normal);
    const glm::dvec3 along = glm::normalize(b - a + (2.0 * random.uniform() - 1.0) * (c - a));
    const double slope = portable_exp2(-2.0 - 14.0 * random.uniform());
    if (length > 0.0 && std::isfinite(along.x))
      o = place - 1.2 * radius_ * random.uniform() * (along + slope / length * normal);
  }
  Ray ray;
  ray.o = glm::vec3(o);
  ray.d = glm::vec3(place - glm::dvec3(ray.o));
  return ray;
}

}  // namespace ti
