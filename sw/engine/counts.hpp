// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/work.hpp"

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

/// What a DRAM did (sim/dram/gddr3.ini), all channels together.
struct DramCounts {
  static constexpr int kMhz = 1000;  ///< its clock
  static constexpr int kChannels = 8;
  static constexpr int kBytesPerCycle = 128;  ///< at most

  std::uint64_t cycles = 0;    ///< of its clock
  std::uint64_t reads = 0;     ///< of a line from a row
  std::uint64_t row_hits = 0;  ///< those that found their row open and read before
  std::uint64_t bytes = 0;     ///< of the reads
  std::uint64_t refreshes = 0;
  std::uint64_t answers = 0;  ///< more than reads when requests for one line wait together
  std::uint64_t waited = 0;   ///< cycles from request to answer, sum over answers
  std::uint64_t queued = 0;   ///< requests in the channels, sum over cycles

  DramCounts& operator+=(const DramCounts& other);
};

/// What only a machine has.
struct MachineCounts {
  std::uint64_t cycles = 0;
  std::uint64_t memory_bytes = 0;
  std::optional<DramCounts> dram;  ///< when there is one
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
