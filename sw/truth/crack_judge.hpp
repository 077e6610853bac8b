// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "base/format.hpp"
#include "scene/mesh.hpp"
#include "scene/ray.hpp"
#include "truth/exact_tracer.hpp"

namespace ti {

/// Tells a crack from an outline and from the beginning of a ray, by topology.
///
/// A test that sees each corner in one place for all triangles that share it, less than r beside
/// its own, maps a sheet of triangles onto the plane behind the ray. Let the sheet be the triangles
/// around the exact hit that come within r of the ray, from one to the next by shared edges, and
/// let all face the ray from the same side. Where no edge within r is the end of that sheet, the
/// border of the mesh or an edge behind which the mesh turns away, the winding number of the sheet
/// about the ray is not 0 and stays as corners move by less than r: some triangle of it must be
/// hit. An engine that hits none of them, and nothing before the sheet ends on the ray, has a
/// crack: of a triangle that the ray grazes t may be off by all of its length within r. Where an
/// edge within r is such an end, the ray may pass beside it.
///
/// r is (9 u + 2 q) A, u the error of an operation, q of a reciprocal and A the distance of the
/// farthest corner of the box of the mesh from the origin of the ray: sqrt(2) times what a corner
/// moves in x and in y (docs/certificates.md). Corners with the same rounded coordinates are one.
class CrackJudge {
 public:
  /// Triangles have the numbers of `mesh`; its corners are rounded to `format`.
  CrackJudge(const Mesh& mesh, const Format& format);

  /// How far behind the exact hit, in units of t, another one lies that cannot be the same: a
  /// thousandth of the diagonal of the mesh, or 64 u A.
  [[nodiscard]] double behind(const Ray& ray) const;

  /// Triangles of which an engine must hit one, and the greatest t at which they may be met.
  struct Sheet {
    std::vector<std::int32_t> triangles;  ///< ascending
    double end = 0.0;
  };

  /// The sheet around the exact `hit`; without triangles where an engine may hit nothing: at an
  /// outline, at the border of the mesh, or where the sheet may come to lie before tmin.
  [[nodiscard]] Sheet sheet(const Ray& ray, const ExactTracer::Hit& hit) const;

  [[nodiscard]] const Format& format() const { return format_; }

 private:
  static constexpr std::int32_t kBorder = -1;

  /// The other triangle of an edge, and whether it turns round the same way, as seen from one side.
  struct Neighbour {
    std::int32_t triangle = kBorder;
    bool same_turn = true;
  };

  void join(const Mesh& mesh);
  [[nodiscard]] double farthest(const glm::dvec3& o) const;
  [[nodiscard]] Sheet sheet_from(const Ray& ray, std::int32_t first) const;

  Format format_;
  std::vector<std::array<glm::dvec3, 3>> corners_;  ///< of each triangle
  std::vector<std::array<Neighbour, 3>> beside_;    ///< over the edge from corner k to k + 1
  glm::dvec3 low_{}, high_{};
  double diagonal_ = 0.0;
};

}  // namespace ti
