// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "scene/mesh.hpp"

namespace ti {

struct Material {
  std::string name = "default";
  glm::vec3 diffuse{0.7F};   ///< Kd, linear
  glm::vec3 emission{0.0F};  ///< Ke, linear
};

/// Pinhole camera.
struct Camera {
  glm::vec3 eye{0.0F, 0.0F, 3.0F};
  glm::vec3 target{0.0F};
  glm::vec3 up{0.0F, 1.0F, 0.0F};
  float fov_y_deg = 45.0F;  ///< vertical field of view
};

struct PointLight {
  glm::vec3 position{0.0F};
  glm::vec3 intensity{1.0F};
};

struct Scene {
  std::string name;
  Mesh mesh;
  std::vector<Material> materials;  ///< at least one
  Camera camera;
  std::vector<PointLight> lights;  ///< empty: a headlight at the eye
  std::vector<std::string> warnings;
};

/// Loads glTF 2.0 (.gltf, .glb), OBJ, PLY or .ply.zst; beside it `<stem>.json` for what the file
/// does not have (camera {eye, target, up, fov_y_deg}, lights, materials with Kd and Ke: the form
/// of the benchmark scenes). Without any camera one is chosen that sees the whole mesh. A mesh may
/// be empty: `Scene::mesh` then has no triangle. Throws `Error` in one sentence that names the
/// file, the place and the cure.
[[nodiscard]] Scene load_scene(const std::filesystem::path& path);

}  // namespace ti
