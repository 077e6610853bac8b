// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "base/error.hpp"
#include "counters.hpp"
#include "engine/engine.hpp"
#include "host/host_engine.hpp"
#include "ti_config.hpp"
#include "top/top_link.hpp"

namespace ti {
namespace {

using sim::TopLink;

/// The verilated `ti_top` by its driver, with what only a simulation knows of it.
class TopEngine final : public host::HostEngine {
 public:
  TopEngine(const Image& image, const RtlOptions& options)
      : TopEngine(new TopLink(image.bytes().size(), options), image, options) {}

  [[nodiscard]] Counts counts() override {
    Counts counts = HostEngine::counts();
    MachineCounts& machine = counts.machine.emplace();
    machine.memory_bytes = link_.memory().bytes();
    machine.dram = link_.memory().dram();
    if (device().machine().snapshot) device().snapshot();
    const sim::Counters counters([this](int core, int unit, int event) {
      return device().machine().counters ? device().counter(core, unit, event) : 0;
    });
    counters.add_to(counts);
    // The account of a unit adds up to the cycles that were counted.
    machine.cycles = link_.cycles();
    if (device().machine().counters) {
      machine.cycles = 0;
      for (const auto& [activity, cycles] : machine.units.front().activities)
        machine.cycles += cycles;
      machine.cycles /= machine.units.front().units;
    }
    return counts;
  }

 private:
  TopEngine(TopLink* link, const Image& image, const RtlOptions& options)
      : HostEngine(std::unique_ptr<host::Link>(link), image, options.progress), link_(*link) {}

  [[nodiscard]] std::uint64_t cycle() const override { return link_.cycles(); }

  TopLink& link_;  // the one that `HostEngine` holds
};

Engine* make_engine(const Image& image, const RtlOptions& options) {
  if (options.log_ray)
    throw Error("LOG_RAY=: rays have other numbers behind streams; give ENGINE=rtl");
  return new TopEngine(image, options);
}

host::Link* make_link(std::size_t bytes, const RtlOptions& options) {
  return new TopLink(bytes, options);
}

}  // namespace
}  // namespace ti

extern "C" {
[[gnu::visibility("default")]] extern const ti::RtlPlugin ti_rtl_plugin;
const ti::RtlPlugin ti_rtl_plugin{.interface = ti::RtlPlugin::kInterface,
                                  .config = ti::config::kJson,
                                  .make = &ti::make_engine,
                                  .make_link = &ti::make_link};
}
