// SPDX-License-Identifier: Apache-2.0
//
// Materials and lights of a glTF file, from its JSON: Assimp drops some of their extensions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "import/materials.hpp"
#include "scene/light.hpp"

namespace ti {

/// Factors of metallic-roughness materials with KHR_materials_emissive_strength, _transmission and
/// _ior; textures do not count. Throws `Error` for a factor out of its range, by material and
/// field.
[[nodiscard]] std::vector<GltfValues> gltf_materials(const nlohmann::json& json,
                                                     const std::string& file);

/// The lights of KHR_lights_punctual where the nodes of the default scene put them, in the order of
/// the nodes. Their candelas are W/sr here, and their lux W/m^2.
[[nodiscard]] std::vector<Light> gltf_lights(const nlohmann::json& json, const std::string& file);

}  // namespace ti
