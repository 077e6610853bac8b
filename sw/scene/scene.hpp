// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "scene/light.hpp"
#include "scene/material.hpp"
#include "scene/mesh.hpp"

namespace ti {

/// Thin lens; a pinhole when the aperture is 0.
struct Camera {
  glm::vec3 eye{0.0F, 0.0F, 3.0F};
  glm::vec3 target{0.0F};
  glm::vec3 up{0.0F, 1.0F, 0.0F};
  float fov_y_deg = 45.0F;      ///< vertical field of view
  float aperture = 0.0F;        ///< diameter of the lens
  float focus_distance = 0.0F;  ///< of the plane that is sharp, along the view; 0: through `target`
};

struct Scene {
  std::string name;
  Mesh mesh;
  std::vector<Material> materials;  ///< at least one
  Camera camera;
  std::vector<Light> lights;   ///< those without an area
  glm::vec3 background{0.0F};  ///< radiance from everywhere, of rays that leave the scene
  std::vector<std::string> warnings;

  [[nodiscard]] const Material& material_of(std::size_t triangle) const {
    return materials[mesh.material.empty() ? 0 : mesh.material[triangle]];
  }
};

/// Loads glTF 2.0 (.gltf, .glb), OBJ, PLY or .ply.zst; beside it `<stem>.json` for what the file
/// does not have (camera {eye, target, up, fov_y_deg}, lights, materials with Kd and Ke: the form
/// of the benchmark scenes). Without any camera one is chosen that sees the whole mesh. A mesh may
/// be empty: `Scene::mesh` then has no triangle. Throws `Error` in one sentence that names the
/// file, the place and the cure.
[[nodiscard]] Scene load_scene(const std::filesystem::path& path);

}  // namespace ti
