// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/vec.hpp"
#include "scene/ray.hpp"

namespace ti {

/// An Embree scene (3 or 4) in robust mode. Its answers are true away from edges and vertices only.
class EmbreeScene {
 public:
  /// `prims[i]` is the number to report for `triangles[i]`; `device` configures Embree as
  /// `rtcNewDevice` does. Throws `Error` when Embree cannot be set up.
  EmbreeScene(std::span<const glm::vec3> vertices,
              std::span<const std::array<std::uint32_t, 3>> triangles,
              std::vector<std::int32_t> prims, const std::string& device = "");
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// The `isa=` devices that Embree makes here: it refuses those that the processor lacks. One that
  /// it was built without falls back to the best below, which the interface does not tell.
  [[nodiscard]] static std::vector<std::string> devices();

  /// Whether Embree takes the ray: components of o and d within 1.844e18 (assertions of some builds
  /// abort beyond), tmin and tmax not NaN.
  [[nodiscard]] static bool takes(const Ray& ray);

  /// Closest hit, or for an any-hit ray whether something is hit; `takes(ray)` must hold.
  [[nodiscard]] Hit trace(const Ray& ray) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Boxes in Embree's hierarchy. Which of them a ray meets is decided here, in double, the same on
/// every processor.
class EmbreeBoxes {
 public:
  explicit EmbreeBoxes(std::vector<Box> boxes);
  ~EmbreeBoxes();
  EmbreeBoxes(const EmbreeBoxes&) = delete;
  EmbreeBoxes& operator=(const EmbreeBoxes&) = delete;

  /// Whether some point of the ray between tmin and tmax lies in a box; true for a ray that Embree
  /// does not take.
  [[nodiscard]] bool met_by(const Ray& ray) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ti
