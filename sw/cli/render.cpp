// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <chrono>
#include <cstdio>
#include <functional>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "cli/machine.hpp"
#include "cli/summary.hpp"
#include "cli/traced_run.hpp"
#include "io/exr.hpp"
#include "io/file.hpp"
#include "io/npy.hpp"
#include "io/png.hpp"
#include "render/film.hpp"
#include "render/heat_map.hpp"
#include "render/path.hpp"
#include "render/plan.hpp"
#include "scene/geometry.hpp"

namespace ti {
namespace {

struct Size {
  int width, height;
};

Size parse_size(const std::string& text) {
  int width = 0;
  int height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 1 ||
      height < 1 || width > kMaxSide || height > kMaxSide) {
    throw Error(
        fmt::format("SIZE={}: give a size as WIDTHxHEIGHT, each from 1 to {}, such as 256x256",
                    text, kMaxSide));
  }
  return {width, height};
}

constexpr double kOcclusion = 0.05;  ///< of the scene's diagonal, how far ambient occlusion looks

/// Adds a picture of a count a pixel.
void add_heat_map(Files& files, const char* what, const std::vector<std::uint64_t>& per_pixel,
                  int spp, const Size& size) {
  HeatMap map = heat_map(per_pixel, spp, size.width, size.height);
  fmt::print("{0}.png: {0} a sample of a pixel, from 0 (dark) to {1:.0f} and more (bright)\n", what,
             map.top);
  files.add(fmt::format("{}.png", what), std::move(map.png));
}

/// What paths are traced on: the session, in the waves that were asked for. Counts for each pixel.
class Tracing {
 public:
  Tracing(Session& session, const Arguments& arguments, std::size_t pixels, Report& report)
      : session_(session),
        waves_(arguments.waves),
        keep_rays_(arguments.dump),
        report_(report),
        steps_(pixels),
        tests_(pixels) {}

  std::vector<Hit> operator()(std::span<const Ray> rays, std::span<const std::uint32_t> pixels) {
    const std::size_t before = report_.total.hits.size();
    check_ray_count("this picture with its effects", before + rays.size());
    trace_waves(session_, rays, waves_, report_);
    const Wave& total = report_.total;
    for (std::size_t i = before; i < total.hits.size(); ++i) {
      steps_[pixels[i - before]] += total.hits[i].steps;
      if (!total.tests.empty()) tests_[pixels[i - before]] += total.tests[i];
    }
    if (keep_rays_) rays_.insert(rays_.end(), rays.begin(), rays.end());
    const auto first = total.hits.begin() + static_cast<std::ptrdiff_t>(before);
    return {first, total.hits.end()};
  }

  [[nodiscard]] const std::vector<std::uint64_t>& steps() const { return steps_; }
  [[nodiscard]] const std::vector<std::uint64_t>& tests() const { return tests_; }
  [[nodiscard]] const std::vector<Ray>& rays() const { return rays_; }

 private:
  Session& session_;
  int waves_;
  bool keep_rays_;
  Report& report_;
  std::vector<std::uint64_t> steps_;
  std::vector<std::uint64_t> tests_;
  std::vector<Ray> rays_;
};

void check(const Arguments& arguments, const Size& size) {
  if (arguments.spp < 1 || arguments.spp > 4096)
    throw Error(fmt::format("SPP={}: give 1 to 4096", arguments.spp));
  if (arguments.bounces < 0 || arguments.bounces > 100)
    throw Error(fmt::format("BOUNCES={}: give 0 to 100", arguments.bounces));
  check_ray_count(fmt::format("SIZE={} SPP={}", arguments.size, arguments.spp),
                  static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height),
                  static_cast<std::uint64_t>(arguments.spp));
}

}  // namespace

int render(Arguments& arguments) {
  const Size size = parse_size(arguments.size);
  check_folder(arguments.run.out);
  const EffectRequest request = EffectRequest::of(arguments.effects);
  check(arguments, size);
  arguments.run.tests = true;
  Progress progress;
  Session session = start(arguments, progress);
  const Scene& scene = session.scene();
  const FilmSize film_size{.width = size.width,
                           .height = size.height,
                           .spp = arguments.spp,
                           .bounces = arguments.bounces};
  Report report{.request = {.command = "render",
                            .rays = {},
                            .size = {{size.width, size.height}},
                            .spp = arguments.spp,
                            .effects = arguments.effects,
                            .bounces = arguments.bounces,
                            .seed = arguments.seed},
                .total = {},
                .waves = {}};
  report.picture.plan = make_plan(scene, film_size, request);
  const Plan& plan = *report.picture.plan;
  if (!arguments.keys.empty()) return write_keys(arguments, session, plan);
  print_plan(plan);
  report.picture.machine = machine_plan_of(arguments, session, plan);
  progress.expect(plan.rays());

  const std::size_t pixels =
      static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  const auto bounds = bounds_of(scene.mesh);
  Tracing tracing(session, arguments, pixels, report);
  PathTracer tracer(scene,
                    {.width = size.width,
                     .height = size.height,
                     .spp = arguments.spp,
                     .bounces = arguments.bounces,
                     .seed = arguments.seed,
                     .format = session.options().config.format,
                     .effects = plan.effects,
                     .everything = plan.everything,
                     .radius = bounds ? static_cast<float>(kOcclusion * bounds->diagonal()) : 1.0F},
                    std::ref(tracing));
  Film film(size.width, size.height);
  const auto begin = std::chrono::steady_clock::now();
  tracer.render(film);
  check_log_ray(session, report.total.hits.size());
  const HostTimes& times = report.total.times;
  report.picture.shading =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() -
      times.engine - times.lock_step - times.truth;
  report.picture.rays = tracer.rays();

  const std::vector<glm::vec3> radiance = film.radiance();
  const bool occlusion = plan.has(Effect::AmbientOcclusion);
  report.picture.exposure = occlusion ? 1.0 : exposure_of(radiance);
  Files files(arguments);
  files.add("image.png",
            png_of(occlusion ? radiance : tone_mapped(radiance, report.picture.exposure),
                   size.width, size.height));
  files.add("radiance.exr", exr_of(radiance, size.width, size.height));
  if (arguments.dump) files.add("radiance.npy", radiance_npy(radiance, size.width, size.height));
  if (arguments.run.engine != EngineKind::Embree) {
    add_heat_map(files, "steps", tracing.steps(), arguments.spp, size);
    add_heat_map(files, "tests", tracing.tests(), arguments.spp, size);
  }
  files.add_dump(arguments, tracing.rays(), report.total, false);
  return finish(report, session, files);
}

}  // namespace ti
