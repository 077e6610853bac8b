// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/engine.hpp"
#include "engine/image_faults.hpp"

namespace ti {

/// What came of the images with one kind of fault.
struct FaultCount {
  std::uint64_t images = 0;
  std::uint64_t refused = 0;  ///< by the reader, before any ray
  std::uint64_t sound = 0;    ///< in all that the reader checks, contents too
  std::uint64_t rays = 0;
  std::uint64_t changed = 0;  ///< answered unlike on the whole image
  std::uint64_t memory_errors = 0;
  std::uint64_t watchdogs = 0;
  std::uint64_t silent = 0;       ///< rays through an unsound leaf that say that all is well
  std::uint64_t false_alarm = 0;  ///< rays that say memory failed in a sound image
  std::uint64_t mismatches = 0;   ///< between engine and model
  std::uint64_t lost = 0;         ///< or doubled, by the engine

  FaultCount& operator+=(const FaultCount& other);
  /// Nothing that must not be.
  [[nodiscard]] bool good() const;
};

/// Damaged images, each with its own fault and rays.
struct FaultCampaign {
  std::array<FaultCount, kImageFaults> counts;
  std::vector<std::string> examples;  ///< of what must not be, up to 8

  [[nodiscard]] FaultCount sum() const;
};

struct FaultSettings {
  Tracer::Options model;
  std::uint64_t first = 0;   ///< number of the first image
  std::uint64_t images = 1;  ///< kinds of faults take turns
  std::uint64_t seed = 1;    ///< with an image's number: its fault
  /// The rays of an image, by its number.
  std::function<std::vector<Ray>(std::uint64_t)> rays;
  /// Makes the engine that traces what the model traces, in lock-step; none: the model alone, on
  /// all processors.
  std::function<std::unique_ptr<Engine>(const Image&)> engine;
  std::function<void(std::uint64_t images)> progress;
  const std::atomic<bool>* stop = nullptr;
};

/// Damages `image` again and again and traces rays on what is left of it. The reader's checks of
/// contents are left out, as in a memory that goes bad after it was loaded; those of the header are
/// not.
[[nodiscard]] FaultCampaign run_faults(const Image& image, const FaultSettings& settings);

}  // namespace ti
