// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/tracer.hpp"

namespace ti {

/// What the caches of one kind of unit did.
struct CacheCounts {
  std::string name;
  std::uint64_t accesses = 0, hits = 0, merged = 0, misses = 0;
};

/// What the units of one kind did, summed over units and cores.
struct UnitCounts {
  std::string name;
  std::uint64_t units = 0;  ///< of this kind, in all cores
  /// Cycles by activity; they add up to `units` times the cycles. Empty without counters.
  std::vector<std::pair<std::string, std::uint64_t>> activities;
};

/// What only a machine has.
struct MachineCounts {
  std::uint64_t cycles = 0;
  std::uint64_t memory_bytes = 0;
  std::vector<CacheCounts> caches;
  std::vector<UnitCounts> units;  ///< in the order of the pipeline

  [[nodiscard]] const UnitCounts* unit(const std::string& name) const;
};

/// What an engine did. Counts of one engine can be added, and one snapshot taken from a later one.
struct Counts {
  std::uint64_t rays = 0;  ///< answered
  std::uint64_t lost = 0, duplicated = 0;
  double seconds = 0.0;  ///< of the host, in the engine
  Work work;             ///< all 0 for Embree
  std::optional<MachineCounts> machine;

  Counts& operator+=(const Counts& other);
  Counts& operator-=(const Counts& other);
};
[[nodiscard]] Counts operator-(Counts after, const Counts& before);

}  // namespace ti
