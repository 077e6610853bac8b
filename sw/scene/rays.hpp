// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/format.hpp"
#include "scene/ray.hpp"
#include "scene/scene.hpp"

namespace ti {

/// Primary rays through the pixel centres (spp = 1) or a stratified jitter (spp > 1), spp rays a
/// pixel, rows from the top. `pixel` order is Morton within the frame so that rays that are dealt
/// together lie together; `index[i]` is y * width + x of ray i.
struct PrimaryRays {
  std::vector<Ray> rays;
  std::vector<std::uint32_t> index;
};
[[nodiscard]] PrimaryRays primary_rays(const Camera& camera, int width, int height, int spp,
                                       std::uint64_t seed);

/// Rays from hits start where `departure` says, for an engine that has the scene in `format`.

/// Ambient occlusion: `samples` cosine-distributed any-hit rays of length `radius` from each hit;
/// misses spawn none.
[[nodiscard]] std::vector<Ray> ao_rays(const Mesh& mesh, const ScaledFormat& format,
                                       std::span<const Ray> rays, std::span<const Hit> hits,
                                       int samples, float radius, std::uint64_t seed);

/// One cosine-distributed closest-hit ray from each hit.
[[nodiscard]] std::vector<Ray> diffuse_rays(const Mesh& mesh, const ScaledFormat& format,
                                            std::span<const Ray> rays, std::span<const Hit> hits,
                                            std::uint64_t seed);

/// One any-hit ray from each hit to each point light, with tmax just short of it.
[[nodiscard]] std::vector<Ray> shadow_rays(const Mesh& mesh, const ScaledFormat& format,
                                           std::span<const Ray> rays, std::span<const Hit> hits,
                                           std::span<const glm::vec3> lights);

/// Where the light of a scene comes from, for rays that only test its shadows: its lights that have
/// a place and the middle of the triangles of each material that emits, moved a thousandth of the
/// scene's diagonal inwards.
[[nodiscard]] std::vector<glm::vec3> light_places(const Scene& scene);

/// `count` rays with origins uniform in a sphere around the mesh (1.2 of its radius) and directions
/// uniform on the sphere.
[[nodiscard]] std::vector<Ray> random_rays(const Mesh& mesh, std::size_t count, std::uint64_t seed);

/// `count` rays with origins uniform in the box of the mesh and directions uniform on the sphere.
[[nodiscard]] std::vector<Ray> inside_rays(const Mesh& mesh, std::size_t count, std::uint64_t seed);

}  // namespace ti
