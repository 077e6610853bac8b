// SPDX-License-Identifier: Apache-2.0
#include "engine/session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>

#include "accel/scene_scale.hpp"
#include "base/error.hpp"
#include "engine/stored_image.hpp"
#include "host/host_engine.hpp"
#include "io/file.hpp"
#include "scene/scaling.hpp"

namespace ti {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::filesystem::path log_file(const RunOptions& options, const char* who) {
  return options.out / fmt::format("ray-{}.{}.log", *options.log_ray, who);
}

}  // namespace

BuildOptions build_options_of(const Config& config, double largest) {
  BuildOptions options;
  options.format = config.format;
  options.layout = config.layout;
  options.test = test_kind(config.triangle_test);
  options.scale = scene_scale(largest, options.format, options.test);
  options.test_cost = config.tree_test_cost;
  options.leaf_cost = config.tree_leaf_cost;
  options.bad_splits = config.tree_bad_splits;
  return options;
}

Tracer::Options tracer_options_of(const Config& config) {
  return {.stack_depth = config.stack_depth,
          .watchdog_steps = config.watchdog_steps,
          .interval_cull = config.interval_cull,
          .interval_guard = config.interval_guard,
          .early_exit = config.early_exit,
          .restart = config.restart,
          .traversal = config.traversal,
          .any_hit = config.any_hit};
}

SceneImage scene_image_of(const Scene& scene, const RunOptions& options) {
  BuildStats stats;
  if (!options.image.empty()) {
    Image image = load_image_of(options.image, scene.mesh, options.config, options.scene, stats);
    return {std::move(image), stats};
  }
  return in_scene(options, [&] {
    const double largest = largest_coordinate(scene.mesh);
    Image image = build_image(scene.mesh, build_options_of(options.config, largest), stats);
    return SceneImage{std::move(image), stats};
  });
}

std::vector<SceneImage> scene_images_of(const Scene& scene, const RunOptions& options,
                                        std::span<const TestKind> tests) {
  return in_scene(options, [&] {
    std::vector<SceneImage> images;
    for (BuiltImage& built : build_images(
             scene.mesh, build_options_of(options.config, largest_coordinate(scene.mesh)), tests))
      images.push_back({std::move(built.image), built.stats});
    return images;
  });
}

HostTimes& HostTimes::operator+=(const HostTimes& other) {
  engine += other.engine;
  lock_step += other.lock_step;
  truth += other.truth;
  return *this;
}

Wave& Wave::operator+=(const Wave& next) {
  const std::uint64_t start = counts.machine ? counts.machine->cycles : 0;
  for (const std::uint64_t cycle : next.answered) answered.push_back(start + cycle);
  hits.insert(hits.end(), next.hits.begin(), next.hits.end());
  tests.insert(tests.end(), next.tests.begin(), next.tests.end());
  counts += next.counts;
  lock_step += next.lock_step;
  if (truth && next.truth)
    *truth += *next.truth;
  else if (next.truth)
    truth = next.truth;
  times += next.times;
  stopped = stopped || next.stopped;
  return *this;
}

std::uint64_t Wave::with_status(Status status) const {
  return static_cast<std::uint64_t>(std::count_if(
      hits.begin(), hits.end(), [status](const Hit& hit) { return hit.status == status; }));
}

bool Wave::good() const {
  return counts.lost == 0 && counts.duplicated == 0 && lock_step.mismatches == 0 &&
         !lock_step.work_differs && (!truth || truth->unexplained == 0) &&
         with_status(Status::MemoryError) == 0 && with_status(Status::Watchdog) == 0;
}

Session::Session(const RunOptions& options, Scene scene, SceneImage image)
    : options_(options),
      scene_(std::move(scene)),
      stats_(image.stats),
      warnings_(scene_.warnings),
      image_(std::move(image.image)),
      model_(Tracer::create(image_, tracer_options_of(options_.config))) {
  if (const std::string warning = dropped_warning(stats_); !warning.empty())
    warnings_.push_back(warning);
  if (std::string warning = range_warning(stats_.range, options_.config.format); !warning.empty())
    warnings_.push_back(std::move(warning));
  if (options_.truth || options_.engine == EngineKind::Embree)
    truth_ = std::make_unique<Truth>(scaled(scene_.mesh, format()), options_.config.format, "",
                                     Truth::kLooks, test_kind(options_.config.triangle_test));
  switch (options_.engine) {
    case EngineKind::Rtl: {
      RtlOptions rtl = options_.rtl;
      if (options_.log_ray) {
        rtl.log_ray = options_.log_ray;
        rtl.log_file = log_file(options_, "rtl");
      }
      engine_ = load_rtl_engine(options_.library, image_, options_.config, rtl);
      break;
    }
    case EngineKind::Model:
      engine_ = make_model_engine(*model_, options_.config.format);
      break;
    case EngineKind::Embree:
      engine_ = make_embree_engine(*truth_);
      break;
    case EngineKind::Board:
      if (options_.log_ray)
        throw Error("LOG_RAY=: a board does not show the steps of a ray; give ENGINE=model");
      engine_ = host::make_board_engine(options_.board, image_);
      break;
  }
}

