// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "Vti_engine.h"
#include "base/error.hpp"
#include "bits.hpp"
#include "counters.hpp"
#include "engine/engine.hpp"
#include "fixed_memory.hpp"
#include "io/file.hpp"
#include "progress.hpp"
#include "ti_config.hpp"
#include "verilated.h"

namespace ti {
namespace {

using sim::FixedMemory;
using sim::Memory;
using sim::Packer;
using sim::Unpacker;

constexpr int kFpWidth = 1 + config::kExpBits + config::kFracBits;
constexpr Format kFormat{config::kExpBits, config::kFracBits};

/// Cycles without a ray in or out after which the rays inside count as lost.
constexpr std::uint64_t kPatience = 2'000'000;

/// Cycles in which nothing may come after the last ray.
constexpr int kSilence = 256;

/// Bit `core` of a port that has one bit a core.
template <typename Port>
[[nodiscard]] bool bit(const Port& port, int top) {
  return ((port >> top) & 1U) != 0;
}
template <typename Port>
void set_bit(Port& port, int top, bool value) {
  const auto mask = static_cast<Port>(Port{1} << top);
  port = static_cast<Port>(value ? port | mask : port & ~mask);
}

class RtlEngine final : public Engine {
 public:
  RtlEngine(const Image& image, const Tracer& model, const RtlOptions& options)
      : image_(image), model_(model), options_(options) {}

  [[nodiscard]] EngineResult trace(std::span<const Ray> rays) override {
    VerilatedContext context;
    start_log(context);
    // With stalls, registers without a reset begin with random values, so that a missing one shows.
    context.randReset(options_.stall_seed != 0 ? 2 : 0);
    context.randSeed(static_cast<int>(options_.stall_seed & 0x7fffffffU));
    Vti_engine top(&context);
    std::mt19937_64 random(options_.stall_seed);
    FixedMemory memory(image_.bytes(), {.ports = config::kCores,
                                        .latency = options_.memory_latency,
                                        .bytes_per_cycle = options_.memory_bytes_per_cycle,
                                        .line_bytes = config::kLineBytes,
                                        .error_every = options_.error_every,
                                        .shuffle_seed = options_.stall_seed});
    reset(top);
    set_scene(top);
    top.count_run_i = 1;

    EngineResult result;
    result.hits.resize(rays.size());
    result.lock_step.on = options_.lock_step;
    std::vector<std::uint8_t> answers(rays.size(), 0);
    Work model_work;
    sim::Progress progress(rays.size(), options_.progress);
    std::uint64_t cycle = 0;
    std::uint64_t last_event = 0;
    std::size_t sent = 0;
    std::size_t came = 0;
    bool ray_up = false;

    // The engine's valid and ready outputs come from registers, so the inputs of a cycle may follow
    // from its outputs.
    while (came < rays.size() && cycle - last_event < kPatience) {
      if (top.ray_valid_i && top.ray_ready_o) {
        ++sent;
        ray_up = false;
        last_event = cycle;
      }
      if (top.hit_valid_o && top.hit_ready_i) {
        take(top, rays, answers, result, model_work);
        ++came;
        last_event = cycle;
      }
      const std::uint64_t answered = take_reads(top, memory);
      step(top);
      memory.tick();
      ++cycle;

      if (!ray_up && sent < rays.size() && !stall(random)) {
        put_ray(top, static_cast<std::uint32_t>(sent), rays[sent]);
        ray_up = true;
      }
      top.ray_valid_i = ray_up;
      top.hit_ready_i = !stall(random);
      put_answers(top, memory, answered, random);
      if (cycle % 1024 == 0) progress.update(came, cycle);
    }
    progress.finish(came, cycle);
    if (came == rays.size()) result.duplicated += late_hits(top);

    for (std::uint8_t count : answers) result.lost += count == 0 ? 1 : 0;
    read_counters(top, cycle, memory.bytes(), progress.seconds(), result);
    if (options_.lock_step && options_.error_every == 0 && config::kCounters != 0 &&
        !(result.work == model_work)) {
      result.lock_step.work_differs = true;
      result.lock_step.examples.push_back(
          fmt::format("RTL {}; model {}", text_of(result.work), text_of(model_work)));
    }
    top.final();
    return result;
  }

