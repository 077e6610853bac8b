// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "base/format.hpp"
#include "render/bound.hpp"
#include "render/effects.hpp"
#include "render/film.hpp"
#include "render/lights.hpp"
#include "render/lobes.hpp"
#include "scene/scene.hpp"

namespace ti {

/// Kinds of rays of a picture; those of the lobes stand in the order of `Lobe`.
enum class RayKind : std::size_t { Primary, Shadow, Diffuse, Glossy, Mirror, Glass, Occlusion };
constexpr std::size_t kRayKinds = 7;
[[nodiscard]] const char* name_of(RayKind kind);

struct PathOptions {
  int width = 256;
  int height = 256;
  int spp = 1;
  int bounces = 4;  ///< scatterings of a path at most; 0: what emits is all there is
  std::uint64_t seed = 1;
  ScaledFormat format{};  ///< in which the engine that traces has the scene
  EffectSet effects{};
  /// Trace every ray that an effect could want, whatever it can add.
  bool everything = false;
  /// From the second sample on a path ends where all that it can add, exposed as the film is after
  /// the first, is less than a sixteenth of a step of the output.
  bool ends_dim_paths = false;
  float radius = 1.0F;  ///< how far ambient occlusion looks
};

/// Rays of each kind, by `RayKind`.
using RayCounts = std::array<std::uint64_t, kRayKinds>;

/// Paths that ended as they could not add a step of the output any more.
struct DimPaths {
  std::uint64_t paths = 0;
  double bound = 0.0;  ///< the most that a pixel can lack by it in the mean, in radiance
};

/// Path tracing in waves of rays (Laine, Karras, Aila, Megakernels Considered Harmful, HPG 2013),
/// on any engine.
///
/// The radiance of a sample is the sum, over the bounces, of what is emitted towards it and of the
/// direct light of each lobe; `docs/architecture.md`, "Pictures", has the rules. Each ray of
/// `trace` has its hit at the same place of the answer; fewer hits than rays end the picture, which
/// then has what those show.
class PathTracer {
 public:
  /// Traces rays, each of the pixel at its place; of shadow rays only hit or miss counts
  /// (`Ray::any`).
  using Trace = std::function<std::vector<Hit>(std::span<const Ray> rays,
                                               std::span<const std::uint32_t> pixels)>;

  PathTracer(const Scene& scene, const PathOptions& options, Trace trace);

  /// Adds all samples of `pixels`, y * width + x, to the film, or fewer when the engine stops. A
  /// scene without any light is lit from the eye.
  void render(Film& film, std::span<const std::uint32_t> pixels);
  /// The same of all pixels.
  void render(Film& film);

  [[nodiscard]] const RayCounts& rays() const { return rays_; }
  [[nodiscard]] DimPaths dim_paths() const;
  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  struct Path;
  struct Vertex;
  struct ShadowRay;
  struct Shaded;

  [[nodiscard]] bool asked(Effect effect) const {
    return options_.effects.test(static_cast<std::size_t>(effect));
  }
  [[nodiscard]] bool traces(Effect effect) const { return options_.everything || asked(effect); }
  void trace_batch(std::span<const std::uint32_t> pixels, std::uint32_t sample, Film& film);
  [[nodiscard]] std::vector<Path> begin(std::span<const std::uint32_t> pixels,
                                        std::uint32_t sample) const;
  [[nodiscard]] std::vector<Hit> hits_of(std::span<const Ray> rays,
                                         std::span<const std::uint32_t> pixels);
  [[nodiscard]] Shaded shade(const Path& path, const Hit& hit, int bounce) const;
  void add_direct(Shaded& out, const Path& path, const Vertex& vertex, int bounce) const;
  void add_scattered(Shaded& out, const Path& path, const Vertex& vertex, int bounce) const;
  [[nodiscard]] static std::optional<Lobe> chosen(const Vertex& vertex, double u);
  void add_occlusion(Shaded& out, const Path& path, const Vertex& vertex) const;
  /// Whether a ray that was scattered can add anything.
  [[nodiscard]] bool counts(const Path& next, Lobe lobe, int bounce) const;

  const Scene& scene_;
  PathOptions options_;
  Trace trace_;
  Lights lights_;
  std::optional<LightBound> bound_{};  ///< where paths end by it
  double least_ = 0.0;                 ///< radiance below which a path ends
  std::uint64_t ended_ = 0;
  std::vector<double> lacking_{};  ///< of each pixel, summed over its samples
  bool headlight_;
  bool leaves_;  ///< whether any ray starts at a hit
  RayCounts rays_{};
  bool stopped_ = false;
};

}  // namespace ti
