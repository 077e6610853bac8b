// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/image.hpp"
#include "base/format.hpp"
#include "base/vec.hpp"
#include "scene/mesh.hpp"

namespace ti {

/// Sizes of a scene for which a triangle test needs no scaling: 2^a, the least power of two above
/// the largest |coordinate|, with low <= a <= high.
struct ScaleWindow {
  int low, high;

  /// Where scenes of other sizes are taken, with room on both sides.
  [[nodiscard]] int middle() const { return (low + high) >> 1; }
};

/// The window of a number format and a test; `scene_scale.cpp` derives it.
[[nodiscard]] ScaleWindow scale_window(const Format& format, TestKind test);

/// The exponent of the power of two by which the places of a scene are multiplied before an engine
/// has them: 0 where its size is in the window, else what takes it to the middle. `largest` is
/// its largest |coordinate|, in scene units; 0 and what is not finite give 0. Never beyond
/// `kMostScale`.
[[nodiscard]] int scene_scale(double largest, const Format& format, TestKind test);

/// The largest finite |coordinate| of the triangles of a mesh, 0 where there is none.
[[nodiscard]] double largest_coordinate(const Mesh& mesh);
/// The same of a box.
[[nodiscard]] double largest_coordinate(const Box& box);

}  // namespace ti