 private:
  /// Tells `ti_step_log` which ray to follow; Verilator needs arguments even when there is none.
  void start_log(VerilatedContext& context) const {
    std::vector<std::string> words{"ti"};
    if (options_.log_ray) {
      write_file(options_.log_file, "");
      words.push_back(fmt::format("+log_ray={}", *options_.log_ray));
      words.push_back(fmt::format("+log_file={}", options_.log_file.string()));
    }
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    context.commandArgs(static_cast<int>(arguments.size()), arguments.data());
  }

  static void step(Vti_engine& top) {
    top.clk_i = 0;
    top.eval();
    top.clk_i = 1;
    top.eval();
  }

  static void reset(Vti_engine& top) {
    top.flush_i = 0;
    top.ray_valid_i = 0;
    top.hit_ready_i = 0;
    top.m_axi_arready = 0;
    top.m_axi_rvalid = 0;
    top.count_run_i = 0;
    top.rst_ni = 0;
    for (int i = 0; i < 4; ++i) step(top);
    top.rst_ni = 1;
    step(top);
  }

  [[nodiscard]] bool stall(std::mt19937_64& random) const {
    return options_.stall_seed != 0 &&
           static_cast<double>(random() >> 11U) * 0x1p-53 < options_.stall_share;
  }

  void set_scene(Vti_engine& top) const {
    const ImageHeader& header = image_.header();
    const ImageParts& parts = image_.parts();
    std::fill(std::begin(top.scene_i.m_storage), std::end(top.scene_i.m_storage), 0U);
    Packer scene(top.scene_i.m_storage);
    for (const auto& corner : {header.box_hi, header.box_lo}) {
      for (std::uint32_t bits : corner) scene.put(bits, kFpWidth);
    }
    for (std::uint32_t offset :
         {parts.bary_offset, parts.plane_offset, parts.list_offset, parts.node_offset}) {
      scene.put(Memory::kBase + offset, config::kAddrBits);
    }
    scene.put(parts.triangle_count, 29);
    scene.put(parts.list_count, 32);
    scene.put(header.root, 29);
  }

  static void put_ray(Vti_engine& top, std::uint32_t id, const Ray& ray) {
    std::fill(std::begin(top.ray_data_i.m_storage), std::end(top.ray_data_i.m_storage), 0U);
    Packer packer(top.ray_data_i.m_storage);
    const auto put = [&packer](float value) {
      packer.put(round_to_bits(kFormat, value), kFpWidth);
    };
    put(ray.tmax);
    put(ray.tmin);
    for (int axis = 0; axis < 3; ++axis) put(ray.d[axis]);
    for (int axis = 0; axis < 3; ++axis) put(ray.o[axis]);
    packer.put(ray.any ? 1 : 0, 1);
    packer.put(id, 32);
  }