void Session::require_triangles() const {
  if (stats_.triangles == 0 ||
      stats_.dropped_nonfinite + stats_.dropped_zero_area != stats_.triangles)
    return;
  const std::uint32_t lost = stats_.range.dropped_overflow + stats_.range.dropped_rounded;
  throw Error(fmt::format(
      "{}: none of its {} triangles is usable ({} not finite, {} of zero area{}); correct the mesh",
      options_.scene.string(), stats_.triangles, stats_.dropped_nonfinite, stats_.dropped_zero_area,
      lost == 0 ? ""
                : fmt::format("; {} of them only in {}", lost, name_of(options_.config.format))));
}

void Session::require_any_hit(const std::string& what) const {
  if (options_.config.any_hit) return;
  throw Error(
      fmt::format("{}: {} may end at any hit, and any_hit is false in this machine; set it to true",
                  options_.config.name, what));
}

void Session::log_steps(std::span<const Ray> rays) const {
  std::string text;
  Work work;
  const Tracer::Log line = [&text](const std::string& step) { text += step + "\n"; };
  (void)model_->trace(rays[*options_.log_ray - submitted_], work, &line);
  write_file(log_file(options_, "model"), text);
  if (options_.engine == EngineKind::Rtl) write_file(log_file(options_, "rtl"), "");
}

std::vector<Answer> Session::answers_of(std::span<const Ray> rays, bool& stopped) {
  constexpr std::size_t kAtOnce = 1024;  // answers between two looks at `stop`
  std::vector<Answer> answers;
  answers.reserve(rays.size());
  engine_->submit(rays);
  for (std::size_t before = 1; before != answers.size();) {
    before = answers.size();
    if (!stopped && options_.stop != nullptr && *options_.stop) stopped = engine_->cancel() != 0;
    engine_->poll(answers, kAtOnce);
  }
  return answers;
}

Wave Session::trace(std::span<const Ray> given) {
  const int scale = format().scale;
  std::vector<Ray> moved;
  if (scale != 0) {
    moved.reserve(given.size());
    for (const Ray& ray : given) moved.push_back(scaled(ray, scale));
  }
  std::span<const Ray> rays = scale == 0 ? given : moved;
  if (std::any_of(rays.begin(), rays.end(), [](const Ray& ray) { return ray.any; }))
    require_any_hit("these rays");
  if (options_.log_ray && *options_.log_ray >= submitted_ &&
      *options_.log_ray < submitted_ + rays.size() && options_.engine != EngineKind::Embree) {
    log_steps(rays);
  }
  Wave wave;
  const std::vector<Answer> answers = answers_of(rays, wave.stopped);
  const Counts after = engine_->counts();
  wave.counts = after - before_;
  const std::uint64_t start = before_.machine ? before_.machine->cycles : 0;
  before_ = after;
  wave.times.engine = wave.counts.seconds;

  // Rays are begun in their order, so those that a stop left out are the last.
  if (wave.stopped) rays = rays.first(wave.counts.rays + wave.counts.lost);
  wave.hits.resize(rays.size());
  if (wave.counts.machine) wave.answered.resize(rays.size());
  for (const Answer& answer : answers) {
    const std::size_t i = answer.ray - submitted_;
    wave.hits[i] = hit_of(engine_->format(), answer.hit);
    if (wave.counts.machine) wave.answered[i] = answer.cycle - start;
  }

  auto begin = Clock::now();
  if (options_.compared() || (options_.tests && options_.engine != EngineKind::Embree)) {
    ModelRun model = run_model(*model_, rays);
    if (options_.compared()) {
      const bool counted = wave.counts.machine && !wave.counts.machine->units.empty() &&
                           !wave.counts.machine->units.front().activities.empty();
      wave.lock_step = compare(model, answers, submitted_, counted ? &wave.counts.work : nullptr,
                               options_.rtl.answers_fail());
    }
    wave.tests = std::move(model.tests);
    wave.times.lock_step = seconds_since(begin);
  }
  begin = Clock::now();
  if (options_.truth && options_.engine != EngineKind::Embree) {
    wave.truth = truth_->compare(rays, wave.hits);
    wave.times.truth = seconds_since(begin);
  }
  if (scale != 0) {
    for (Hit& hit : wave.hits) hit = scaled(hit, -scale);
  }
  submitted_ += rays.size();
  return wave;
}

}  // namespace ti
