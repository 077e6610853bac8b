// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "scene/ray.hpp"
#include "scene/scene.hpp"

namespace ti {

/// Linear colour of each hit by its geometric normal (two-sided), the lights of the scene (or a
/// headlight) and its material; no secondary rays. Misses are the background.
[[nodiscard]] std::vector<glm::vec3> shade(const Scene& scene, std::span<const Ray> rays,
                                           std::span<const Hit> hits);

}  // namespace ti
