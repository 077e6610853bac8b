// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <deque>
#include <memory>
#include <vector>

#include "base/error.hpp"
#include "counters.hpp"
#include "engine/engine.hpp"
#include "host/device.hpp"
#include "ti_config.hpp"
#include "top/top_link.hpp"

namespace ti {
namespace {

using sim::Memory;
using sim::TopLink;

/// The verilated `ti_top` by its driver: packets of rays in, hits out. Rays of a packet are of one
/// kind; counters count while a packet is on its way.
class TopEngine final : public Engine {
 public:
  TopEngine(const Image& image, const RtlOptions& options)
      : progress_(options.progress),
        format_(image.format()),
        link_(image.bytes().size(), options),
        device_(link_) {
    device_.load(image, Memory::kBase);
  }

  [[nodiscard]] Format format() const override { return format_; }

  void submit(std::span<const Ray> rays) override {
    queue_.insert(queue_.end(), rays.begin(), rays.end());
  }

  std::size_t cancel() override {
    const std::size_t n = queue_.size();
    queue_.clear();
    return n;
  }

  void poll(std::vector<Answer>& answers, std::size_t least) override {
    const auto begin = std::chrono::steady_clock::now();
    const std::size_t enough = answers.size() + std::max<std::size_t>(least, 1);
    while (answers.size() < enough && !queue_.empty()) {
      const bool any = queue_.front().any;
      const auto end = std::find_if(queue_.begin(), queue_.begin() + packet_end(),
                                    [any](const Ray& ray) { return ray.any != any; });
      const std::vector<Ray> rays(queue_.begin(), end);
      queue_.erase(queue_.begin(), end);
      for (const HitBits& hit : device_.trace(rays))
        answers.push_back({counts_.rays++, hit, hit.prim >= 0, link_.cycles()});
      if (progress_) progress_(counts_.rays, link_.cycles());
    }
    counts_.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  [[nodiscard]] Counts counts() override {
    Counts counts = counts_;
    MachineCounts& machine = counts.machine.emplace();
    machine.memory_bytes = link_.memory().bytes();
    machine.dram = link_.memory().dram();
    if (device_.machine().snapshot) device_.snapshot();
    const sim::Counters counters([this](int core, int unit, int event) {
      return device_.machine().counters ? device_.counter(core, unit, event) : 0;
    });
    counters.add_to(counts);
    // The account of a unit adds up to the cycles that were counted.
    machine.cycles = link_.cycles();
    if (device_.machine().counters) {
      machine.cycles = 0;
      for (const auto& [activity, cycles] : machine.units.front().activities)
        machine.cycles += cycles;
      machine.cycles /= machine.units.front().units;
    }
    return counts;
  }

 private:
  /// Rays of the queue that a packet may have: enough that draining it costs little.
  [[nodiscard]] std::ptrdiff_t packet_end() const {
    constexpr std::size_t kMost = 65'536;
    return static_cast<std::ptrdiff_t>(std::min(queue_.size(), kMost));
  }

  std::function<void(std::uint64_t, std::uint64_t)> progress_;
  Format format_;
  TopLink link_;
  host::Device device_;
  std::deque<Ray> queue_;
  Counts counts_;  // but for `work` and `machine`
};

Engine* make_engine(const Image& image, const RtlOptions& options) {
  if (options.log_ray)
    throw Error("LOG_RAY=: rays have other numbers behind streams; give ENGINE=rtl");
  return new TopEngine(image, options);
}

}  // namespace
}  // namespace ti

extern "C" {
[[gnu::visibility("default")]] extern const ti::RtlPlugin ti_rtl_plugin;
const ti::RtlPlugin ti_rtl_plugin{
    .interface = ti::RtlPlugin::kInterface, .config = ti::config::kJson, .make = &ti::make_engine};
}
