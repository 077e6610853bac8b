// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "scene/ray.hpp"

namespace ti {

/// rays.npy: float32 [N,8]: origin xyz, tmin, direction xyz, tmax. Any other shape, type or a cut
/// file throws `Error`.
[[nodiscard]] std::vector<Ray> load_rays(const std::filesystem::path& path);
// The bytes of the arrays that a run writes.

/// rays.npy, as `load_rays` reads it.
[[nodiscard]] std::string rays_npy(std::span<const Ray> rays);
/// hits.npy: float32 [N,3]: t, u, v.
[[nodiscard]] std::string hits_npy(std::span<const Hit> hits);
/// prims.npy: int32 [N].
[[nodiscard]] std::string prims_npy(std::span<const Hit> hits);
/// steps.npy: uint16 [N], nodes visited.
[[nodiscard]] std::string steps_npy(std::span<const Hit> hits);
/// tests.npy: uint32 [N], triangles tested.
[[nodiscard]] std::string tests_npy(std::span<const std::uint32_t> tests);
/// radiance.npy: float32 [height, width, 3], linear, rows from the top. Throws `Error` as `png_of`
/// does.
[[nodiscard]] std::string radiance_npy(std::span<const glm::vec3> pixels, int width, int height);

}  // namespace ti
