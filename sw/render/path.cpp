// SPDX-License-Identifier: Apache-2.0
#include "render/path.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>

#include "base/parallel.hpp"
#include "render/sampler.hpp"
#include "scene/camera.hpp"
#include "scene/geometry.hpp"

namespace ti {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::size_t kBatch = std::size_t{1} << 18;  ///< paths under way at once
constexpr std::size_t kPiece = 1024;
/// Of a step of the output: a sample may end a path of each lobe at its first hit, and one more
/// behind each, so that all of them are less than half a step.
constexpr double kDimShare = 16.0;

/// What belongs to each lobe, in their order.
constexpr std::array<Effect, kLobes> kEffectOf{Effect::Interreflection, Effect::Glossy,
                                               Effect::Mirror, Effect::Glass};
constexpr std::array<RayKind, kLobes> kKindOf{RayKind::Diffuse, RayKind::Glossy, RayKind::Mirror,
                                              RayKind::Glass};
/// A mirror has one direction.
constexpr std::array<Purpose, kLobes> kPurposeOf{Purpose::Diffuse, Purpose::Glossy, Purpose::Glass,
                                                 Purpose::Glass};

/// Veach, Optimally Combining Sampling Techniques, SIGGRAPH 1995, with exponent 2.
double power_heuristic(double mine, double other) {
  const double a = mine * mine;
  return a > 0.0 ? a / (a + other * other) : 0.0;
}

}  // namespace

const char* name_of(RayKind kind) {
  constexpr std::array<const char*, kRayKinds> kNames{"primary", "shadow", "diffuse",  "glossy",
                                                      "mirror",  "glass",  "occlusion"};
  return kNames[static_cast<std::size_t>(kind)];
}

/// A ray of a sample that is under way, and what its light counts for.
struct PathTracer::Path {
  Ray ray;
  std::uint32_t root = 0;  ///< number of its sample in the batch
  std::uint32_t pixel = 0;
  std::uint32_t sample = 0;
  RayKind kind = RayKind::Primary;
  glm::dvec3 throughput{1.0};
  /// What emissive triangles that it meets count for: all, nothing (matt surfaces have them from
  /// shadow rays), or by the power heuristic with this density.
  enum class Emission { All, None, Weighed } emission = Emission::All;
  double density = 0.0;
};

/// Light that counts unless something is between.
struct PathTracer::ShadowRay {
  Ray ray;
  glm::dvec3 radiance;
};

/// What comes of a hit, in the order in which it counts.
struct PathTracer::Shaded {
  glm::dvec3 emitted{0.0};
  std::vector<ShadowRay> shadows;
  std::vector<Path> next;
  std::uint32_t ended = 0;  ///< paths that could not add a step of the output,
  double lacking = 0.0;     ///< and the most that they could
};

/// A hit as shading sees it.
struct PathTracer::Vertex {
  glm::dvec3 position;
  Place place;
  const Material* material = nullptr;
  glm::vec3 front{0.0F};                ///< where rays leave on the side of the ray
  glm::vec3 back{0.0F};                 ///< and on the other, of glass
  std::array<double, kLobes> chance{};  ///< of each lobe to get the ray
};

PathTracer::PathTracer(const Scene& scene, const PathOptions& options, Trace trace)
    : scene_(scene),
      options_(options),
      trace_(std::move(trace)),
      lights_(scene),
      headlight_(is_unlit(scene)) {
  EffectSet of_rays = options.effects;
  for (const Effect effect : {Effect::Lens, Effect::Roulette, Effect::Motion, Effect::DimPaths})
    of_rays.reset(static_cast<std::size_t>(effect));
  leaves_ = options.everything || of_rays.any();
  if (!options.ends_dim_paths) return;
  bound_.emplace(scene, options.bounces);
  lacking_.resize(static_cast<std::size_t>(options.width) *
                  static_cast<std::size_t>(options.height));
}

void PathTracer::render(Film& film) { render(film, morton_order(options_.width, options_.height)); }

void PathTracer::render(Film& film, std::span<const std::uint32_t> pixels) {
  for (int s = 0; s < options_.spp; ++s) {
    if (s == 1 && options_.ends_dim_paths)
      least_ = kOutputStep / kDimShare / exposure_of(film.radiance());
    for (std::size_t at = 0; at < pixels.size() && !stopped_; at += kBatch) {
      const std::size_t count = std::min(kBatch, pixels.size() - at);
      trace_batch(pixels.subspan(at, count), static_cast<std::uint32_t>(s), film);
    }
  }
}

