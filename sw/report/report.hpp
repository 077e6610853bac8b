// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/session.hpp"
#include "render/machine_plan.hpp"
#include "render/path.hpp"
#include "render/plan.hpp"

namespace ti {

/// What a run was asked for, beside its options: the rest of where a report comes from.
struct Request {
  std::string command;                     ///< render or trace
  std::string rays;                        ///< of trace: the file or KIND:COUNT
  std::optional<std::array<int, 2>> size;  ///< of render: width, height
  int spp = 1;
  std::string effects{};  ///< of render
  int bounces = 0;        ///< of render: scatterings of a path at most
  std::string frames{};   ///< of render: the frames of an animation
  std::uint64_t seed = 1;
};

/// What a picture called for and what it took; empty for other runs.
struct Picture {
  std::optional<Plan> plan;
  std::optional<MachinePlan> machine;
  RayCounts rays{};  ///< traced, of each kind
  double exposure = 1.0;
  DimPaths dim_paths{};
  double shading = 0.0;  ///< seconds of the host that rays and their light took
};

/// A frame of an animation.
struct FrameReport {
  int number = 0;
  double seconds = 0.0;  ///< when it is
  std::size_t moved_triangles = 0;
  std::size_t tiles = 0;  ///< of 8x8 pixels
  std::size_t traced_tiles = 0;
  std::uint64_t rays = 0;
  std::optional<std::uint64_t> cycles;
  BuildStats tree{};  ///< zero where nothing was traced
  double host_seconds = 0.0;
};

/// What a run did: everything that `report.json` holds, in raw counts, so that waves add up.
///
/// The JSON form is `report.schema.json` beside this file, version `kVersion`. Two runs of one
/// command differ only below `sim` and `time`.
struct Report {
  static constexpr int kVersion = 1;

  Request request;
  Picture picture{};
  Wave total;                         ///< hits, tests and truth of all rays
  std::vector<Counts> waves;          ///< of each wave, in order
  std::vector<FrameReport> frames{};  ///< of an animation

  /// Adds a wave.
  void add(Wave wave);

  /// The share of the host's time that the engine did not take.
  [[nodiscard]] double host_share() const;
};

/// The report as JSON, indented, with a newline at its end.
[[nodiscard]] std::string to_json(const Report& report, const Session& session);

/// The commit that this program was built from, with "+" behind it when files were changed; empty
/// outside a repository.
[[nodiscard]] const char* commit();

}  // namespace ti
