// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include "Vti_engine.h"
#include "engine/counts.hpp"
#include "ti_config.hpp"
#include "ti_counters.hpp"

namespace ti::sim {

/// All counters of an engine, read once: those of a kind of unit are summed over its units and
/// cores.
class Counters {
 public:
  /// Stops the counters, and reads them through the index ports; `step` runs a cycle.
  template <typename Step>
  Counters(Vti_engine& top, Step step) {
    constexpr int kReadLatency = 2;  // cycles from an index to its value, as the engine promises
    top.count_run_i = 0;
    for (const config::CountedUnit& kind : config::kCountedUnits) {
      auto& sums = sums_.emplace_back(kind.events.size(), 0);
      for (int core = 0; core < config::kCores; ++core) {
        for (int unit = kind.first; unit < kind.first + kind.count; ++unit) {
          for (std::size_t event = 0; event < kind.events.size(); ++event) {
            top.count_core_i = static_cast<decltype(+top.count_core_i)>(core);
            top.count_unit_i = static_cast<decltype(+top.count_unit_i)>(unit);
            top.count_event_i = static_cast<decltype(+top.count_event_i)>(event);
            for (int i = 0; i < kReadLatency; ++i) step();
            sums[event] += top.count_o;
          }
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

  Counters& operator+=(const Counters& other) {
    for (std::size_t k = 0; k < sums_.size(); ++k)
      for (std::size_t e = 0; e < sums_[k].size(); ++e) sums_[k][e] += other.sums_[k][e];
    return *this;
  }

 private:
  std::vector<std::vector<std::uint64_t>> sums_;
};

}  // namespace ti::sim
