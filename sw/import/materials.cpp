// SPDX-License-Identifier: Apache-2.0
#include "import/materials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

#include "base/vec.hpp"

namespace ti {

namespace {

constexpr float kMaxIor = 100.0F;

/// Smoother than this is a mirror to every picture.
constexpr float kLeastRoughness = 1e-3F;

}  // namespace

Material material_of(const MtlValues& values) {
  Material out;
  out.name = values.name;
  out.diffuse = values.kd;
  out.emission = values.ke;
  out.ior = values.ni.value_or(out.ior);
  switch (values.illum) {
    case 0:
    case 1:
      return out;
    case 3:
      out.specular = values.ks;
      out.transmission = values.tf.value_or(glm::vec3(1.0F)) * values.tr.value_or(0.0F);
      if (out.ior == 0.0F) out.ior = 1.0F;
      return out;
    case 5:
      out.specular = values.ks;
      out.schlick = 1.0F;
      return out;
    case 4:
    case 6:
    case 7:
    case 9:
      out.transmission = values.tf.value_or(glm::vec3(1.0F));
      return out;
    default:
      out.specular = values.ks;
      out.roughness = std::sqrt(2.0F / (values.ns.value_or(0.0F) + 2.0F));
      return out;
  }
}

Material material_of(const GltfValues& values) {
  Material out;
  out.name = values.name;
  out.emission = values.emission;
  out.ior = values.ior;
  const float solid = (1.0F - values.metallic) * (1.0F - values.transmission);
  out.transmission = values.base * ((1.0F - values.metallic) * values.transmission);
  const float alpha = values.roughness * values.roughness;
  out.roughness = alpha < kLeastRoughness ? 0.0F : alpha;
  const float side = (values.ior - 1.0F) / (values.ior + 1.0F);
  const bool coated = values.roughness < 1.0F && solid > 0.0F;
  const float coat = coated ? side * side * solid : 0.0F;
  out.specular = values.base * values.metallic + coat;
  out.schlick = out.specular != glm::vec3(0.0F) ? 1.0F : 0.0F;
  out.diffuse = values.base * (solid - coat);
  return out;
}

std::string fault_of(const Material& material) {
  const auto colour = [](const char* what, const glm::vec3& c) -> std::string {
    if (finite(c) && std::min({c.x, c.y, c.z}) >= 0.0F) return {};
    return fmt::format("its {} is {} {} {}, and colours are finite and not negative", what, c.x,
                       c.y, c.z);
  };
  for (const auto& [what, c] : {std::pair{"diffuse colour (Kd)", material.diffuse},
                                {"specular colour (Ks)", material.specular},
                                {"transmission (Tf, Tr)", material.transmission},
                                {"emission (Ke)", material.emission}}) {
    if (const std::string fault = colour(what, c); !fault.empty()) return fault;
  }
  if (!(material.roughness >= 0.0F && material.roughness <= 1.0F))
    return fmt::format("its roughness (Ns) is {}, and there are 0 to 1 (Ns from 0 on)",
                       material.roughness);
  if (material.is_glass() && !(material.ior >= 1.0F && material.ior <= kMaxIor))
    return fmt::format("its index of refraction (Ni) is {}, and glass has 1 to {}", material.ior,
                       kMaxIor);
  return {};
}

bool keep_energy(Material& material) {
  const glm::vec3 sum = material.diffuse + material.specular + material.transmission;
  const float most = std::max({sum.x, sum.y, sum.z});
  // A rounded sum of shares that are 1 is no excess.
  if (!(most > 1.0F + 1e-6F)) return false;
  material.diffuse /= most;
  material.specular /= most;
  material.transmission /= most;
  return true;
}

}  // namespace ti
