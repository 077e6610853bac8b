// SPDX-License-Identifier: Apache-2.0
#include "engine/session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>

#include "base/error.hpp"
#include "engine/stored_image.hpp"
#include "io/file.hpp"

namespace ti {
namespace {

Image build(const Scene& scene, const RunOptions& options, BuildStats& stats) {
  if (!options.image.empty())
    return load_image_of(options.image, scene.mesh, options.config.format, options.scene, stats);
  BuildOptions build_options;
  build_options.format = options.config.format;
  build_options.layout = options.layout;
  try {
    return build_image(scene.mesh, build_options, stats);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", options.scene.string(), error.what()));
  }
}

Image prepare(const Scene& scene, const RunOptions& options, BuildStats& stats) {
  Image image = build(scene, options, stats);
  if (stats.triangles != 0 &&
      stats.dropped_nonfinite + stats.dropped_zero_area == stats.triangles) {
    throw Error(fmt::format(
        "{}: none of its {} triangles is usable ({} not finite, {} of zero area); correct the mesh",
        options.scene.string(), stats.triangles, stats.dropped_nonfinite, stats.dropped_zero_area));
  }
  for (const std::string& warning : scene.warnings) fmt::print("warning: {}\n", warning);
  if (const std::string warning = dropped_warning(stats); !warning.empty())
    fmt::print("warning: {}\n", warning);
  fmt::print(
      "tree: {} triangles, {} nodes, {} leaves ({} empty), {:.2f} references a triangle, depth {}, "
      "{}\n",
      stats.triangles, stats.nodes, stats.leaves, stats.empty_leaves,
      stats.triangles ? static_cast<double>(stats.references) / stats.triangles : 0.0, stats.depth,
      options.image.empty() ? fmt::format("{:.2f} s", stats.seconds)
                            : "from " + options.image.string());
  return image;
}

}  // namespace

Session::Session(const RunOptions& options, Scene scene)
    : options_(options), scene_(std::move(scene)), image_(prepare(scene_, options_, stats_)) {}

std::uint64_t Session::Outcome::with_status(Status status) const {
  return static_cast<std::uint64_t>(std::count_if(
      hits.begin(), hits.end(), [status](const Hit& hit) { return hit.status == status; }));
}

bool Session::Outcome::good() const {
  return engine.lost == 0 && engine.duplicated == 0 && engine.lock_step.mismatches == 0 &&
         !engine.lock_step.work_differs && (!truth || truth->unexplained == 0) &&
         with_status(Status::MemoryError) == 0 && with_status(Status::Watchdog) == 0;
}

std::unique_ptr<Tracer> Session::model() const {
  return Tracer::create(image_, {.stack_depth = options_.config.stack_depth,
                                 .watchdog_steps = options_.config.watchdog_steps});
}

void Session::log_steps(std::span<const Ray> rays, const Tracer& model,
                        const std::filesystem::path& file) const {
  std::string text;
  Work work;
  const Tracer::Log line = [&text](const std::string& step) { text += step + "\n"; };
  (void)model.trace(rays[*options_.log_ray], work, &line);
  write_file(file, text);
}

Session::Outcome Session::trace(std::span<const Ray> rays) const {
  if (options_.log_ray && *options_.log_ray >= rays.size()) {
    throw Error(fmt::format("LOG_RAY={}: there are {} rays, numbered from 0", *options_.log_ray,
                            rays.size()));
  }
  const auto begin = std::chrono::steady_clock::now();
  Outcome outcome;
  if (options_.engine == EngineKind::Embree) {
    outcome.hits = Truth(scene_.mesh, options_.config.format).trace(rays);
  } else {
    const auto model = this->model();
    RtlOptions rtl = options_.rtl;
    if (options_.log_ray) {
      const auto log = [this](const char* who) {
        return options_.out / fmt::format("ray-{}.{}.log", *options_.log_ray, who);
      };
      log_steps(rays, *model, log("model"));
      rtl.log_ray = options_.log_ray;
      rtl.log_file = log("rtl");
    }
    const auto engine = options_.engine == EngineKind::Rtl
                            ? make_rtl_engine(image_, options_.config, *model, rtl)
                            : make_model_engine(*model);
    outcome.engine = engine->trace(rays);
    outcome.hits.reserve(rays.size());
    for (const HitBits& bits : outcome.engine.hits)
      outcome.hits.push_back(hit_of(options_.config.format, bits));
  }
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options_.truth && options_.engine != EngineKind::Embree) {
    outcome.truth = Truth(scene_.mesh, options_.config.format).compare(rays, outcome.hits);
  }
  return outcome;
}

}  // namespace ti
