// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "base/error.hpp"
#include "engine/engine.hpp"
#include "engine/lock_step.hpp"
#include "scene/scene.hpp"
#include "truth/truth.hpp"

namespace ti {

enum class EngineKind { Rtl, Model, Embree, Board };

/// What every run needs.
struct RunOptions {
  Config config;
  std::filesystem::path scene;
  std::filesystem::path image;  ///< memory image in place of a tree that is built; empty: build
  EngineKind engine = EngineKind::Rtl;
  std::filesystem::path library;  ///< of the RTL, for `EngineKind::Rtl`
  std::filesystem::path board;    ///< its file, for `EngineKind::Board`
  RtlOptions rtl;
  bool lock_step = true;                 ///< compare the RTL or the board with the model
  bool truth = true;                     ///< compare with Embree and exact arithmetic
  bool tests = false;                    ///< count the triangle tests of each ray
  std::optional<std::uint32_t> log_ray;  ///< write the nodes that this ray visits, by model and RTL
  std::filesystem::path out;             ///< folder for those logs

  /// Whether the engine is one that the model checks.
  [[nodiscard]] bool compared() const {
    return lock_step && (engine == EngineKind::Rtl || engine == EngineKind::Board);
  }
  /// Set from outside, by a signal for example: rays that are not begun are left out.
  const std::atomic<bool>* stop = nullptr;
};

/// Seconds of the host.
struct HostTimes {
  double engine = 0.0;     ///< in the engine, simulated or not
  double lock_step = 0.0;  ///< in the model that checks it
  double truth = 0.0;      ///< in Embree and exact arithmetic

  HostTimes& operator+=(const HostTimes& other);
};

/// Rays that were traced together, and all that is known of them.
struct Wave {
  std::vector<Hit> hits;             ///< in the order of the rays; fewer when stopped
  std::vector<std::uint32_t> tests;  ///< triangle tests of each ray; empty when not counted
  /// Cycles from the start of the first wave to each answer, in the order of the rays; empty when
  /// no machine traced them.
  std::vector<std::uint64_t> answered;
  Counts counts;
  LockStep lock_step;
  std::optional<TruthReport> truth;  ///< none when switched off or for Embree
  HostTimes times;
  bool stopped = false;  ///< rays at the end were left out

  /// Puts a wave behind this one.
  Wave& operator+=(const Wave& next);
  /// Rays that retired with this status.
  [[nodiscard]] std::uint64_t with_status(Status status) const;
  /// No mismatch, nothing unexplained, lost or duplicated, no ray ended by the memory or the
  /// watchdog.
  [[nodiscard]] bool good() const;
};

/// How the tree of a run is to be built, where the largest |coordinate| of the scene, in all its
/// frames, is `largest`.
[[nodiscard]] BuildOptions build_options_of(const Config& config, double largest);
/// How its model traces.
[[nodiscard]] Tracer::Options tracer_options_of(const Config& config);

/// What `work` gives; an `Error` of it names the scene of the run first.
template <typename Work>
auto in_scene(const RunOptions& options, const Work& work) {
  try {
    return work();
  } catch (const Error& error) {
    throw Error(options.scene.string() + ": " + error.what());
  }
}

/// The memory image of a scene and what is to be said of its tree.
struct SceneImage {
  Image image;
  BuildStats stats;
};
/// Builds the tree of the scene, or loads its image. Throws `Error`.
[[nodiscard]] SceneImage scene_image_of(const Scene& scene, const RunOptions& options);
/// Builds them for several triangle tests in place of that of the machine; they share the tree.
[[nodiscard]] std::vector<SceneImage> scene_images_of(const Scene& scene, const RunOptions& options,
                                                      std::span<const TestKind> tests);

/// A scene with its tree, its model, its truth and the engine that traces it, each made once.
///
/// Rays and hits are in the units of the scene. Model, truth and engine have all places and t times
/// 2^scale of the image; so do step logs, and the rays that lock-step and truth show.
class Session {
 public:
  /// Throws `Error` when the engine cannot be had.
  Session(const RunOptions& options, Scene scene, SceneImage image);
  Session(const RunOptions& options, const Scene& scene)
      : Session(options, scene, scene_image_of(scene, options)) {}

  /// Throws `Error` for a mesh that has triangles of which none is usable.
  void require_triangles() const;

  /// Throws `Error` where the machine has no any-hit rays; `what` asks for them.
  void require_any_hit(const std::string& what) const;

  /// Traces rays on the one engine, whose caches are as the wave before left them.
  [[nodiscard]] Wave trace(std::span<const Ray> rays);

  /// The model, in the space of the image.
  [[nodiscard]] const Tracer& model() const { return *model_; }
  /// How the engine has the scene.
  [[nodiscard]] ScaledFormat format() const {
    return {options_.config.format, image_.header().scale, image_.header().test == TestKind::Woop};
  }
  [[nodiscard]] const RunOptions& options() const { return options_; }
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const BuildStats& tree() const { return stats_; }
  [[nodiscard]] const Image& image() const { return image_; }
  /// What a user should know of the scene and its tree, a sentence each.
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void log_steps(std::span<const Ray> rays) const;
  [[nodiscard]] std::vector<Answer> answers_of(std::span<const Ray> rays, bool& stopped);

  RunOptions options_;
  Scene scene_;
  BuildStats stats_;
  std::vector<std::string> warnings_;
  Image image_;
  std::unique_ptr<Tracer> model_;
  std::unique_ptr<Truth> truth_;  // none when nothing asks for it
  std::unique_ptr<Engine> engine_;
  Counts before_;
  std::uint64_t submitted_ = 0;
};

}  // namespace ti
