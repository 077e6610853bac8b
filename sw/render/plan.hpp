// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/effects.hpp"
#include "scene/scene.hpp"

namespace ti {

/// What a picture is asked for, beside its effects.
struct FilmSize {
  int width = 256;
  int height = 256;
  int spp = 1;
  int bounces = 4;
  int frames = 1;
};

/// What of a scene moves in some of the frames.
struct Motion {
  std::size_t triangles = 0;
  bool camera = false;
  bool lights = false;
};

/// Whether an effect is simulated, and why.
struct Decision {
  Effect effect;
  bool on = false;
  std::string reason{};    ///< the light, material or number that decided, as the end of a sentence
  std::uint64_t rays = 0;  ///< at most; 0 where it is off or needs none of its own
  std::string bound{};     ///< what leaving it out, or having it in, does to the picture
};

/// What a scene calls for: a pure function of scene, film, request and motion.
struct Plan {
  EffectSet effects;
  bool everything = false;          ///< rays are traced whatever they can add
  bool ends_dim_paths = false;      ///< `PathOptions::ends_dim_paths`
  std::uint64_t primary = 0;        ///< of all frames, at most
  std::vector<Decision> decisions;  ///< in the order of `Effect`

  [[nodiscard]] bool has(Effect effect) const {
    return effects.test(static_cast<std::size_t>(effect));
  }
  /// Rays of all kinds, at most.
  [[nodiscard]] std::uint64_t rays() const;
};

/// Decides by what the scene has, then by what the request adds and removes.
[[nodiscard]] Plan make_plan(const Scene& scene, const FilmSize& film, const EffectRequest& request,
                             const Motion& motion = {});

}  // namespace ti
