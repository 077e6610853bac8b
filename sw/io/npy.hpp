// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "scene/ray.hpp"

namespace ti {

/// rays.npy: float32 [N,8]: origin xyz, tmin, direction xyz, tmax. Any other shape, type or a cut
/// file throws `Error`.
[[nodiscard]] std::vector<Ray> load_rays(const std::filesystem::path& path);
void save_rays(const std::filesystem::path& path, std::span<const Ray> rays);
/// hits.npy: float32 [N,3]: t, u, v.
void save_hits(const std::filesystem::path& path, std::span<const Hit> hits);
/// prims.npy: int32 [N].
void save_prims(const std::filesystem::path& path, std::span<const Hit> hits);

}  // namespace ti
