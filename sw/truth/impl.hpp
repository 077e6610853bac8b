// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "truth/bounds.hpp"
#include "truth/embree.hpp"
#include "truth/exact.hpp"
#include "truth/truth.hpp"

namespace ti {

/// `ray` with every number rounded to `format`.
[[nodiscard]] Ray round_ray(const Ray& ray, Format format);

/// Whether the engine traces `ray` (in `format`) at all: o and d finite, tmin and tmax not NaN,
/// some 1/d finite.
[[nodiscard]] bool valid_ray(const Ray& ray, Format format);

/// A triangle that counts.
struct TruthTriangle {
  TestConstants constants;
  std::int32_t prim = 0;
  bool has_lower_twin = false;  ///< a lower id has the same corners in the same order, so this one
                                ///< can never be reported
};

struct Truth::Impl {
  Impl(const Mesh& mesh, Format number_format, const std::string& device, std::uint64_t most_looks,
       TestKind test);

  Format format;
  std::uint64_t looks;
  BoundedOps ops;
  std::vector<glm::vec3> vertices;  ///< rounded to the format
  std::vector<std::array<std::uint32_t, 3>> corners;
  std::vector<TruthTriangle> triangles;  ///< those that count, ascending by prim
  std::vector<std::int32_t>
      place;  ///< prim -> index into `triangles`, -1 for one that does not count
  std::unique_ptr<EmbreeScene> embree;

  [[nodiscard]] Corners corners_of(std::int32_t prim) const;
  /// The counting triangle with that id, or null.
  [[nodiscard]] const TruthTriangle* find(std::int32_t prim) const;
  /// Indices into `triangles` of all that the line of `ray` may meet, exactly or in the format.
  [[nodiscard]] std::vector<std::size_t> candidates(const Ray& ray) const;

  /// Exact closest hit of a ray in the format.
  [[nodiscard]] ExactHit exact(const Ray& ray) const;
  /// Embree's answer for a ray in the format; the exact one for rays that Embree does not take.
  [[nodiscard]] Hit trace(const Ray& ray) const;
  /// Whether Embree's triangle is certainly hit and certainly nearer than `hit`: settles most wrong
  /// hits without a look at every triangle, so that a broken engine is told in seconds.
  [[nodiscard]] bool loses(const Ray& ray, const Hit& hit, const Hit& embree_hit) const;
  /// How many rays may look at every triangle.
  [[nodiscard]] std::size_t most_searches() const {
    return looks / std::max<std::size_t>(1, triangles.size());
  }
  /// Verdict for a ray in the format where that takes no look at every triangle. Embree must take
  /// the ray.
  [[nodiscard]] std::optional<Verdict> judge_quickly(const Ray& ray, const Hit& hit,
                                                     const Hit& embree_hit) const;
  /// Verdict for a ray in the format.
  [[nodiscard]] Verdict judge(const Ray& ray, const Hit& hit, const Hit& embree_hit) const;
};

}  // namespace ti
