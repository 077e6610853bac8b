// SPDX-License-Identifier: Apache-2.0
#include "cli/ray_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <string_view>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "base/parallel.hpp"
#include "scene/aimed_rays.hpp"
#include "scene/geometry.hpp"
#include "scene/rays.hpp"
#include "scene/scaling.hpp"

namespace ti {
namespace {

constexpr std::array<std::string_view, 12> kKinds{"random",   "inside",  "primary", "ao",
                                                  "uniform",  "diffuse", "shadow",  "edges",
                                                  "vertices", "grazing", "far",     "secondary"};
constexpr int kAoSamples = 16;
constexpr double kAoRadius = 0.05;  // of the diagonal

bool is_word(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(),
                                      [](char c) { return (c >= 'a' && c <= 'z') || c == '-'; });
}

/// At least `count` camera rays in a square frame.
std::vector<Ray> camera_rays(const Scene& scene, std::size_t count, std::uint64_t seed) {
  const int side = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
  return primary_rays(scene.camera, side, side, 1, seed).rays;
}

/// The hit of a ray, in the units of the scene.
Hit hit_in_scene(const Tracer& model, const ScaledFormat& format, const Ray& ray) {
  Work work;
  return scaled(hit_of(format.numbers, model.trace(scaled(ray, format.scale), work)),
                -format.scale);
}

std::vector<Ray> secondary(const RaySource& source, const Scene& scene, const Tracer& model,
                           const ScaledFormat& format, std::uint64_t seed) {
  const std::size_t lights = std::max<std::size_t>(1, scene.lights.size());
  const std::size_t per_hit = source.kind == "ao"       ? kAoSamples
                              : source.kind == "shadow" ? lights
                                                        : 1;
  const std::vector<Ray> rays = camera_rays(scene, (source.count + per_hit - 1) / per_hit, seed);
  std::vector<Hit> hits(rays.size());
  parallel_pieces(rays.size(), 1024, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) hits[i] = hit_in_scene(model, format, rays[i]);
  });

  if (source.kind == "diffuse") return diffuse_rays(scene.mesh, format, rays, hits, seed);
  if (source.kind == "shadow")
    return shadow_rays(scene.mesh, format, rays, hits, light_places(scene));
  const auto bounds = bounds_of(scene.mesh);
  const double diagonal = bounds ? bounds->diagonal() : 0.0;
  return ao_rays(scene.mesh, format, rays, hits, kAoSamples,
                 static_cast<float>(kAoRadius * diagonal), seed);
}

/// Where `kind` is what rays are aimed at.
std::optional<Aim> aim_of(std::string_view kind) {
  const auto at = std::find(kAimNames.begin(), kAimNames.end(), kind);
  if (at == kAimNames.end()) return std::nullopt;
  return static_cast<Aim>(at - kAimNames.begin());
}

/// `count` rays aimed at the triangles of the mesh, none where it has none.
std::vector<Ray> aimed(const Mesh& mesh, Aim aim, std::size_t count, std::uint64_t seed) {
  std::vector<Ray> rays;
  if (mesh.triangles.empty()) return rays;
  rays.reserve(count);
  const AimedRays at(mesh, aim, seed);
  for (std::size_t i = 0; i < count; ++i) rays.push_back(at(i));
  return rays;
}

/// Rays from the hits of rays of any direction, until there are enough or hits are too rare.
std::vector<Ray> spawned(const Scene& scene, const Tracer& model, const ScaledFormat& format,
                         std::size_t count, std::uint64_t seed) {
  const AimedRays at(scene.mesh, Aim::Uniform, seed);
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  const std::uint64_t most = 64 * std::uint64_t{count} + 1024;
  for (std::uint64_t i = 0; i < most && hits.size() < count; ++i) {
    const Hit hit = hit_in_scene(model, format, at(i));
    if (!hit.is_hit()) continue;
    rays.push_back(at(i));
    hits.push_back(hit);
  }
  return diffuse_rays(scene.mesh, format, rays, hits, seed);
}

}  // namespace

RaySource parse_ray_source(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  if (text.empty()) throw Error("RAYS=: give a file rays.npy, or KIND:COUNT such as random:100000");
  if (colon == std::string::npos || !is_word(kind)) return {.file = text, .kind = {}, .count = 0};
  if (std::find(kKinds.begin(), kKinds.end(), kind) == kKinds.end()) {
    throw Error(fmt::format("RAYS={}: there is no kind `{}` of rays; the kinds are {}", text, kind,
                            fmt::join(kKinds, ", ")));
  }
  std::size_t count = 0;
  const char* begin = text.data() + colon + 1;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, count);
  if (error != std::errc{} || stop != end || count < 1 || count > kMaxRays) {
    throw Error(fmt::format("RAYS={}: the count after the colon must be 1 to {} (2^26, about 7 GB)",
                            text, kMaxRays));
  }
  return {.file = {}, .kind = kind, .count = count};
}

std::vector<Ray> make_rays(const RaySource& source, const Scene& scene, const Tracer& model,
                           const ScaledFormat& format, std::uint64_t seed) {
  std::vector<Ray> rays;
  if (source.kind == "random") {
    rays = random_rays(scene.mesh, source.count, seed);
  } else if (source.kind == "inside") {
    rays = inside_rays(scene.mesh, source.count, seed);
  } else if (source.kind == "primary") {
    rays = camera_rays(scene, source.count, seed);
  } else if (const std::optional<Aim> aim = aim_of(source.kind)) {
    rays = aimed(scene.mesh, *aim, source.count, seed);
  } else if (source.kind == "secondary") {
    rays = spawned(scene, model, format, source.count, seed);
  } else {
    rays = secondary(source, scene, model, format, seed);
  }
  if (rays.size() > source.count) rays.resize(source.count);
  if (rays.empty()) {
    throw Error(fmt::format(
        "RAYS={}:{}: the scene gives no such ray, as none hits it, or it has no triangle or light",
        source.kind, source.count));
  }
  return rays;
}

std::vector<std::string> kinds_of(const std::string& text) {
  std::istringstream words(text);
  std::vector<std::string> kinds;
  for (std::string kind; words >> kind;) {
    const bool known = kind == "secondary" ||
                       std::find(kAimNames.begin(), kAimNames.end(), kind) != kAimNames.end();
    if (!known) {
      throw Error(fmt::format("RAYS={}: there is no kind `{}` of rays; the kinds are {}, secondary",
                              text, kind, fmt::join(kAimNames, ", ")));
    }
    kinds.push_back(kind);
  }
  if (kinds.empty()) throw Error("RAYS=: give kinds of rays, such as edges vertices");
  return kinds;
}

}  // namespace ti
