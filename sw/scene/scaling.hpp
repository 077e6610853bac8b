// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "base/format.hpp"
#include "scene/mesh.hpp"
#include "scene/ray.hpp"

namespace ti {

/// The mesh as an engine has it: vertices times 2^scale, rounded once to its numbers; as it stands
/// where the scale is 0.
[[nodiscard]] Mesh scaled(const Mesh& mesh, const ScaledFormat& format);

/// A ray in a space that is 2^scale times as large: o, tmin and tmax grow, d stays. What leaves the
/// range of binary32 becomes infinite or is rounded as a subnormal number.
[[nodiscard]] Ray scaled(const Ray& ray, int scale);

/// A hit in a space that is 2^scale times as large: t grows. One whose t is beyond the range of
/// binary32 there is a miss; below it t is rounded as a subnormal number.
[[nodiscard]] Hit scaled(const Hit& hit, int scale);

}  // namespace ti
