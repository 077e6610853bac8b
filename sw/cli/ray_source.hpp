// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/tracer.hpp"
#include "scene/ray.hpp"
#include "scene/scene.hpp"

namespace ti {

/// Where rays come from: a file, or `KIND:COUNT` to make them.
///
/// Kinds: `random` (around the mesh), `inside` (in its box, any direction), `primary` (camera), and
/// from the hits of primary rays `ao` (16 any-hit rays a hit, 5 % of the scene's diagonal long),
/// `diffuse` (one cosine-distributed closest-hit ray a hit), `shadow` (one any-hit ray a hit and
/// light). For tests of accuracy those of `AimedRays`: `uniform`, `edges`, `vertices`, `grazing`,
/// `far`; and `secondary`, one cosine-distributed ray from each hit of rays of any direction.
struct RaySource {
  std::string file;  ///< empty: made
  std::string kind;
  std::size_t count = 0;
};

/// Reads the text of RAYS=. A word before a colon is a kind, so that a file of such a name needs
/// its folder (`./a:1`). Throws `Error` for an empty text, an unknown kind or a count that is not 1
/// to `kMaxRays`.
[[nodiscard]] RaySource parse_ray_source(const std::string& text);

/// The rays; `model`, which has the scene in `format`, finds the hits that secondary rays start
/// from. Secondary kinds may give fewer than asked for when primary rays miss. Throws `Error` when
/// there are none.
[[nodiscard]] std::vector<Ray> make_rays(const RaySource& source, const Scene& scene,
                                         const Tracer& model, const ScaledFormat& format,
                                         std::uint64_t seed);

/// The kinds of rays that are counted in volume that `text` names: of `kAimNames`, or `secondary`.
/// Throws `Error` for a word that is none, and when there is none.
[[nodiscard]] std::vector<std::string> kinds_of(const std::string& text);

}  // namespace ti
