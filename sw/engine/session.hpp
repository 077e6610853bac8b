// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "engine/engine.hpp"
#include "scene/scene.hpp"
#include "truth/truth.hpp"

namespace ti {

enum class EngineKind { Rtl, Model, Embree };

/// What every command needs.
struct RunOptions {
  Config config;
  std::filesystem::path scene;
  std::filesystem::path image;  ///< memory image in place of a tree that is built; empty: build
  EngineKind engine = EngineKind::Rtl;
  Layout layout = Layout::Odfl;
  RtlOptions rtl;
  bool truth = true;                     ///< compare with Embree and exact arithmetic
  std::optional<std::uint32_t> log_ray;  ///< write the nodes that this ray visits, by model and RTL
  std::filesystem::path out;             ///< folder for what is written
};

/// A scene with its tree and the engine that traces it.
class Session {
 public:
  /// Builds the tree, or loads its image, and prints a line on it. Throws `Error`, also for a mesh
  /// that has triangles of which none is usable.
  Session(const RunOptions& options, Scene scene);

  struct Outcome {
    std::vector<Hit> hits;
    EngineResult engine;               ///< `hits` empty for Embree
    std::optional<TruthReport> truth;  ///< none when switched off or for Embree
    double seconds = 0.0;

    /// Rays that retired with this status.
    [[nodiscard]] std::uint64_t with_status(Status status) const;
    /// No mismatch, nothing unexplained, lost or duplicated, no ray ended by the memory or the
    /// watchdog.
    [[nodiscard]] bool good() const;
  };
  [[nodiscard]] Outcome trace(std::span<const Ray> rays) const;

  /// The bit-exact model for this configuration on this scene; must not outlive the session.
  [[nodiscard]] std::unique_ptr<Tracer> model() const;

  [[nodiscard]] const RunOptions& options() const { return options_; }
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const BuildStats& tree() const { return stats_; }
  [[nodiscard]] const Image& image() const { return image_; }

 private:
  void log_steps(std::span<const Ray> rays, const Tracer& model,
                 const std::filesystem::path& file) const;

  RunOptions options_;
  Scene scene_;
  BuildStats stats_;
  Image image_;
};

/// Writes `report.json` for `outcome` of `rays` rays, and prints the summary that people read.
void report(const Session& session, const Session::Outcome& outcome, std::size_t rays,
            const std::filesystem::path& folder);

}  // namespace ti
