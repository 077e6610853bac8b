// SPDX-License-Identifier: Apache-2.0
//
// How the materials of files become those of a scene (`scene/material.hpp`).
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "scene/material.hpp"

namespace ti {

/// The values of a Wavefront material, also in the JSON of the benchmark scenes.
struct MtlValues {
  std::string name = "default";
  glm::vec3 kd{0.7F};
  glm::vec3 ks{0.0F};
  glm::vec3 ke{0.0F};
  std::optional<glm::vec3> tf;  ///< tint of what goes through
  std::optional<float> ns;      ///< exponent of Phong
  std::optional<float> ni;      ///< index of refraction
  std::optional<float> tr;      ///< share that goes through
  int illum = 2;
};

/// By `illum`: 0, 1 matt of Kd; 2 and a lobe of Ks besides, whose width is that of Phong's exponent
/// Ns (Walter et al., EGSR 2007, section 5.2: alpha = sqrt(2 / (Ns + 2))); 3 and a mirror of Ks,
/// and glass of Ni where Tr is above 0 (the materials of BART); 5 as 3, white at grazing angles,
/// and no glass; 4, 6, 7, 9 glass of Ni and Tf.
[[nodiscard]] Material material_of(const MtlValues& values);

/// The values of a glTF material with its extensions.
struct GltfValues {
  std::string name = "default";
  glm::vec3 base{1.0F};
  float metallic = 1.0F;
  float roughness = 1.0F;
  float transmission = 0.0F;
  float ior = 1.5F;
  glm::vec3 emission{0.0F};
};

/// Metal reflects `base`, nothing else; other surfaces are matt, with a coat of the reflectance of
/// `ior` unless their roughness is 1; what transmits is smooth glass tinted by `base`. Shares of
/// metal and of transmission mix these.
[[nodiscard]] Material material_of(const GltfValues& values);

/// What is wrong with a material, as in "its Ni is 0, and glass has 1 to 100"; empty when nothing
/// is.
[[nodiscard]] std::string fault_of(const Material& material);

/// Scales the lobes of a material that reflects more than it gets, keeping their colours; whether
/// it did.
bool keep_energy(Material& material);

}  // namespace ti
