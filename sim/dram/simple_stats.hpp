// SPDX-License-Identifier: Apache-2.0
//
// Stands for DRAMsim3's header `simple_stats.h`, whose guard it takes: the counters that reports
// show, in place of tables of words that are written into files. Included before every source of
// DRAMsim3 by dram.mk.
#ifndef __SIMPLE_STATS_
#define __SIMPLE_STATS_

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "configuration.h"
#include "engine/counts.hpp"

namespace dramsim3 {

/// A configuration with what its channels count, together.
struct CountedConfig : Config {
  using Config::Config;
  mutable ti::DramCounts counts;
};

/// Of one channel. Its configuration must be a `CountedConfig`.
class SimpleStats {
 public:
  SimpleStats(const Config& config, int /*channel*/)
      : counts_(static_cast<const CountedConfig&>(config).counts) {}

  void Increment(std::string_view name) {
    if (name == "num_read_cmds") ++counts_.reads;
    if (name == "num_read_row_hits") ++counts_.row_hits;
    if (name == "num_ref_cmds") ++counts_.refreshes;
  }
  void IncrementVec(std::string_view /*name*/, int /*place*/) {}
  void AddValue(std::string_view /*name*/, int /*value*/) {}
  void PrintEpochStats() {}
  void PrintFinalStats() {}
  void Reset() {}

 private:
  ti::DramCounts& counts_;
};

}  // namespace dramsim3
#endif
