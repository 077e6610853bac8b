// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "accel/scene_scale.hpp"
#include "base/error.hpp"
#include "base/limits.hpp"
#include "cli/frames.hpp"
#include "cli/machine.hpp"
#include "cli/picture.hpp"
#include "cli/summary.hpp"
#include "io/apng.hpp"
#include "io/exr.hpp"
#include "io/file.hpp"
#include "io/npy.hpp"
#include "io/png.hpp"
#include "render/plan.hpp"
#include "scene/camera.hpp"
#include "scene/geometry.hpp"

namespace ti {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kOcclusion = 0.05;  ///< of the scene's diagonal, how far ambient occlusion looks

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

void check(const Arguments& arguments, const Size& size) {
  if (arguments.spp < 1 || arguments.spp > 4096)
    throw Error(fmt::format("SPP={}: give 1 to 4096", arguments.spp));
  if (arguments.bounces < 0 || arguments.bounces > 100)
    throw Error(fmt::format("BOUNCES={}: give 0 to 100", arguments.bounces));
  if (!(arguments.fps > 0.0 && arguments.fps <= 1000.0))
    throw Error(fmt::format("FPS={}: give a number above 0, up to 1000", arguments.fps));
  check_ray_count(fmt::format("SIZE={} SPP={}", arguments.size, arguments.spp), size.pixels(),
                  static_cast<std::uint64_t>(arguments.spp));
  if (arguments.frames.empty()) return;
  if (arguments.run.log_ray)
    throw Error(
        "LOG_RAY= is of a picture alone, as each frame has its own rays; leave FRAMES= out");
  if (!arguments.base_file.empty() || !arguments.keys.empty())
    throw Error(
        "CONFIG=auto is of a picture alone, as each frame has a tree of its own; name a "
        "configuration for FRAMES=");
  if (!arguments.run.image.empty())
    throw Error("IMAGE= is of a picture alone, as FRAMES= has a tree for each frame");
}

/// What moves in some frame of the range.
Motion motion_in(const AnimatedScene& animated, const FrameRange& range) {
  Motion motion;
  if (range.count() == 1) return motion;
  Scene first = animated.scene;
  animated.animation.pose(first, static_cast<std::size_t>(range.first));
  Scene other = first;
  std::vector<std::uint8_t> moved(first.mesh.triangles.size());
  for (int f = range.first + 1; f < range.end; ++f) {
    animated.animation.pose(other, static_cast<std::size_t>(f));
    const Change change = change_between(first, other);
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] |= change.moved[i];
    motion.camera = motion.camera || change.view;
    motion.lights = motion.lights || change.lights;
  }
  motion.triangles = static_cast<std::size_t>(std::count(moved.begin(), moved.end(), 1));
  return motion;
}

/// A picture, or the pictures of an animation.
class Renderer {
 public:
  Renderer(Arguments& arguments, const Size& size, const EffectRequest& request)
      : arguments_(arguments), size_(size), film_(size.width, size.height) {
    const bool animated = !arguments.frames.empty();
    if (animated) {
      animated_ = load_animated_scene(arguments.run.scene, arguments.fps);
      range_ = parse_frames(arguments.frames, static_cast<int>(animated_.animation.frames.size()));
    } else {
      animated_.scene = load(arguments);
      animated_.animation.frames = {{.seconds = 0.0,
                                     .positions = {},
                                     .camera = animated_.scene.camera,
                                     .lights = animated_.scene.lights}};
    }
    report_.request = {.command = "render",
                       .rays = {},
                       .size = {{size.width, size.height}},
                       .spp = arguments.spp,
                       .effects = arguments.effects,
                       .bounces = arguments.bounces,
                       .frames = arguments.frames,
                       .seed = arguments.seed};
    animated_.animation.pose(animated_.scene, static_cast<std::size_t>(range_.first));
    const FilmSize film{.width = size.width,
                        .height = size.height,
                        .spp = arguments.spp,
                        .bounces = arguments.bounces,
                        .frames = range_.count()};
    report_.picture.plan = make_plan(animated_.scene, film, request, motion_in(animated_, range_));
    if (animated) {
      tiles_.emplace(size);
      reach_ = animated_.animation.reach(animated_.scene);
      const double largest = largest_coordinate(reach_);
      tree_ = std::make_unique<MovingTree>(build_options_of(arguments.run.config, largest), reach_);
    }
    tracing_.emplace(arguments, size.pixels(), report_, tiles_ ? &*tiles_ : nullptr);
    if (const auto bounds = bounds_of(animated_.scene.mesh))
      radius_ = static_cast<float>(kOcclusion * bounds->diagonal());
  }

