// SPDX-License-Identifier: Apache-2.0
#include "render/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "render/lights.hpp"
#include "render/lobes.hpp"

namespace ti {

namespace {

/// What the decisions look at.
struct Facts {
  std::vector<std::uint64_t> triangles;  ///< of each material
  std::uint64_t emitting = 0;            ///< triangles that emit
  std::string emitter;                   ///< the first such material
  std::size_t lights = 0;                ///< without an area, not black
  std::string light;                     ///< the first of them
  bool unlit = false;
  bool background = false;

  explicit Facts(const Scene& scene)
      : triangles(scene.materials.size()),
        unlit(is_unlit(scene)),
        background(scene.background != glm::vec3(0.0F)) {
    for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
      const std::size_t m = scene.mesh.material.empty() ? 0 : scene.mesh.material[i];
      ++triangles[m];
      if (!scene.materials[m].is_emissive()) continue;
      if (emitting++ == 0) emitter = scene.materials[m].name;
    }
    constexpr const char* kKinds[] = {"point", "spot", "directional"};
    for (const Light& l : scene.lights) {
      if (l.intensity == glm::vec3(0.0F)) continue;
      if (lights++ == 0) light = fmt::format("{} light {}", kKinds[int(l.kind)], l.name);
    }
  }

  /// The first material with a lobe that a triangle has, and how many triangles have such a one.
  [[nodiscard]] std::pair<std::string, std::uint64_t> with(const Scene& scene, Lobe lobe) const {
    std::pair<std::string, std::uint64_t> out;
    for (std::size_t m = 0; m < triangles.size(); ++m) {
      if (triangles[m] == 0 || !has(lobe, scene.materials[m])) continue;
      if (out.second == 0) out.first = scene.materials[m].name;
      out.second += triangles[m];
    }
    return out;
  }
};

Decision shadows(const Facts& facts) {
  Decision d{.effect = Effect::Shadows, .reason = "no light without an area"};
  d.bound = "exact";
  if (facts.unlit) {
    d.reason = "the only light is the eye's, and nothing is between";
  } else if (facts.lights != 0) {
    d.on = true;
    d.reason = fmt::format("{} lights without an area (first: {})", facts.lights, facts.light);
  }
  return d;
}

Decision soft_shadows(const Facts& facts) {
  Decision d{.effect = Effect::SoftShadows, .reason = "no triangle emits"};
  d.bound = "exact";
  if (facts.emitting != 0) {
    d.on = true;
    d.reason = fmt::format("{} triangles emit (first: `{}`)", facts.emitting, facts.emitter);
  }
  return d;
}

Decision lobe(const Scene& scene, const Facts& facts, const FilmSize& film, Lobe which,
              Effect effect, const char* what) {
  const auto [name, count] = facts.with(scene, which);
  Decision d{.effect = effect};
  d.bound = "exact";
  // A ray adds what it meets that emits, and what is lit there when a scattering is left.
  const bool sees_light =
      facts.background || (which != Lobe::Diffuse && facts.emitting != 0) || film.bounces > 1;
  if (film.bounces == 0) {
    d.reason = "no scattering is asked for";
  } else if (count == 0) {
    d.reason = fmt::format("no {} surface", what);
  } else if (facts.unlit) {
    d.reason = "the only light is the eye's, which ends at the first surface";
  } else if (!sees_light) {
    d.reason = "one scattering, and it meets nothing that emits";
  } else {
    d.on = true;
    d.reason = fmt::format("{} triangles are {} (first: `{}`)", count, what, name);
  }
  return d;
}

Decision lens(const Scene& scene) {
  const float aperture = scene.camera.aperture;
  Decision d{.effect = Effect::Lens, .on = aperture > 0.0F};
  d.reason =
      d.on ? fmt::format("the camera's aperture is {}", aperture) : "the camera has no aperture";
  d.bound = "exact";
  return d;
}

Decision moves(const FilmSize& film, const Motion& motion) {
  Decision d{.effect = Effect::Motion, .reason = "one frame"};
  d.bound = "exact but for rounding at what moved";
  if (film.frames > 1) {
    d.on = motion.triangles != 0 || motion.camera || motion.lights;
    d.reason = fmt::format("{} frames, and ", film.frames);
    if (!d.on)
      d.reason += "nothing moves";
    else if (motion.camera)
      d.reason += "the camera moves";
    else if (motion.triangles != 0)
      d.reason += fmt::format("{} triangles move", motion.triangles);
    else
      d.reason += "a light moves";
  }
  return d;
}

Decision dim_paths(const FilmSize& film, const Facts& facts) {
  Decision d{.effect = Effect::DimPaths, .on = true};
  d.bound = "exact";
  if (film.bounces < 1 || facts.unlit) {
    d.on = false;
    d.reason = "no path goes on";
  } else if (film.frames > 1) {
    d.reason = "the exposure of all frames is not known before";
  } else if (film.spp < 2) {
    d.reason = "the exposure is not known before the first sample";
  } else {
    d.on = false;
    d.reason = "from the second sample on a path ends where all it can add is under 1/16 of a step";
    d.bound = "in the mean under half a step of 8 bits, while the first sample's exposure holds";
  }
  return d;
}

}  // namespace

