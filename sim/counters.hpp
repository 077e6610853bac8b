// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "engine/counts.hpp"
#include "ti_config.hpp"
#include "ti_counters.hpp"

namespace ti::sim {

/// All counters of an engine, read once: those of a kind of unit are summed over its units and
/// cores.
class Counters {
 public:
  /// `read` gives a counter by core, unit and event.
  template <typename Read>
  explicit Counters(Read read) {
    for (const config::CountedUnit& kind : config::kCountedUnits) {
      auto& sums = sums_.emplace_back(kind.events.size(), 0);
      for (int core = 0; core < config::kCores; ++core) {
        for (int unit = kind.first; unit < kind.first + kind.count; ++unit) {
          for (std::size_t event = 0; event < kind.events.size(); ++event)
            sums[event] += read(core, unit, static_cast<int>(event));
        }
      }
    }
  }

  [[nodiscard]] std::uint64_t sum(std::string_view unit, std::string_view event) const {
    for (std::size_t k = 0; k < sums_.size(); ++k) {
      const config::CountedUnit& kind = config::kCountedUnits[k];
      for (std::size_t e = 0; unit == kind.name && e < kind.events.size(); ++e)
        if (event == kind.events[e]) return sums_[k][e];
    }
    return 0;
  }

  /// How many units of a kind a core has.
  [[nodiscard]] static int units(std::string_view unit) {
    for (const config::CountedUnit& kind : config::kCountedUnits)
      if (unit == kind.name) return kind.count;
    return 0;
  }

  /// Cycles by activity of each kind of unit that there is; without counters, only how many there
  /// are.
  [[nodiscard]] std::vector<UnitCounts> units() const {
    std::vector<UnitCounts> units;
    for (std::size_t k = 0; k < sums_.size(); ++k) {
      const config::CountedUnit& kind = config::kCountedUnits[k];
      if (kind.count == 0) continue;
      UnitCounts unit{kind.name, static_cast<std::uint64_t>(kind.count) * config::kCores, {}};
      for (std::size_t e = 0; config::kCounters != 0 && e < config::kActivities; ++e)
        unit.activities.emplace_back(kind.events[e], sums_[k][e]);
      units.push_back(unit);
    }
    return units;
  }

  /// Work, caches and activities of `counts`, which has its machine.
  void add_to(Counts& counts) const {
    Work& work = counts.work;
    work.steps = sum("trv", "steps");
    work.leaves = sum("trv", "leaves");
    work.full_leaves = sum("trv", "full_leaves");
    work.restarts = sum("trv", "restarts") + sum("trv", "restarts_after_tests");
    work.a_tests = sum("ist1", "a_passes");
    work.b_tests = sum("ist1", "b_passes");
    work.c_tests = sum("ist2", "c_passes");
    MachineCounts& machine = *counts.machine;
    for (const char* unit : {"trv", "list", "ist1"}) {
      machine.caches.push_back({std::string(unit) + "_l1", sum(unit, "l1_accesses"),
                                sum(unit, "l1_hits"), sum(unit, "l1_merged"),
                                sum(unit, "l1_misses")});
    }
    for (const char* unit : {"trv_l2", "list_l2", "ist1_l2"}) {
      if (units(unit) == 0) continue;
      machine.caches.push_back({unit, sum(unit, "accesses"), sum(unit, "hits"), sum(unit, "merged"),
                                sum(unit, "misses")});
    }
    machine.units = units();
  }

  Counters& operator+=(const Counters& other) {
    for (std::size_t k = 0; k < sums_.size(); ++k)
      for (std::size_t e = 0; e < sums_[k].size(); ++e) sums_[k][e] += other.sums_[k][e];
    return *this;
  }

 private:
  std::vector<std::vector<std::uint64_t>> sums_;
};

}  // namespace ti::sim
