// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/engine.hpp"

namespace ti {

/// Comparison of an engine with the model, ray by ray.
struct LockStep {
  bool on = false;
  std::uint64_t mismatches = 0;       ///< hits, status or step counts that differ
  bool work_differs = false;          ///< the sums over all rays differ
  std::vector<std::string> examples;  ///< up to 4, what differs in which ray

  LockStep& operator+=(const LockStep& other);
};

/// What the model did with each of some rays.
struct ModelRun {
  std::vector<HitBits> hits;
  std::vector<std::uint32_t> tests;  ///< passes (a) of each ray
  Work work;
};

/// Traces on all processors.
[[nodiscard]] ModelRun run_model(const Tracer& model, std::span<const Ray> rays);

/// Compares the answers for the rays from number `first` on. `work` is what the engine says it did,
/// none when it does not count; `excuse_memory`: misses that report a memory error are right.
[[nodiscard]] LockStep compare(const ModelRun& model, std::span<const Answer> answers,
                               std::uint64_t first, const Work* work, bool excuse_memory);

}  // namespace ti