  int run();

 private:
  [[nodiscard]] const Plan& plan() const { return *report_.picture.plan; }
  void render_frame(int frame);
  [[nodiscard]] std::vector<std::uint8_t> called_for(const Change& change,
                                                     const Scene& before) const;
  void open_session(bool anew);
  void trace_tiles(const std::vector<std::uint8_t>& wanted);
  void add_pictures(Files& files);

  Arguments& arguments_;
  Size size_;
  Progress progress_{};
  FrameRange range_{};
  AnimatedScene animated_{};  ///< in the frame that is made
  Box reach_{};               ///< of an animation
  Report report_{.request = {}, .total = {}, .waves = {}};
  Film film_;
  std::optional<Tiles> tiles_;
  std::unique_ptr<MovingTree> tree_;
  std::optional<Tracing> tracing_;
  std::unique_ptr<Session> session_;
  float radius_ = 1.0F;
  double opening_ = 0.0;                          ///< seconds that the first session took
  std::vector<std::vector<glm::vec3>> radiance_;  ///< of each frame
};

void Renderer::open_session(bool anew) {
  const Scene& scene = animated_.scene;
  session_.reset();  // one engine at a time
  const auto& machine = report_.total.counts.machine;
  progress_.begin_at(report_.total.hits.size(), machine ? machine->cycles : 0);
  if (!tree_) {
    session_ = std::make_unique<Session>(arguments_.run, scene);
    return;
  }
  BuildStats stats;
  SceneImage image = in_scene(arguments_.run, [&] {
    Image built = tree_->next(scene.mesh, anew, stats);
    return SceneImage{std::move(built), stats};
  });
  session_ = std::make_unique<Session>(arguments_.run, scene, std::move(image));
}

/// The tiles of a frame that must be traced, given what changed since the last.
std::vector<std::uint8_t> Renderer::called_for(const Change& change, const Scene& before) const {
  const bool all =
      radiance_.empty() || plan().everything || change.view || change.lights || change.emits;
  if (all) return std::vector<std::uint8_t>(tiles_->count(), 1);
  if (change.nothing()) return std::vector<std::uint8_t>(tiles_->count(), 0);
  const MovedRegion region(before.mesh, animated_.scene.mesh, change, reach_, session_->format());
  return tiles_->met(region);
}

void Renderer::trace_tiles(const std::vector<std::uint8_t>& wanted) {
  std::vector<std::uint32_t> pixels;
  for (const std::uint32_t pixel : morton_order(size_.width, size_.height)) {
    if (!wanted.empty() && wanted[tiles_->of(pixel)] == 0) continue;
    film_.clear(pixel);
    pixels.push_back(pixel);
  }
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (wanted[i] != 0) tiles_->forget(i);
  PathTracer tracer(session_->scene(),
                    {.width = size_.width,
                     .height = size_.height,
                     .spp = arguments_.spp,
                     .bounces = arguments_.bounces,
                     .seed = arguments_.seed,
                     .format = session_->format(),
                     .effects = plan().effects,
                     .everything = plan().everything,
                     .ends_dim_paths = plan().ends_dim_paths,
                     .radius = radius_},
                    [this](std::span<const Ray> rays, std::span<const std::uint32_t> places) {
                      return tracing_->trace(*session_, rays, places);
                    });
  tracer.render(film_, pixels);
  report_.picture.dim_paths = tracer.dim_paths();
  for (std::size_t k = 0; k < kRayKinds; ++k) report_.picture.rays[k] += tracer.rays()[k];
}