DimPaths PathTracer::dim_paths() const {
  DimPaths out{.paths = ended_};
  for (const double lacking : lacking_) out.bound = std::max(out.bound, lacking / options_.spp);
  return out;
}

std::vector<PathTracer::Path> PathTracer::begin(std::span<const std::uint32_t> pixels,
                                                std::uint32_t sample) const {
  const CameraRays camera(scene_.camera, options_.width, options_.height);
  const bool lens = traces(Effect::Lens);
  const auto width = static_cast<std::uint32_t>(options_.width);
  std::vector<Path> paths(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Sampler random(options_.seed, pixels[i], sample);
    const glm::dvec2 corner(pixels[i] % width, pixels[i] / width);
    const glm::dvec2 inside =
        options_.spp == 1 ? glm::dvec2(0.5) : random.get2({0, Purpose::Pixel});
    const glm::dvec2 on_lens = lens ? disc(random.get2({0, Purpose::Lens})) : glm::dvec2(0.0);
    paths[i].ray = camera.at(corner + inside, on_lens);
    paths[i].root = static_cast<std::uint32_t>(i);
    paths[i].pixel = pixels[i];
    paths[i].sample = sample;
  }
  return paths;
}

std::vector<Hit> PathTracer::hits_of(std::span<const Ray> rays,
                                     std::span<const std::uint32_t> pixels) {
  if (rays.empty() || stopped_) return {};
  std::vector<Hit> hits = trace_(rays, pixels);
  if (hits.size() < rays.size()) stopped_ = true;
  return hits;
}

void PathTracer::trace_batch(std::span<const std::uint32_t> pixels, std::uint32_t sample,
                             Film& film) {
  std::vector<glm::dvec3> radiance(pixels.size(), glm::dvec3(0.0));
  std::vector<Path> paths = begin(pixels, sample);
  for (int bounce = 0; !paths.empty(); ++bounce) {
    std::vector<Ray> rays;
    std::vector<std::uint32_t> places;
    for (const Path& path : paths) {
      rays.push_back(path.ray);
      places.push_back(path.pixel);
    }
    const std::vector<Hit> hits = hits_of(rays, places);
    paths.resize(hits.size());  // fewer when stopped: the picture has what they show
    for (const Path& path : paths) ++rays_[static_cast<std::size_t>(path.kind)];

    std::vector<Shaded> shaded(paths.size());
    parallel_pieces(paths.size(), kPiece, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) shaded[i] = shade(paths[i], hits[i], bounce);
    });

    rays.clear();
    places.clear();
    for (std::size_t i = 0; i < paths.size(); ++i) {
      for (const ShadowRay& shadow : shaded[i].shadows) {
        rays.push_back(shadow.ray);
        places.push_back(paths[i].pixel);
      }
    }
    const std::vector<Hit> between = hits_of(rays, places);
    const RayKind kind = asked(Effect::AmbientOcclusion) ? RayKind::Occlusion : RayKind::Shadow;
    rays_[static_cast<std::size_t>(kind)] += between.size();

    std::vector<Path> next;
    std::size_t at = 0;
    for (std::size_t i = 0; i < paths.size(); ++i) {
      glm::dvec3& sum = radiance[paths[i].root];
      sum += shaded[i].emitted;
      for (const ShadowRay& shadow : shaded[i].shadows) {
        if (at < between.size() && !between[at].is_hit()) sum += shadow.radiance;
        ++at;
      }
      next.insert(next.end(), shaded[i].next.begin(), shaded[i].next.end());
      if (shaded[i].ended == 0) continue;
      ended_ += shaded[i].ended;
      lacking_[paths[i].pixel] += shaded[i].lacking;
    }
    paths = std::move(next);
  }
  for (std::size_t i = 0; i < pixels.size(); ++i) film.add(pixels[i], radiance[i]);
}

