// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <string>

namespace ti {

/// What a surface does with light: a sum of lobes, each of which may be black. All colours are
/// linear, finite and not negative.
///
/// | lobe    | what it is                                              | there when |
/// |---------|---------------------------------------------------------|---------------------------|
/// | diffuse | Lambert, both sides                                     | `diffuse` is not black |
/// | glossy  | GGX microfacets, Fresnel term after Schlick             | `specular`, roughness > 0
/// | | mirror  | the same of a smooth surface: one direction             | `specular`, roughness 0
/// | | glass   | smooth dielectric, exact Fresnel term, both sides       | `transmission` |
///
/// The lobes are independent integrands: a hit's radiance is the sum over them.
struct Material {
  std::string name = "default";
  glm::vec3 diffuse{0.7F};       ///< albedo
  glm::vec3 specular{0.0F};      ///< reflectance at normal incidence of glossy or mirror
  float schlick = 0.0F;          ///< 0: `specular` in all directions; 1: white at grazing angles
  float roughness = 0.0F;        ///< alpha of GGX, 0 to 1; 0: a mirror
  glm::vec3 transmission{0.0F};  ///< tint of glass, for reflection and refraction alike
  float ior = 1.5F;              ///< of glass, inside over outside, 1 to 100
  glm::vec3 emission{0.0F};      ///< radiance to both sides

  [[nodiscard]] bool is_diffuse() const { return diffuse != glm::vec3(0.0F); }
  [[nodiscard]] bool is_glossy() const { return specular != glm::vec3(0.0F) && roughness > 0.0F; }
  [[nodiscard]] bool is_mirror() const { return specular != glm::vec3(0.0F) && roughness == 0.0F; }
  [[nodiscard]] bool is_glass() const { return transmission != glm::vec3(0.0F); }
  [[nodiscard]] bool is_emissive() const { return emission != glm::vec3(0.0F); }
};

}  // namespace ti
