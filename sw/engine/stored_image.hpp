// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "accel/build.hpp"
#include "accel/image.hpp"
#include "base/config_keys.hpp"
#include "scene/mesh.hpp"

namespace ti {

/// Loads a memory image in place of building one for `mesh`, and fills in what `stats` can tell of
/// it (no cost, no time).
///
/// Throws `Error` when the image is damaged, has another number format or layout than `config`, or
/// when its triangle records are not those that `mesh` gives with the scale of the image, bit for
/// bit. `scene` is the name of
/// the mesh for that sentence.
[[nodiscard]] Image load_image_of(const std::filesystem::path& path, const Mesh& mesh,
                                  const Config& config, const std::filesystem::path& scene,
                                  BuildStats& stats);

}  // namespace ti
