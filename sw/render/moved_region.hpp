// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "base/format.hpp"
#include "base/vec.hpp"
#include "scene/animation.hpp"
#include "scene/ray.hpp"

namespace ti {

/// Where something moved between two frames: the boxes of the moved triangles, where they were and
/// where they are.
///
/// Each box is wider by 128 u of the largest coordinate that the scene reaches, u the largest
/// relative error of an operation or a reciprocal, far more than what an engine, its rounded rays
/// and the dilation of its tree can be off; and by as many least normal numbers where subnormals
/// are flushed. So the answer for a ray that meets no box is the same in both frames; only where
/// the ray lies in the plane of a moved triangle, or two triangles that stand still lie within the
/// error of t of one another, may rounding decide otherwise (Grazing and Tie of `docs/truth.md`).
class MovedRegion {
 public:
  MovedRegion(const Mesh& before, const Mesh& after, const Change& change, const Box& reach,
              const ScaledFormat& format);
  ~MovedRegion();
  MovedRegion(const MovedRegion&) = delete;
  MovedRegion& operator=(const MovedRegion&) = delete;

  /// Whether a ray that was cut at its hit may meet a box.
  [[nodiscard]] bool met_by(const Ray& cut) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The part of a ray that its answer depends on: up to its hit; of an any-hit ray all.
[[nodiscard]] Ray cut_at(const Ray& ray, const Hit& hit);

}  // namespace ti
