// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "accel/image.hpp"
#include "base/config.hpp"
#include "model/tracer.hpp"
#include "scene/ray.hpp"

namespace ti {

/// What the caches of one kind of unit did.
struct CacheCounters {
  std::string name;
  std::uint64_t accesses = 0, hits = 0, merged = 0, misses = 0;
};

/// What the units of one kind did: cycles by activity, summed over units and cores. The activities
/// of a unit add up to the cycles.
struct UnitAccount {
  std::string unit;
  std::uint64_t unit_cycles = 0;  ///< cycles times units
  std::vector<std::pair<std::string, std::uint64_t>> activities;
};

/// What only the RTL can tell.
struct RtlCounters {
  std::uint64_t cycles = 0;
  std::uint64_t dram_bytes = 0;
  double seconds = 0.0;  ///< of the host, simulation and lock-step comparison together
  double trv_busy = 0.0, list_busy = 0.0, ist1_busy = 0.0,
         ist2_busy = 0.0;  ///< share of the cycles, mean over units
  std::vector<CacheCounters> caches;
  std::vector<UnitAccount> accounts;  ///< in the order of the pipeline; empty without counters
};

/// Comparison with the model, ray by ray.
struct LockStep {
  bool on = false;
  std::uint64_t mismatches = 0;       ///< hits, status or step counts that differ
  bool work_differs = false;          ///< the sums over all rays differ
  std::vector<std::string> examples;  ///< up to 4, what differs in which ray
};

struct EngineResult {
  std::vector<HitBits> hits;  ///< in the order of the rays
  Work work;
  std::uint64_t lost = 0, duplicated = 0;
  LockStep lock_step;
  std::optional<RtlCounters> rtl;
};

/// Settings of the simulated machine's surroundings.
struct RtlOptions {
  int memory_latency = 100;              ///< cycles from a request to its answer
  double memory_bytes_per_cycle = 64.0;  ///< of all cores together
  std::uint64_t stall_seed = 0;   ///< not 0: random stalls on every port, random initial state
  double stall_share = 0.3;       ///< share of the cycles with a stall, when there are any
  std::uint64_t error_every = 0;  ///< not 0: each n-th memory answer is an error
  bool lock_step = true;
  bool progress = true;
  std::optional<std::uint32_t> log_ray;  ///< write the nodes that this ray visits
  std::filesystem::path log_file;        ///< to this file
};

/// Something that answers rays.
class Engine {
 public:
  virtual ~Engine() = default;
  [[nodiscard]] virtual EngineResult trace(std::span<const Ray> rays) = 0;
};

/// The RTL under Verilator, for the configuration that this program was built for. Throws `Error`
/// when `config` is another one or when the program was built without the RTL. `image` and `model`
/// must outlive it.
[[nodiscard]] std::unique_ptr<Engine> make_rtl_engine(const Image& image, const Config& config,
                                                      const Tracer& model,
                                                      const RtlOptions& options);

/// The bit-exact model alone.
[[nodiscard]] std::unique_ptr<Engine> make_model_engine(const Tracer& model);

}  // namespace ti
