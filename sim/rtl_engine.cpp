// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <deque>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "Vti_engine.h"
#include "base/error.hpp"
#include "counters.hpp"
#include "engine/engine.hpp"
#include "make_memory.hpp"
#include "memory.hpp"
#include "patience.hpp"
#include "ports.hpp"
#include "ti_config.hpp"
#include "verilated.h"

namespace ti {
namespace {

using sim::bit;
using sim::Memory;
using sim::set_bit;

/// Cycles in which nothing may come after the last ray.
constexpr int kSilence = 256;

/// The machine with its memory. `cycle_` counts the cycles in which rays were inside.
class RtlEngine final : public Engine {
 public:
  RtlEngine(const Image& image, const RtlOptions& options)
      : image_(image),
        options_(options),
        patience_(sim::patience(options)),
        random_(options.stall_seed) {
    constexpr int kAddrBits = config::kAddrBits;
    const std::uint64_t end = Memory::kBase + image.bytes().size();
    if (kAddrBits < 64 && end > std::uint64_t{1} << kAddrBits) {
      throw Error(fmt::format(
          "the image ends at address {}, beyond the {} bits of addr_bits: give SET=addr_bits={}",
          end, kAddrBits, std::bit_width(end - 1)));
    }
    start();
  }
  ~RtlEngine() override {
    top_->final();
    waves_.close();
  }

  [[nodiscard]] Format format() const override { return sim::kFormat; }

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
    last_event_ = cycle_;
    top_->count_run_i = 1;
    while (answers.size() < enough && inside() + queue_.size() != 0) {
      if (cycle_ - last_event_ >= patience_) {
        give_up();
        break;
      }
      cycle(answers);
    }
    if (inside() + queue_.size() == 0) settle();
    counts_.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  [[nodiscard]] Counts counts() override;

 private:
  /// Rays that have been dealt to a stream and not answered.
  [[nodiscard]] std::uint64_t inside() const { return missing_; }

  /// A machine after its reset, caches cold.
  void start() {
    waves_.close();
    top_.reset();
    context_ = std::make_unique<VerilatedContext>();
    sim::Waves<Vti_engine>::prepare(*context_);
    start_log();
    // With stalls, registers without a reset begin with random values, so that a missing one shows.
    context_->randReset(options_.stall_seed != 0 ? 2 : 0);
    context_->randSeed(static_cast<int>(options_.stall_seed & 0x7fffffffU));
    top_ = std::make_unique<Vti_engine>(context_.get());
    if (!options_.waves_file.empty()) waves_.open(*top_, options_.waves_file);
    memory_ = sim::make_memory(image_.bytes(), options_);
    sim::reset(*top_, waves_);
    sim::set_scene(*top_, image_);
    dealt_ = {};
  }

  /// One cycle. The engine's valid and ready outputs come from registers, so the inputs of a cycle
  /// may follow from its outputs.
  void cycle(std::vector<Answer>& answers) {
    Vti_engine& top = *top_;
    std::uint64_t sent = 0;  // streams whose ray moves, a bit each
    for (int s = 0; s < config::kStreams; ++s) {
      set_bit(sent, s, bit(top.ray_valid_i, s) && bit(top.ray_ready_o, s));
      if (!bit(top.hit_valid_o, s) || !bit(top.hit_ready_i, s)) continue;
      take(top, s, answers);
      last_event_ = cycle_;
    }
    if (sent != 0) last_event_ = cycle_;
    const std::uint64_t answered = take_reads(top, *memory_);
    if (answered != 0) last_event_ = cycle_;
    sim::step(top, waves_);
    memory_->tick();
    ++cycle_;

    for (int s = 0; s < config::kStreams; ++s) {
      offer(top, s, bit(sent, s));
      set_bit(top.hit_ready_i, s, !stall());
    }
    put_answers(top, *memory_, answered);
    if (cycle_ % 1024 == 0 && options_.progress) options_.progress(counts_.rays, cycle_);
  }