PathTracer::Shaded PathTracer::shade(const Path& path, const Hit& hit, int bounce) const {
  Shaded out;
  if (!hit.is_hit()) {
    out.emitted = path.throughput * glm::dvec3(scene_.background);
    return out;
  }
  const auto prim = static_cast<std::size_t>(hit.prim);
  const Surface surface = surface_at(scene_.mesh, path.ray, hit);
  const glm::dvec3 direction(path.ray.d);
  Vertex vertex;
  vertex.position = surface.position;
  vertex.material = &scene_.material_of(prim);
  vertex.place = {.normal = surface.normal,
                  .to_eye = -glm::normalize(direction),
                  .entering = glm::dot(direction, area_vector(scene_.mesh, prim)) < 0.0};
  if (vertex.material->is_emissive() && path.emission != Path::Emission::None) {
    double weight = 1.0;
    if (path.emission == Path::Emission::Weighed)
      weight = power_heuristic(path.density,
                               lights_.density(prim, glm::dvec3(path.ray.o), vertex.position));
    out.emitted = path.throughput * glm::dvec3(vertex.material->emission) * weight;
  }
  const bool occlusion = asked(Effect::AmbientOcclusion);
  if (bounce >= options_.bounces && !occlusion) return out;
  if (leaves_) vertex.front = departure(scene_.mesh, path.ray, hit, options_.format).origin;
  if (occlusion) {
    out.emitted = glm::dvec3(0.0);
    add_occlusion(out, path, vertex);
    return out;
  }
  if (leaves_ && vertex.material->is_glass()) {
    Ray backward = path.ray;
    backward.d = -backward.d;
    vertex.back = departure(scene_.mesh, backward, hit, options_.format).origin;
  }
  vertex.chance = chances(*vertex.material);
  if (bounce == 0) vertex.chance.fill(1.0);  // each lobe gets a ray of its own
  add_direct(out, path, vertex, bounce);
  add_scattered(out, path, vertex, bounce);
  return out;
}

void PathTracer::add_occlusion(Shaded& out, const Path& path, const Vertex& vertex) const {
  const Material white{.diffuse = glm::vec3(1.0F)};
  const Sampler random(options_.seed, path.pixel, path.sample);
  const auto ray =
      scatter(Lobe::Diffuse, white, vertex.place, random.get2({0, Purpose::Occlusion}), 0.0);
  if (!ray) return;
  out.shadows.push_back({.ray = {.o = vertex.front,
                                 .d = glm::vec3(ray->direction),
                                 .tmax = options_.radius,
                                 .any = true},
                         .radiance = glm::dvec3(1.0)});
}

void PathTracer::add_direct(Shaded& out, const Path& path, const Vertex& vertex, int bounce) const {
  const bool glossy_ray = traces(Effect::Glossy);
  // The lobes that have a density; glossy is weighed against its own rays where a light is chosen
  // with the density `of_light`.
  const auto reflected = [&](const glm::dvec3& toward, double of_light) {
    glm::dvec3 sum = evaluate(Lobe::Diffuse, *vertex.material, vertex.place, toward);
    if (!vertex.material->is_glossy()) return sum;
    double weight = 1.0;
    if (of_light > 0.0 && glossy_ray)
      weight = power_heuristic(of_light,
                               vertex.chance[static_cast<std::size_t>(Lobe::Glossy)] *
                                   density(Lobe::Glossy, *vertex.material, vertex.place, toward));
    return sum + weight * evaluate(Lobe::Glossy, *vertex.material, vertex.place, toward);
  };
  // Light that counts unless something is before its end, where anybody looks for that.
  const auto add = [&](const glm::dvec3& radiance, Effect effect, const auto& end_of) {
    if (radiance == glm::dvec3(0.0) && !options_.everything) return;
    if (!traces(effect)) {
      out.emitted += path.throughput * radiance;
      return;
    }
    const Lights::End end = end_of();
    out.shadows.push_back({.ray = {.o = vertex.front, .d = end.d, .tmax = end.tmax, .any = true},
                           .radiance = path.throughput * radiance});
  };
  const auto nowhere = [&] { return Lights::End{glm::vec3(vertex.place.normal), 0.0F}; };

  if (headlight_) {
    if (bounce != 0) return;
    // Light of the eye itself: nothing can be between, and it is as strong at any distance.
    out.emitted += path.throughput * reflected(vertex.place.to_eye, 0.0) * kPi;
    return;
  }
  const Sampler random(options_.seed, path.pixel, path.sample);
  for (std::size_t i = 0; i < lights_.count(); ++i) {
    const auto toward = lights_.toward(i, vertex.position);
    if (!toward) {
      add(glm::dvec3(0.0), Effect::Shadows, nowhere);
      continue;
    }
    add(reflected(toward->direction, 0.0) * toward->irradiance, Effect::Shadows,
        [&] { return lights_.end_of(i, vertex.front, options_.format.numbers); });
  }
  if (!lights_.has_area()) return;
  const auto point = lights_.sample(vertex.position, random.get2({bounce, Purpose::Light}));
  if (!point) {
    add(glm::dvec3(0.0), Effect::SoftShadows, nowhere);
    return;
  }
  // To where a ray would leave the light towards this surface, so that the light is not in its way.
  const auto end = [&] {
    const Ray back{.o = vertex.front, .d = glm::vec3(point->direction)};
    const glm::vec3 target = departure(scene_.mesh, back, point->hit, options_.format).origin;
    return Lights::End{target - vertex.front, 1.0F};
  };
  add(reflected(point->direction, point->density) * point->emission / point->density,
      Effect::SoftShadows, end);
}

