// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/vec.hpp"
#include "scene/mesh.hpp"

namespace ti {

/// Bounds of the part of `triangle` that lies in `box` (Sutherland and Hodgman 1974, in double);
/// false when no part does.
///
/// Each new corner is off by a few double ulps of the largest coordinate, so callers grow `box` by
/// more than that.
[[nodiscard]] bool clipped_bounds(const Corners& triangle, const Box& box, Box& bounds);

}  // namespace ti