  /// Puts the next ray of a stream on its port, unless one waits there that was not sent. A stream
  /// takes rays in tiles, as `ti_core_deal` does, so that rays that lie together meet in one core.
  void offer(Vti_engine& top, int stream, bool sent) {
    auto& dealt = dealt_[static_cast<std::size_t>(stream)];
    if (sent) {
      dealt.pop_front();
      set_bit(top.ray_valid_i, stream, false);
    }
    if (bit(top.ray_valid_i, stream) || stall()) return;
    if (dealt.empty()) {
      for (int i = 0; i < config::kCoreTile && !queue_.empty(); ++i) {
        dealt.push_back({static_cast<std::uint32_t>(first_ + came_.size()), queue_.front()});
        queue_.pop_front();
        came_.push_back(false);
        ++missing_;
      }
    }
    if (dealt.empty()) return;
    sim::put_ray(top, stream, dealt.front().id, dealt.front().ray);
    set_bit(top.ray_valid_i, stream, true);
  }

  /// All rays are answered: counters stop, and nothing may follow.
  void settle() {
    top_->count_run_i = 0;
    counts_.duplicated += late_hits(*top_);
    first_ += came_.size();
    came_.clear();
  }

  /// The rays inside and those that wait are lost.
  void give_up() {
    before_ = snapshot();
    bytes_before_ += memory_->bytes();
    dram_before_ = dram();
    counts_.lost += missing_ + queue_.size();
    first_ += came_.size() + queue_.size();
    came_.clear();
    missing_ = 0;
    queue_.clear();
    start();
  }

  /// Tells `ti_step_log` which ray to follow; Verilator needs arguments even when there is none.
  void start_log() {
    std::vector<std::string> words{"ti"};
    if (options_.log_ray) {
      words.push_back(fmt::format("+log_ray={}", *options_.log_ray));
      words.push_back(fmt::format("+log_file={}", options_.log_file.string()));
    }
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    context_->commandArgs(static_cast<int>(arguments.size()), arguments.data());
  }

  [[nodiscard]] bool stall() {
    return options_.stall_seed != 0 &&
           static_cast<double>(random_() >> 11U) * 0x1p-53 < options_.stall_share;
  }

  /// Hits that come when every ray has.
  std::uint64_t late_hits(Vti_engine& top) {
    std::uint64_t hits = 0;
    top.ray_valid_i = 0;
    top.m_axi_rvalid = 0;
    for (int s = 0; s < config::kStreams; ++s) set_bit(top.hit_ready_i, s, true);
    for (int i = 0; i < kSilence; ++i) {
      hits +=
          static_cast<std::uint64_t>(std::popcount(static_cast<std::uint64_t>(top.hit_valid_o)));
      sim::step(top, waves_);
    }
    return hits;
  }

  /// Takes the requests that move in this cycle; the ports whose answers do, a bit each.
  static std::uint64_t take_reads(const Vti_engine& top, Memory& memory) {
    std::uint64_t answered = 0;
    for (int core = 0; core < config::kCores; ++core) {
      if (bit(top.m_axi_arvalid, core) && bit(top.m_axi_arready, core))
        memory.request(core, top.m_axi_arid[core], top.m_axi_araddr[core]);
      if (bit(top.m_axi_rvalid, core) && bit(top.m_axi_rready, core)) set_bit(answered, core, true);
    }
    return answered;
  }

  /// The inputs of the read ports in the next cycle.
  void put_answers(Vti_engine& top, Memory& memory, std::uint64_t answered) {
    for (int core = 0; core < config::kCores; ++core) {
      set_bit(top.m_axi_arready, core, memory.ready(core) && !stall());
      if (bit(answered, core)) set_bit(top.m_axi_rvalid, core, false);
      if (bit(top.m_axi_rvalid, core) || stall()) continue;
      const auto answer = memory.answer(core);
      if (!answer) continue;
      top.m_axi_rid[core] =
          static_cast<std::remove_reference_t<decltype(top.m_axi_rid[core])>>(answer->id);
      top.m_axi_rresp[core] = answer->error ? 2 : 0;
      set_bit(top.m_axi_rlast, core, true);
      memory.read(*answer, top.m_axi_rdata[core].m_storage);
      set_bit(top.m_axi_rvalid, core, true);
    }
  }

