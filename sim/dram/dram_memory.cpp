// SPDX-License-Identifier: Apache-2.0
#include "dram/dram_memory.hpp"

#include <fmt/core.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "controller.h"
#include "timing.h"

namespace ti::sim {
namespace {

constexpr const char* kText =
#include "gddr3.inc"
    ;

/// The configuration for lines of this size. DRAMsim3 reads files, so this makes one in memory.
std::unique_ptr<dramsim3::CountedConfig> configure(int line_bytes) {
  constexpr int kBeatBytes = 8;
  const std::string burst = "\nBL = ";
  std::string text = kText;
  const std::size_t at = text.find(burst) + burst.size();
  text.replace(at, text.find('\n', at) - at, std::to_string(line_bytes / kBeatBytes));

  const int file = memfd_create("gddr3.ini", 0);
  if (file < 0 || write(file, text.data(), text.size()) != static_cast<ssize_t>(text.size()))
    throw Error("MEM=dram: no file can be made in memory for DRAMsim3; give MEM=fixed");
  // The folder is that of outputs, of which there are none, and has to exist.
  auto config =
      std::make_unique<dramsim3::CountedConfig>(fmt::format("/proc/self/fd/{}", file), "/");
  close(file);
  return config;
}

class DramMemory final : public Memory {
 public:
  DramMemory(std::span<const std::uint8_t> image, const DramSettings& settings)
      : Memory(image, settings.line_bytes, DramCounts::kMhz / settings.clock_mhz),
        settings_(settings),
        config_(configure(settings.line_bytes)),
        timing_(*config_),
        ports_(static_cast<std::size_t>(settings.ports)),
        channels_(static_cast<std::size_t>(config_->channels)),
        random_(settings.shuffle_seed) {
    for (int i = 0; i < config_->channels; ++i) {
      channels_[static_cast<std::size_t>(i)].controller =
          std::make_unique<dramsim3::Controller>(i, *config_, timing_);
    }
  }

  [[nodiscard]] bool ready(int port) const override {
    return ports_[static_cast<std::size_t>(port)].requests.size() < kPortQueue;
  }

  void request(int port, std::uint32_t id, std::uint64_t address) override {
    const std::uint64_t number = count_line();
    const bool spoilt = settings_.error_every != 0 && number % settings_.error_every == 0;
    ports_[static_cast<std::size_t>(port)].requests.push_back(
        {port, now_, {id, address, spoilt || !inside(address)}});
  }

  [[nodiscard]] std::optional<Answer> answer(int port) override {
    auto& answers = ports_[static_cast<std::size_t>(port)].answers;
    if (answers.empty()) return std::nullopt;
    constexpr std::size_t kNear = 8;
    const std::size_t pick =
        settings_.shuffle_seed != 0 ? random_() % std::min(answers.size(), kNear) : 0;
    const Answer answer = answers[pick];
    answers.erase(answers.begin() + static_cast<std::ptrdiff_t>(pick));
    return answer;
  }

  [[nodiscard]] std::optional<DramCounts> dram() const override {
    DramCounts counts = config_->counts;
    counts.bytes = counts.reads * static_cast<std::uint64_t>(line_bytes());
    return counts;
  }

 private:
  struct Request {
    int port;
    std::uint64_t since;  // in cycles of the memory
    Answer answer;        // that it will get
  };
  struct Port {
    std::deque<Request> requests;
    std::deque<Answer> answers;
  };
  struct Channel {
    std::unique_ptr<dramsim3::Controller> controller;
    std::vector<Request> inside;  // in their order
  };

  /// DRAMsim3 knows requests by their address alone.
  [[nodiscard]] std::uint64_t line_of(std::uint64_t address) const {
    return address / static_cast<std::uint64_t>(line_bytes()) *
           static_cast<std::uint64_t>(line_bytes());
  }

  void cycle() override {
    DramCounts& counts = config_->counts;
    take_requests();
    for (Channel& channel : channels_) {
      counts.queued += channel.inside.size();
      while (!channel.inside.empty()) {
        const auto [address, kind] = channel.controller->ReturnDoneTrans(now_);
        if (kind < 0) break;
        finish(channel, address);
      }
      channel.controller->ClockTick();
    }
    ++now_;
    ++counts.cycles;
  }

  /// The first request of each port goes on if it can, the oldest before others.
  void take_requests() {
    waiting_.clear();
    for (Port& port : ports_) {
      if (!port.requests.empty()) waiting_.push_back(&port);
    }
    std::sort(waiting_.begin(), waiting_.end(), [](const Port* a, const Port* b) {
      return std::pair(a->requests.front().since, a) < std::pair(b->requests.front().since, b);
    });
    for (Port* waiting : waiting_) {
      Port& port = *waiting;
      const Request& request = port.requests.front();
      if (!inside(request.answer.address)) {
        port.answers.push_back(request.answer);
      } else {
        const std::uint64_t line = line_of(request.answer.address);
        Channel& channel =
            channels_[static_cast<std::size_t>(config_->AddressMapping(line).channel)];
        if (!channel.controller->WillAcceptTransaction(line, false)) continue;
        channel.controller->AddTransaction(dramsim3::Transaction(line, false));
        channel.inside.push_back(request);
      }
      port.requests.pop_front();
    }
  }

  /// A line has come: for the request that has waited longest for it.
  void finish(Channel& channel, std::uint64_t line) {
    const auto found = std::find_if(
        channel.inside.begin(), channel.inside.end(),
        [&](const Request& request) { return line_of(request.answer.address) == line; });
    if (found == channel.inside.end()) std::abort();
    ++config_->counts.answers;
    config_->counts.waited += now_ - found->since;
    ports_[static_cast<std::size_t>(found->port)].answers.push_back(found->answer);
    channel.inside.erase(found);
  }

  DramSettings settings_;
  std::unique_ptr<dramsim3::CountedConfig> config_;
  dramsim3::Timing timing_;
  std::vector<Port> ports_;
  std::vector<Port*> waiting_;  // scratch of `take_requests`
  std::vector<Channel> channels_;
  std::mt19937_64 random_;
  std::uint64_t now_ = 0;
};

}  // namespace

std::unique_ptr<Memory> make_dram_memory(std::span<const std::uint8_t> image,
                                         const DramSettings& settings) {
  return std::make_unique<DramMemory>(image, settings);
}

}  // namespace ti::sim
