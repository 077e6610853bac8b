// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "scene/material.hpp"

namespace ti {

/// The lobes of a material (`scene/material.hpp`), each an integrand of its own.
enum class Lobe : std::size_t { Diffuse, Glossy, Mirror, Glass };
constexpr std::size_t kLobes = 4;

[[nodiscard]] bool has(Lobe lobe, const Material& material);

/// The probability of each lobe where one is chosen by its brightness; all 0 for a black material.
[[nodiscard]] std::array<double, kLobes> chances(const Material& material);

/// Where a surface is hit. All directions are of unit length and point away from it.
struct Place {
  glm::dvec3 normal;     ///< unit, on the side of `to_eye`
  glm::dvec3 to_eye;     ///< where the ray came from
  bool entering = true;  ///< of glass: the ray comes from outside
};

/// Reflected radiance over incident irradiance, times the cosine at the surface: f |cos|. 0 for
/// mirror and glass, whose light comes from single directions, and for `to_light` behind the
/// surface.
[[nodiscard]] glm::dvec3 evaluate(Lobe lobe, const Material& material, const Place& place,
                                  const glm::dvec3& to_light);

/// The density, a steradian, with which `scatter` gives `to_light`; 0 where `evaluate` is.
[[nodiscard]] double density(Lobe lobe, const Material& material, const Place& place,
                             const glm::dvec3& to_light);

/// A direction from which light is reflected to the eye.
struct Scattered {
  glm::dvec3 direction;  ///< unit; through the surface where its cosine with the normal is negative
  glm::dvec3 weight;     ///< f |cos| / density
  double density = 0.0;  ///< of a mirror and of glass: 0
};

/// Draws a direction by two numbers in [0, 1) and, to choose between reflection and refraction, a
/// third. None when the direction that was drawn is not on the side of the normal.
///
/// - Diffuse: by the cosine.
/// - Glossy: GGX (Walter et al., EGSR 2007) with height-correlated masking (Heitz, JCGT 3(2),
/// 2014),
///   drawn by visible normals (Heitz, JCGT 7(4), 2018). Single scattering: rough surfaces lose what
///   bounces between microfacets.
/// - Glass: Fresnel's equations for unpolarised light. Radiance is divided by the square of the
///   relative index when it comes through the surface, as energy is spread over more directions; a
///   path that enters and leaves has it cancelled.
[[nodiscard]] std::optional<Scattered> scatter(Lobe lobe, const Material& material,
                                               const Place& place, const glm::dvec2& u,
                                               double choice);

/// The share of unpolarised light that a smooth surface reflects: `cosine` of the angle on the side
/// that the light comes from, at least 0, and the index of the other side over this one's. 1 for
/// total internal reflection.
[[nodiscard]] double fresnel(double cosine, double index);

}  // namespace ti