  /// Takes the hit of a stream.
  void take(const Vti_engine& top, int stream, std::vector<Answer>& answers) {
    const sim::HitBeat beat = sim::get_hit(top, stream);
    const auto place = static_cast<std::uint32_t>(beat.id - static_cast<std::uint32_t>(first_));
    if (place >= came_.size() || came_[place]) {
      ++counts_.duplicated;
      return;
    }
    came_[place] = true;
    answers.push_back({first_ + place, beat.hit, beat.found, cycle_});
    --missing_;
    ++counts_.rays;
  }

  /// The counters of the machine since its reset, added to those of machines given up before.
  [[nodiscard]] sim::Counters snapshot() {
    constexpr int kReadLatency = 2;  // cycles from an index to its value, as the engine promises
    top_->count_run_i = 0;
    sim::Counters counters([this](int core, int unit, int event) {
      top_->count_core_i = static_cast<decltype(+top_->count_core_i)>(core);
      top_->count_unit_i = static_cast<decltype(+top_->count_unit_i)>(unit);
      top_->count_event_i = static_cast<decltype(+top_->count_event_i)>(event);
      for (int i = 0; i < kReadLatency; ++i) sim::step(*top_, waves_);
      return std::uint64_t{top_->count_o};
    });
    if (before_) counters += *before_;
    return counters;
  }

  [[nodiscard]] std::optional<DramCounts> dram() const {
    std::optional<DramCounts> counts = memory_->dram();
    if (counts && dram_before_) *counts += *dram_before_;
    return counts;
  }

  const Image& image_;
  RtlOptions options_;
  std::uint64_t patience_;
  std::mt19937_64 random_;
  std::unique_ptr<VerilatedContext> context_;
  sim::Waves<Vti_engine> waves_;
  std::unique_ptr<Vti_engine> top_;
  std::unique_ptr<Memory> memory_;

  struct Dealt {
    std::uint32_t id;
    Ray ray;
  };
  std::deque<Ray> queue_;
  std::array<std::deque<Dealt>, config::kStreams> dealt_;  // the first one may be on the port
  std::uint64_t first_ = 0;                                // number of the ray of `came_[0]`
  std::vector<bool> came_;     // of the rays dealt since all were answered: whether they are
  std::uint64_t missing_ = 0;  // those of `came_` that are not
  std::uint64_t cycle_ = 0;
  std::uint64_t last_event_ = 0;
  Counts counts_;                        // but for `work` and `machine`
  std::optional<sim::Counters> before_;  // of machines that were given up
  std::uint64_t bytes_before_ = 0;
  std::optional<DramCounts> dram_before_;
};

/// Reads all counters: not while rays are inside, as the machine runs on meanwhile.
Counts RtlEngine::counts() {
  Counts counts = counts_;
  MachineCounts& machine = counts.machine.emplace();
  machine.cycles = cycle_;
  machine.memory_bytes = bytes_before_ + memory_->bytes();
  machine.dram = dram();
  snapshot().add_to(counts);
  return counts;
}

Engine* make_engine(const Image& image, const RtlOptions& options) {
  return new RtlEngine(image, options);
}

}  // namespace
}  // namespace ti

extern "C" {
[[gnu::visibility("default")]] extern const ti::RtlPlugin ti_rtl_plugin;
const ti::RtlPlugin ti_rtl_plugin{
    .interface = ti::RtlPlugin::kInterface, .config = ti::config::kJson, .make = &ti::make_engine};
}
