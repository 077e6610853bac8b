// SPDX-License-Identifier: Apache-2.0
#include "render/moved_region.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "truth/embree.hpp"

namespace ti {

namespace {

constexpr double kWide = 128.0;

Box box_of(const Corners& corners, double wider) {
  Box box{point_of(corners[0]), point_of(corners[0])};
  for (const glm::vec3& corner : corners) {
    const Point p = point_of(corner);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lo[axis] = std::min(box.lo[axis], p[axis]);
      box.hi[axis] = std::max(box.hi[axis], p[axis]);
    }
  }
  return box.grown(wider);
}

}  // namespace

struct MovedRegion::Impl {
  double share;  ///< by which t may be more than it is said to be
  std::unique_ptr<EmbreeBoxes> boxes;
};

MovedRegion::MovedRegion(const Mesh& before, const Mesh& after, const Change& change,
                         const Box& reach, const ScaledFormat& format)
    : impl_(std::make_unique<Impl>()) {
  const Format& numbers = format.numbers;
  impl_->share = kWide * std::max(numbers.rounding_unit(), numbers.reciprocal_unit());
  const double least = std::ldexp(numbers.least_normal(), -format.scale);
  const double lost = numbers.modes.flush ? kWide * least : 0.0;
  double largest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    largest = std::max({largest, std::abs(reach.lo[axis]), std::abs(reach.hi[axis])});
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < change.moved.size(); ++i) {
    if (change.moved[i] == 0) continue;
    for (const Mesh* mesh : {&before, &after}) {
      const Corners corners = mesh->corners(i);
      const bool usable =
          std::all_of(corners.begin(), corners.end(), [](const glm::vec3& c) { return finite(c); });
      if (usable) boxes.push_back(box_of(corners, impl_->share * largest + lost));
    }
  }
  impl_->boxes = std::make_unique<EmbreeBoxes>(std::move(boxes));
}

MovedRegion::~MovedRegion() = default;

bool MovedRegion::met_by(const Ray& cut) const {
  Ray wide = cut;
  wide.tmax = static_cast<float>(double{cut.tmax} * (1.0 + impl_->share));
  return impl_->boxes->met_by(wide);
}

Ray cut_at(const Ray& ray, const Hit& hit) {
  Ray cut = ray;
  cut.any = true;
  if (!ray.any && hit.is_hit()) cut.tmax = hit.t;
  return cut;
}

}  // namespace ti