void Renderer::render_frame(int frame) {
  if (!tiles_) {
    trace_tiles({});
    radiance_.push_back(film_.radiance());
    return;
  }
  const auto begin = Clock::now();
  const Scene before = animated_.scene;
  if (plan().has(Effect::Motion))
    animated_.animation.pose(animated_.scene, static_cast<std::size_t>(frame));
  const Change change = change_between(before, animated_.scene);
  const std::vector<std::uint8_t> wanted = called_for(change, before);
  FrameReport out{
      .number = frame,
      .seconds = animated_.animation.frames[static_cast<std::size_t>(frame)].seconds,
      .moved_triangles = change.triangles,
      .tiles = wanted.size(),
      .traced_tiles = static_cast<std::size_t>(std::count(wanted.begin(), wanted.end(), 1)),
      .cycles = {}};
  const std::uint64_t rays = report_.total.hits.size();
  const auto cycles = [this] {
    const auto& machine = report_.total.counts.machine;
    return machine ? machine->cycles : 0;
  };
  const std::uint64_t cycles_before = cycles();
  if (out.traced_tiles != 0) {
    if (!radiance_.empty()) open_session(plan().everything);
    trace_tiles(wanted);
    out.tree = session_->tree();
  }
  out.rays = report_.total.hits.size() - rays;
  if (report_.total.counts.machine) out.cycles = cycles() - cycles_before;
  radiance_.push_back(film_.radiance());
  out.host_seconds = seconds_since(begin) + std::exchange(opening_, 0.0);
  report_.frames.push_back(out);
  print_frame(out);
}

void Renderer::add_pictures(Files& files) {
  const bool occlusion = plan().has(Effect::AmbientOcclusion);
  std::vector<glm::vec3> all;
  for (const auto& frame : radiance_) all.insert(all.end(), frame.begin(), frame.end());
  report_.picture.exposure = occlusion ? 1.0 : exposure_of(all);
  std::vector<std::string> pngs;
  for (std::size_t i = 0; i < radiance_.size(); ++i) {
    const std::vector<glm::vec3>& radiance = radiance_[i];
    const std::string number =
        tiles_ ? fmt::format("-{:04}", range_.first + static_cast<int>(i)) : "";
    pngs.push_back(png_of(occlusion ? radiance : tone_mapped(radiance, report_.picture.exposure),
                          size_.width, size_.height));
    files.add((tiles_ ? "frame" : "image") + number + ".png", pngs.back());
    files.add("radiance" + number + ".exr", exr_of(radiance, size_.width, size_.height));
    if (arguments_.dump)
      files.add("radiance" + number + ".npy", radiance_npy(radiance, size_.width, size_.height));
  }
  if (!tiles_) return;
  const auto& frames = animated_.animation.frames;
  const double step = frames.size() > 1 ? frames[1].seconds - frames[0].seconds : 1.0;
  files.add("animation.png", apng_of(pngs, step));
}

int Renderer::run() {
  show_progress(arguments_, progress_);
  const auto opens = Clock::now();
  open_session(true);
  opening_ = seconds_since(opens);
  session_->require_triangles();
  if (!arguments_.keys.empty()) return write_keys(arguments_, *session_, plan());
  print_tree(*session_);
  print_plan(plan());
  report_.picture.machine = machine_plan_of(arguments_, *session_, plan());
  progress_.expect(plan().rays());
  const auto begin = Clock::now();
  for (int frame = range_.first; frame < range_.end && !report_.total.stopped; ++frame)
    render_frame(frame);
  check_log_ray(*session_, report_.total.hits.size());
  const HostTimes& times = report_.total.times;
  report_.picture.shading = seconds_since(begin) - times.engine - times.lock_step - times.truth;
  Files files(arguments_);
  add_pictures(files);
  if (arguments_.run.engine != EngineKind::Embree) {
    const int samples = arguments_.spp * range_.count();
    add_heat_map(files, "steps", tracing_->steps(), samples, size_);
    add_heat_map(files, "tests", tracing_->tests(), samples, size_);
  }
  files.add_dump(arguments_, tracing_->rays(), report_.total, false);
  return finish(report_, *session_, files);
}

}  // namespace

int render(Arguments& arguments) {
  const Size size = parse_size(arguments.size);
  check_folder(arguments.run.out);
  const EffectRequest request = EffectRequest::of(arguments.effects);
  check(arguments, size);
  arguments.run.tests = true;
  return Renderer(arguments, size, request).run();
}

}  // namespace ti
