// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "accel/image.hpp"
#include "accel/range_audit.hpp"
#include "base/format.hpp"
#include "scene/mesh.hpp"

namespace ti {

/// The triangles of a mesh that go into the tree, in the order of the mesh.
struct PreparedTriangles {
  std::vector<Corners> corners;      ///< scaled, and rounded to the format
  std::vector<std::uint32_t> prims;  ///< their numbers in the mesh
  std::vector<ImagePlane> planes;    ///< of Shevtsov's test, as the next; empty for Woop's
  std::vector<ImageBary> barys;
  std::uint32_t dropped_nonfinite = 0;  ///< a vertex or a constant is not finite in the format
  std::uint32_t dropped_zero_area = 0;
  RangeAudit range;
};

/// Rounds the vertices, times 2^scale, to the format, drops what cannot be hit, and computes the
/// constants of Shevtsov's test (Shevtsov, Soupikov, Kapustin 2007; `Local` with a vertex in place
/// of n.p).
///
/// Zero area is decided exactly on the rounded vertices; what the format does not hold is counted.
/// Constants are computed in double, the normal by Kahan's difference of products, and rounded
/// once. Throws `Error` when a triangle names a vertex that the mesh does not have.
[[nodiscard]] PreparedTriangles prepare_triangles(const Mesh& mesh, const ScaledFormat& format,
                                                  TestKind test);

/// True when the three corners lie on one line or point, exactly. Coordinates are values of a
/// format (floats).
[[nodiscard]] bool has_zero_area(const Corners& corners);

}  // namespace ti
