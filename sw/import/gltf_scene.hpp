// SPDX-License-Identifier: Apache-2.0
//
// Materials and lights of a glTF file, from its JSON: Assimp drops some of their extensions.
#pragma once

#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
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

/// Translation, rotation (a quaternion x y z w of unit length) and scale of a node; x y z of the
/// first and the last.
struct Placement {
  glm::dvec4 translation{0.0};
  glm::dvec4 rotation{0.0, 0.0, 0.0, 1.0};
  glm::dvec4 scale{1.0};
};
/// That of a node without a matrix.
[[nodiscard]] Placement placement_of(const nlohmann::json& node);
[[nodiscard]] glm::dmat4 transform_of(const Placement& placement);

/// The transform of each node of a file, in its parent's space.
using Pose = std::vector<glm::dmat4>;
[[nodiscard]] Pose rest_pose(const nlohmann::json& json);

/// Calls `at(node, transform)` for the nodes of the default scene, a parent before its children and
/// these in their order; the transform is to the space of the scene. Throws `Error` for a circle.
void visit_nodes(const nlohmann::json& json, const Pose& pose, const std::string& file,
                 const std::function<void(std::size_t node, const glm::dmat4& transform)>& at);

/// The lights of KHR_lights_punctual where the nodes of the default scene put them, in the order of
/// the nodes. Their candelas are W/sr here, and their lux W/m^2.
[[nodiscard]] std::vector<Light> gltf_lights(const nlohmann::json& json, const Pose& pose,
                                             const std::string& file);

}  // namespace ti