std::uint64_t Plan::rays() const {
  std::uint64_t sum = primary;
  for (const Decision& d : decisions) sum += d.rays;
  return sum;
}

Plan make_plan(const Scene& scene, const FilmSize& film, const EffectRequest& request,
               const Motion& motion) {
  const Facts facts(scene);
  Plan plan;
  plan.everything = request.base == EffectRequest::Base::All;
  plan.primary = static_cast<std::uint64_t>(film.width) * static_cast<std::uint64_t>(film.height) *
                 static_cast<std::uint64_t>(film.spp) * static_cast<std::uint64_t>(film.frames);
  plan.decisions = {shadows(facts), soft_shadows(facts)};
  const auto add = [&](Lobe which, Effect effect, const char* what) {
    plan.decisions.push_back(lobe(scene, facts, film, which, effect, what));
  };
  add(Lobe::Diffuse, Effect::Interreflection, "matt");
  add(Lobe::Glossy, Effect::Glossy, "glossy");
  add(Lobe::Mirror, Effect::Mirror, "mirror");
  add(Lobe::Glass, Effect::Glass, "glass");
  plan.decisions.push_back(lens(scene));
  plan.decisions.push_back({.effect = Effect::Roulette,
                            .reason = "on by name alone",
                            .bound = "exact in the mean, with more noise"});
  plan.decisions.push_back({.effect = Effect::AmbientOcclusion,
                            .reason = "a picture of its own, on by name alone",
                            .bound = "no part of other pictures"});
  plan.decisions.push_back(moves(film, motion));
  plan.decisions.push_back(dim_paths(film, facts));
  for (Decision& d : plan.decisions) {
    const auto i = static_cast<std::size_t>(d.effect);
    const bool by_name = d.effect == Effect::Roulette || d.effect == Effect::AmbientOcclusion;
    if (plan.everything && !by_name && !d.on) {
      d.on = true;
      d.reason = "all are asked for; " + d.reason;
    }
    if (request.base == EffectRequest::Base::None && d.on && d.effect != Effect::DimPaths) {
      d.on = false;
      d.reason = "none is asked for; " + d.reason;
    }
    if (request.added.test(i) || request.removed.test(i)) {
      d.on = request.added.test(i);
      d.reason = d.on ? "asked for by name" : "left out by name; " + d.reason;
      if (!d.on && !by_name) d.bound = "the picture lacks it";
    }
    plan.effects.set(i, d.on);
  }

  plan.ends_dim_paths = !plan.has(Effect::DimPaths) && !plan.everything && film.spp > 1 &&
                        film.frames == 1 && film.bounces > 0 && !facts.unlit;

  // Hits at which a path may scatter: the first, and those of one path a lobe behind it.
  std::uint64_t lobes = 0;
  for (const Effect effect :
       {Effect::Interreflection, Effect::Glossy, Effect::Mirror, Effect::Glass})
    lobes += plan.has(effect) ? 1 : 0;
  const auto behind = static_cast<std::uint64_t>(std::max(0, film.bounces - 1));
  const std::uint64_t hits = film.bounces == 0 ? 0 : plan.primary * (1 + lobes * behind);
  const bool occlusion = plan.has(Effect::AmbientOcclusion);
  for (Decision& d : plan.decisions) {
    if (!d.on) continue;
    switch (d.effect) {
      case Effect::Shadows:
        d.rays = occlusion || facts.unlit ? 0 : hits * scene.lights.size();
        break;
      case Effect::SoftShadows:
        d.rays = occlusion || facts.emitting == 0 ? 0 : hits;
        break;
      case Effect::Interreflection:
      case Effect::Glossy:
      case Effect::Mirror:
      case Effect::Glass:
        d.rays = occlusion ? 0 : hits;
        break;
      case Effect::AmbientOcclusion:
        d.rays = plan.primary;
        break;
      case Effect::Lens:
      case Effect::Roulette:
      case Effect::Motion:
      case Effect::DimPaths:
        break;
    }
  }
  return plan;
}

}  // namespace ti
