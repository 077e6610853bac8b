// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/config.hpp"
#include "engine/counts.hpp"
#include "model/tracer.hpp"
#include "scene/mesh.hpp"
#include "scene/ray.hpp"

namespace ti {

namespace host {
class Link;
}

/// What came back for one ray.
struct Answer {
  std::uint64_t ray = 0;    ///< its number, from 0 in the order of `Engine::submit`
  HitBits hit;              ///< in the engine's number format
  bool found = false;       ///< the engine's own word for a hit
  std::uint64_t cycle = 0;  ///< the machine's cycle in which it came, as `MachineCounts` counts
};

/// Something that answers rays, for as long as it lives: caches stay warm and counters go on from
/// one wave of rays to the next.
///
/// Rays are queued by `submit` and answered in any order by `poll`. One thread at a time.
class Engine {
 public:
  virtual ~Engine() = default;

  /// Number format of the hits.
  [[nodiscard]] virtual Format format() const = 0;

  /// Queues rays behind those submitted before.
  virtual void submit(std::span<const Ray> rays) = 0;

  /// Works until `least` more rays are answered or none is left, and appends the answers. Rays that
  /// a machine has lost are left out, and counted; it is reset then, with cold caches.
  virtual void poll(std::vector<Answer>& answers, std::size_t least) = 0;

  /// Takes back the rays of the queue that the machine has not begun; how many. Those that it has
  /// begun still come.
  virtual std::size_t cancel() = 0;

  /// What was done since the engine was made. Only while no ray is left inside.
  [[nodiscard]] virtual Counts counts() = 0;
};

/// Memories behind the machine: answers after one cycle; a latency and a bandwidth; DRAM.
enum class MemoryKind { Ideal, Fixed, Dram };
/// `ideal`, `fixed`, `dram`.
[[nodiscard]] const char* name_of(MemoryKind kind);
/// The kind of that name; throws `Error` for another.
[[nodiscard]] MemoryKind memory_kind(const std::string& name);

/// Settings of the simulated machine's surroundings.
struct RtlOptions {
  MemoryKind memory = MemoryKind::Fixed;
  int memory_latency = 100;              ///< of a fixed one: cycles from a request to its answer
  double memory_bytes_per_cycle = 64.0;  ///< of all cores together
  double clock_mhz = 500.0;              ///< beside a DRAM's; `load_rtl_engine` sets it
  std::uint64_t stall_seed = 0;   ///< not 0: random stalls on every port, random initial state
  double stall_share = 0.3;       ///< share of the cycles with a stall, when there are any
  std::uint64_t error_every = 0;  ///< not 0: each n-th memory answer is an error
  std::uint64_t lose_every = 0;   ///< of a memory that is no DRAM: each n-th never comes
  std::uint64_t late_every = 0;   ///< each n-th comes four times `read_timeout` late
  std::uint64_t spoil_every = 0;  ///< each n-th has a bit that is wrong
  /// Whether rays may end with an error of the memory.
  [[nodiscard]] bool answers_fail() const {
    return error_every != 0 || lose_every != 0 || late_every != 0;
  }
  std::optional<std::uint32_t> log_ray;  ///< write the nodes that this ray visits
  std::filesystem::path log_file;        ///< to the end of this file
  /// Write every signal to this FST; empty: none. Takes a library that was built for it.
  std::filesystem::path waves_file;
  /// Called now and then with the rays answered and the cycles so far.
  std::function<void(std::uint64_t rays, std::uint64_t cycles)> progress;
};

/// The RTL of one configuration under Verilator, from the shared library that `make engine` builds.
/// Throws `Error` when `library` is none, or was built for another configuration or number format.
/// `image` must outlive the engine.
[[nodiscard]] std::unique_ptr<Engine> load_rtl_engine(const std::filesystem::path& library,
                                                      const Image& image, const Config& config,
                                                      const RtlOptions& options);

/// The way to the verilated `ti_top` of such a library, with `bytes` of memory; throws `Error` when
/// it has none.
[[nodiscard]] std::unique_ptr<host::Link> load_rtl_link(const std::filesystem::path& library,
                                                        std::size_t bytes,
                                                        const RtlOptions& options);

/// The bit-exact model, which must outlive the engine; all processors work.
[[nodiscard]] std::unique_ptr<Engine> make_model_engine(const Tracer& model, Format format);

class Truth;
/// Embree; `truth` must outlive the engine. Its hits are binary32 whatever the configuration.
[[nodiscard]] std::unique_ptr<Engine> make_embree_engine(const Truth& truth);

/// What a library of `load_rtl_engine` offers, under the name `ti_rtl_plugin`.
struct RtlPlugin {
  static constexpr int kInterface = 5;  ///< raised whenever this struct or `Engine` changes
  int interface = kInterface;
  const char* config = "";  ///< the keys that it was built for, as JSON
  Engine* (*make)(const Image& image, const RtlOptions& options) = nullptr;
  /// None in a library of the engine without registers and streams.
  host::Link* (*make_link)(std::size_t bytes, const RtlOptions& options) = nullptr;
};

}  // namespace ti
