// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <vector>

#include "base/vec.hpp"
#include "scene/light.hpp"
#include "scene/scene.hpp"

namespace ti {

/// What of a scene changes from frame to frame: places of vertices, the camera, lights. Triangles
/// and materials stay.
struct Animation {
  struct Frame {
    double seconds = 0.0;
    std::vector<glm::vec3> positions;  ///< of the vertices in `moving`
    Camera camera;
    std::vector<Light> lights;
  };
  std::vector<std::uint32_t> moving;  ///< numbers of vertices that are not always in one place
  std::vector<Frame> frames;          ///< at least one

  /// Puts `scene` into a frame.
  void pose(Scene& scene, std::size_t frame) const;

  /// Box of the finite vertices of all frames.
  [[nodiscard]] Box reach(const Scene& scene) const;
};

struct AnimatedScene {
  Scene scene;  ///< in its first frame
  Animation animation;
};

/// Loads a scene with its frames: the node animation of a glTF file, `fps` frames a second, or the
/// sequence of vertex positions that the file beside the scene names. Others have one frame. Throws
/// as `load_scene`.
[[nodiscard]] AnimatedScene load_animated_scene(const std::filesystem::path& path, double fps);

/// What differs between two frames of a scene.
struct Change {
  std::vector<std::uint8_t> moved;  ///< of each triangle: 1 where a corner is elsewhere
  std::size_t triangles = 0;        ///< how many
  bool emits = false;               ///< one of them emits
  bool view = false;                ///< the camera is another
  bool lights = false;              ///< a light without an area is another

  [[nodiscard]] bool nothing() const { return triangles == 0 && !view && !lights; }
};
[[nodiscard]] Change change_between(const Scene& before, const Scene& after);

}  // namespace ti