  /// Hits that come when every ray has.
  static std::uint64_t late_hits(Vti_engine& top) {
    std::uint64_t hits = 0;
    top.ray_valid_i = 0;
    top.m_axi_rvalid = 0;
    top.hit_ready_i = 1;
    for (int i = 0; i < kSilence; ++i) {
      if (top.hit_valid_o) ++hits;
      step(top);
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
  void put_answers(Vti_engine& top, Memory& memory, std::uint64_t answered,
                   std::mt19937_64& random) const {
    for (int core = 0; core < config::kCores; ++core) {
      set_bit(top.m_axi_arready, core, memory.ready(core) && !stall(random));
      if (bit(answered, core)) set_bit(top.m_axi_rvalid, core, false);
      if (bit(top.m_axi_rvalid, core) || stall(random)) continue;
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

  void take(const Vti_engine& top, std::span<const Ray> rays, std::vector<std::uint8_t>& answers,
            EngineResult& result, Work& model_work) const {
    Unpacker fields(top.hit_data_o.m_storage);
    HitBits hit;
    hit.steps = static_cast<std::uint16_t>(fields.get(16));
    hit.v = static_cast<std::uint32_t>(fields.get(kFpWidth));
    hit.u = static_cast<std::uint32_t>(fields.get(kFpWidth));
    hit.t = static_cast<std::uint32_t>(fields.get(kFpWidth));
    hit.prim = static_cast<std::int32_t>(fields.get(32));
    const bool is_hit = fields.get(1) != 0;
    hit.status = static_cast<Status>(fields.get(2));
    const auto id = static_cast<std::uint32_t>(fields.get(32));

    if (id >= rays.size() || answers[id] != 0) {
      ++result.duplicated;
      return;
    }
    answers[id] = 1;
    result.hits[id] = hit;
    if (!options_.lock_step) return;
    const HitBits expected = model_.trace(rays[id], model_work);
    const bool excused = options_.error_every != 0 && hit.status == Status::MemoryError && !is_hit;
    if (!excused && (!(hit == expected) || is_hit != (expected.prim >= 0))) {
      ++result.lock_step.mismatches;
      if (result.lock_step.examples.size() < 4)
        result.lock_step.examples.push_back(difference(id, hit, expected));
    }
  }

  static std::string text_of(const Work& work) {
    return fmt::format("steps {} leaves {} ({} full) restarts {} tests {} / {} / {}", work.steps,
                       work.leaves, work.full_leaves, work.restarts, work.a_tests, work.b_tests,
                       work.c_tests);
  }

  static std::string difference(std::uint32_t id, const HitBits& got, const HitBits& expected) {
    const auto text = [](const HitBits& hit) {
      return fmt::format("prim {} t {:08x} u {:08x} v {:08x} status {} steps {}", hit.prim, hit.t,
                         hit.u, hit.v, static_cast<int>(hit.status), hit.steps);
    };
    return fmt::format("ray {}: RTL {}; model {}", id, text(got), text(expected));
  }

  /// Stops the counters and reads them all.
  static void read_counters(Vti_engine& top, std::uint64_t cycles, std::uint64_t bytes,
                            double seconds, EngineResult& result) {
    const sim::Counters counts(top, [&top] { step(top); });
    Work& work = result.work;
    work.steps = counts.sum("trv", "steps");
    work.leaves = counts.sum("trv", "leaves");
    work.full_leaves = counts.sum("trv", "full_leaves");
    work.restarts = counts.sum("trv", "restarts") + counts.sum("trv", "restarts_after_tests");
    work.a_tests = counts.sum("ist1", "a_passes");
    work.b_tests = counts.sum("ist1", "b_passes");
    work.c_tests = counts.sum("ist2", "c_passes");

    const auto share = [cycles](std::uint64_t busy, int units) {
      return cycles == 0 ? 0.0
                         : static_cast<double>(busy) /
                               (static_cast<double>(cycles) * config::kCores * units);
    };
    RtlCounters counters;
    counters.cycles = cycles;
    counters.dram_bytes = bytes;
    counters.seconds = seconds;
    counters.trv_busy = share(work.steps, config::kNumTrv);
    counters.list_busy = share(counts.sum("list", "ids"), config::kNumList);
    counters.ist1_busy = share(work.a_tests + work.b_tests, config::kNumIst1);
    counters.ist2_busy = share(work.c_tests, 1);
    for (const char* unit : {"trv", "list", "ist1"}) {
      counters.caches.push_back({fmt::format("{}_l1", unit), counts.sum(unit, "l1_accesses"),
                                 counts.sum(unit, "l1_hits"), counts.sum(unit, "l1_merged"),
                                 counts.sum(unit, "l1_misses")});
    }
    if (config::kCounters != 0) counters.accounts = counts.accounts(cycles);
    result.rtl = counters;
  }

  const Image& image_;
  const Tracer& model_;
  RtlOptions options_;
};

}  // namespace

std::unique_ptr<Engine> make_rtl_engine(const Image& image, const Config& config,
                                        const Tracer& model, const RtlOptions& options) {
  if (config.name != config::kName || config.num_trv != config::kNumTrv ||
      !(config.format == kFormat)) {
    throw Error(
        fmt::format("this program was built for the configuration {}, not for {}: start it by "
                    "`make render CONFIG={}`",
                    config::kName, config.name, config.name));
  }
  if (!(image.format() == kFormat)) {
    throw Error(fmt::format(
        "the image has the number format ({},{}), the RTL ({},{}): build the image again",
        image.format().exp_bits, image.format().frac_bits, kFormat.exp_bits, kFormat.frac_bits));
  }
  return std::make_unique<RtlEngine>(image, model, options);
}

}  // namespace ti
