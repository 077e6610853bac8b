// SPDX-License-Identifier: Apache-2.0
#include "render/lobes.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "render/sampler.hpp"

namespace ti {

namespace {

constexpr double kPi = 3.14159265358979323846;

double luminance(const glm::vec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

/// Axes with `n` as the third (Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1),
/// 2017).
struct Basis {
  glm::dvec3 s, t, n;

  explicit Basis(const glm::dvec3& normal) : n(normal) {
    const double sign = std::copysign(1.0, n.z);
    const double a = -1.0 / (sign + n.z);
    const double b = n.x * n.y * a;
    s = {1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    t = {b, sign + n.y * n.y * a, -n.y};
  }
  [[nodiscard]] glm::dvec3 local(const glm::dvec3& v) const {
    return {glm::dot(v, s), glm::dot(v, t), glm::dot(v, n)};
  }
  [[nodiscard]] glm::dvec3 world(const glm::dvec3& v) const { return v.x * s + v.y * t + v.z * n; }
};

/// Schlick, An Inexpensive BRDF Model for Physically-based Rendering, 1994.
glm::dvec3 reflectance(const Material& material, double cosine) {
  const double m = 1.0 - std::clamp(cosine, 0.0, 1.0);
  const double m2 = m * m;
  const glm::dvec3 f0(material.specular);
  return f0 + static_cast<double>(material.schlick) * (1.0 - f0) * (m2 * m2 * m);
}

/// GGX in the frame of the surface; directions with a positive third coordinate.
struct Ggx {
  double alpha2;

  explicit Ggx(double alpha) : alpha2(alpha * alpha) {}

  /// The sine is not from the cosine, which has none of its bits on a smooth surface.
  [[nodiscard]] double normals(const glm::dvec3& h) const {
    const double d = h.z * h.z * alpha2 + (h.x * h.x + h.y * h.y);
    return alpha2 / (kPi * d * d);
  }
  /// Smith's Lambda.
  [[nodiscard]] double lambda(const glm::dvec3& v) const {
    const double c2 = v.z * v.z;
    return 0.5 * (std::sqrt(1.0 + alpha2 * std::max(0.0, 1.0 - c2) / c2) - 1.0);
  }
};

constexpr double kLeastCosine = 1e-9;  ///< grazing beyond this reflects nothing

std::optional<Scattered> scatter_glossy(const Material& material, const Place& place,
                                        const glm::dvec2& u) {
  const Basis basis(place.normal);
  const glm::dvec3 eye = basis.local(place.to_eye);
  if (!(eye.z > kLeastCosine)) return std::nullopt;
  // A normal of the microfacets that the eye sees: a point of the hemisphere's projection,
  // stretched.
  const double alpha = material.roughness;
  const glm::dvec3 stretched = glm::normalize(glm::dvec3(alpha * eye.x, alpha * eye.y, eye.z));
  const Basis view(stretched);
  glm::dvec2 p = disc(u);
  const double s = 0.5 * (1.0 + stretched.z);
  // The axis of the disc that is warped lies along the projection of the surface's normal.
  const glm::dvec3 up = glm::dvec3(0.0, 0.0, 1.0) - stretched.z * stretched;
  const double length = glm::length(up);
  const glm::dvec3 axis_y = length > 1e-9 ? up / length : view.t;
  const glm::dvec3 axis_x = glm::cross(axis_y, stretched);
  const double rim = std::sqrt(std::max(0.0, 1.0 - p.x * p.x));
  p.y = (1.0 - s) * rim + s * p.y;
  const double z = std::sqrt(std::max(0.0, 1.0 - p.x * p.x - p.y * p.y));
  const glm::dvec3 n = p.x * axis_x + p.y * axis_y + z * stretched;
  const glm::dvec3 half = glm::normalize(glm::dvec3(alpha * n.x, alpha * n.y, std::max(0.0, n.z)));
  const glm::dvec3 light = 2.0 * glm::dot(eye, half) * half - eye;
  if (!(light.z > kLeastCosine)) return std::nullopt;
  Scattered out;
  out.direction = glm::normalize(basis.world(light));
  out.density = density(Lobe::Glossy, material, place, out.direction);
  if (!(out.density > 0.0)) return std::nullopt;
  out.weight = evaluate(Lobe::Glossy, material, place, out.direction) / out.density;
  return out;
}

std::optional<Scattered> scatter_glass(const Material& material, const Place& place,
                                       double choice) {
  const double index = place.entering ? material.ior : 1.0 / material.ior;
  const double cosine = std::clamp(glm::dot(place.normal, place.to_eye), 0.0, 1.0);
  const double reflected = fresnel(cosine, index);
  const glm::dvec3 tint(material.transmission);
  if (choice < reflected)
    return Scattered{.direction = glm::normalize(2.0 * cosine * place.normal - place.to_eye),
                     .weight = tint};
  const double sine2 = (1.0 - cosine * cosine) / (index * index);
  const double inside = std::sqrt(std::max(0.0, 1.0 - sine2));
  const glm::dvec3 direction = -place.to_eye / index + (cosine / index - inside) * place.normal;
  return Scattered{.direction = glm::normalize(direction), .weight = tint / (index * index)};
}

}  // namespace

bool has(Lobe lobe, const Material& material) {
  switch (lobe) {
    case Lobe::Diffuse:
      return material.is_diffuse();
    case Lobe::Glossy:
      return material.is_glossy();
    case Lobe::Mirror:
      return material.is_mirror();
    case Lobe::Glass:
      return material.is_glass();
  }
  return false;
}

std::array<double, kLobes> chances(const Material& material) {
  std::array<double, kLobes> out{};
  double sum = 0.0;
  for (std::size_t i = 0; i < kLobes; ++i) {
    const auto lobe = static_cast<Lobe>(i);
    if (!has(lobe, material)) continue;
    out[i] = luminance(lobe == Lobe::Diffuse ? material.diffuse
                       : lobe == Lobe::Glass ? material.transmission
                                             : material.specular);
    // At grazing angles a dark surface with a Fresnel term shines too.
    if (lobe == Lobe::Glossy || lobe == Lobe::Mirror)
      out[i] += 0.1 * material.schlick * (1.0 - out[i]);
    sum += out[i];
  }
  if (sum > 0.0)
    for (double& chance : out) chance /= sum;
  return out;
}

double fresnel(double cosine, double index) {
  if (index == 1.0) return 0.0;  // no surface, to the last bit
  const double sine2 = (1.0 - cosine * cosine) / (index * index);
  if (sine2 >= 1.0) return 1.0;
  const double inside = std::sqrt(1.0 - sine2);
  const double s = (cosine - index * inside) / (cosine + index * inside);
  const double p = (index * cosine - inside) / (index * cosine + inside);
  return 0.5 * (s * s + p * p);
}

glm::dvec3 evaluate(Lobe lobe, const Material& material, const Place& place,
                    const glm::dvec3& to_light) {
  const double cosine = glm::dot(place.normal, to_light);
  if (!(cosine > 0.0)) return glm::dvec3(0.0);
  if (lobe == Lobe::Diffuse) return glm::dvec3(material.diffuse) * (cosine / kPi);
  if (lobe != Lobe::Glossy || !material.is_glossy()) return glm::dvec3(0.0);
  const Basis basis(place.normal);
  const glm::dvec3 eye = basis.local(place.to_eye);
  const glm::dvec3 light = basis.local(to_light);
  if (!(eye.z > kLeastCosine) || !(light.z > kLeastCosine)) return glm::dvec3(0.0);
  const glm::dvec3 half = glm::normalize(eye + light);
  const Ggx ggx(material.roughness);
  // D G F / (4 cos cos), times the cosine of the light.
  const double masked = 1.0 / (1.0 + ggx.lambda(eye) + ggx.lambda(light));
  return reflectance(material, glm::dot(eye, half)) * (ggx.normals(half) * masked / (4.0 * eye.z));
}

double density(Lobe lobe, const Material& material, const Place& place,
               const glm::dvec3& to_light) {
  const double cosine = glm::dot(place.normal, to_light);
  if (!(cosine > 0.0)) return 0.0;
  if (lobe == Lobe::Diffuse) return cosine / kPi;
  if (lobe != Lobe::Glossy || !material.is_glossy()) return 0.0;
  const Basis basis(place.normal);
  const glm::dvec3 eye = basis.local(place.to_eye);
  const glm::dvec3 light = basis.local(to_light);
  if (!(eye.z > kLeastCosine) || !(light.z > kLeastCosine)) return 0.0;
  const glm::dvec3 half = glm::normalize(eye + light);
  const Ggx ggx(material.roughness);
  // Visible normals: D G1 (eye . half) / eye.z, over 4 (eye . half) for the reflection.
  return ggx.normals(half) / ((1.0 + ggx.lambda(eye)) * 4.0 * eye.z);
}

std::optional<Scattered> scatter(Lobe lobe, const Material& material, const Place& place,
                                 const glm::dvec2& u, double choice) {
  if (!has(lobe, material)) return std::nullopt;
  switch (lobe) {
    case Lobe::Diffuse: {
      const glm::dvec2 p = disc(u);
      const double z = std::sqrt(std::max(0.0, 1.0 - p.x * p.x - p.y * p.y));
      if (!(z > 0.0)) return std::nullopt;
      const glm::dvec3 direction = Basis(place.normal).world({p.x, p.y, z});
      return Scattered{.direction = glm::normalize(direction),
                       .weight = glm::dvec3(material.diffuse),
                       .density = z / kPi};
    }
    case Lobe::Glossy:
      return scatter_glossy(material, place, u);
    case Lobe::Mirror: {
      const double cosine = glm::dot(place.normal, place.to_eye);
      if (!(cosine > 0.0)) return std::nullopt;
      return Scattered{.direction = glm::normalize(2.0 * cosine * place.normal - place.to_eye),
                       .weight = reflectance(material, cosine)};
    }
    case Lobe::Glass:
      return scatter_glass(material, place, choice);
  }
  return std::nullopt;
}

}  // namespace ti