std::optional<Lobe> PathTracer::chosen(const Vertex& vertex, double u) {
  std::optional<Lobe> out;
  for (std::size_t k = 0; k < kLobes; ++k) {
    if (vertex.chance[k] <= 0.0) continue;
    out = static_cast<Lobe>(k);
    if (u < vertex.chance[k]) break;
    u -= vertex.chance[k];
  }
  return out;
}

void PathTracer::add_scattered(Shaded& out, const Path& path, const Vertex& vertex,
                               int bounce) const {
  const Sampler random(options_.seed, path.pixel, path.sample);
  std::optional<Lobe> only;
  if (bounce > 0) {
    only = chosen(vertex, random.get1({bounce, Purpose::LobeChoice}));
    if (!only) only = Lobe::Diffuse;  // a black surface: its ray counts for nothing
  }
  for (std::size_t k = 0; k < kLobes; ++k) {
    const auto lobe = static_cast<Lobe>(k);
    if (only && lobe != *only) continue;
    if (!traces(kEffectOf[k])) continue;
    Path next = path;
    next.kind = kKindOf[k];
    next.throughput = glm::dvec3(0.0);
    next.ray = {.o = vertex.front, .d = glm::vec3(vertex.place.normal)};
    if (const auto scattered =
            scatter(lobe, *vertex.material, vertex.place, random.get2({bounce, kPurposeOf[k]}),
                    random.get1({bounce, Purpose::Glass}))) {
      const bool through = glm::dot(scattered->direction, vertex.place.normal) < 0.0;
      next.throughput = path.throughput * scattered->weight / vertex.chance[k];
      next.ray = {.o = through ? vertex.back : vertex.front, .d = glm::vec3(scattered->direction)};
      next.density = vertex.chance[k] * scattered->density;
      next.emission = lobe == Lobe::Diffuse  ? Path::Emission::None
                      : lobe == Lobe::Glossy ? Path::Emission::Weighed
                                             : Path::Emission::All;
    }
    if (!options_.everything && !counts(next, lobe, bounce)) continue;
    if (least_ > 0.0) {
      const glm::dvec3& t = next.throughput;
      const double most =
          std::max({t.x, t.y, t.z}) * bound_->arriving(options_.bounces - bounce - 1);
      if (most < least_) {
        ++out.ended;
        out.lacking += most;
        continue;
      }
    }
    if (asked(Effect::Roulette) && bounce > 0) {
      const double stays =
          std::min(1.0, std::max({next.throughput.x, next.throughput.y, next.throughput.z}));
      if (!(random.get1({bounce, Purpose::Roulette}) < stays)) continue;
      next.throughput /= stays;
    }
    out.next.push_back(next);
  }
}

bool PathTracer::counts(const Path& next, Lobe lobe, int bounce) const {
  if (next.throughput == glm::dvec3(0.0) || headlight_) return false;
  if (bounce + 1 < options_.bounces) return true;
  // The last ray adds what it meets that emits, and nothing that is lit.
  return scene_.background != glm::vec3(0.0F) || (lobe != Lobe::Diffuse && lights_.has_area());
}

}  // namespace ti
