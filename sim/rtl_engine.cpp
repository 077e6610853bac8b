// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "Vti_core.h"
#include "app/engine.hpp"
#include "bits.hpp"
#include "common/error.hpp"
#include "io/file.hpp"
#include "memory.hpp"
#include "progress.hpp"
#include "ti_config.hpp"
#include "verilated.h"

namespace ti {
namespace {

using sim::Memory;
using sim::Packer;
using sim::Unpacker;

constexpr int kFpWidth = 1 + config::kExpBits + config::kFracBits;
constexpr int kCounterWidth = 48;
constexpr Format kFormat{config::kExpBits, config::kFracBits};

/// Cycles without a ray in or out after which the rays inside count as lost.
constexpr std::uint64_t kPatience = 2'000'000;

/// Cycles in which nothing may come after the last ray.
constexpr int kSilence = 256;

struct CacheSum {
  std::uint64_t accesses = 0, hits = 0, merged = 0, misses = 0;

  void add(Unpacker& from) {
    misses += from.get(kCounterWidth);
    merged += from.get(kCounterWidth);
    hits += from.get(kCounterWidth);
    accesses += from.get(kCounterWidth);
  }
  [[nodiscard]] CacheCounters named(const std::string& name) const {
    return {name, accesses, hits, merged, misses};
  }
};

class RtlEngine final : public Engine {
 public:
  RtlEngine(const Image& image, const Tracer& model, const RtlOptions& options)
      : image_(image), model_(model), options_(options) {}

  [[nodiscard]] EngineResult trace(std::span<const Ray> rays) override {
    VerilatedContext context;
    start_log(context);
    Vti_core core(&context);
    std::mt19937_64 random(options_.stall_seed);
    Memory memory(image_.bytes(), {.latency = options_.memory_latency,
                                   .bytes_per_cycle = options_.memory_bytes_per_cycle,
                                   .line_bytes = config::kLineBytes,
                                   .error_every = options_.error_every,
                                   .shuffle = options_.stall_seed != 0});
    reset(core);
    set_scene(core);

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
    bool answer_up = false;

    // The engine's valid and ready outputs come from registers, so the inputs of a cycle may follow
    // from its outputs.
    while (came < rays.size() && cycle - last_event < kPatience) {
      if (core.ray_valid_i && core.ray_ready_o) {
        ++sent;
        ray_up = false;
        last_event = cycle;
      }
      if (core.hit_valid_o && core.hit_ready_i) {
        take(core, rays, answers, result, model_work);
        ++came;
        last_event = cycle;
      }
      if (core.m_axi_arvalid && core.m_axi_arready)
        memory.request(cycle, core.m_axi_arid, core.m_axi_araddr);
      if (core.m_axi_rvalid && core.m_axi_rready) answer_up = false;
      step(core);
      ++cycle;

      if (!ray_up && sent < rays.size() && !stall(random)) {
        put_ray(core, static_cast<std::uint32_t>(sent), rays[sent]);
        ray_up = true;
      }
      core.ray_valid_i = ray_up;
      core.hit_ready_i = !stall(random);
      core.m_axi_arready = !stall(random);
      if (!answer_up && !stall(random)) answer_up = put_answer(core, memory, cycle, random);
      core.m_axi_rvalid = answer_up;
      if (cycle % 1024 == 0) progress.update(came, cycle);
    }
    progress.finish(came, cycle);
    if (came == rays.size()) result.duplicated += late_hits(core);

    for (std::uint8_t count : answers) result.lost += count == 0 ? 1 : 0;
    read_counters(core, cycle, memory.bytes(), progress.seconds(), result);
    if (options_.lock_step && options_.error_every == 0 && !(result.work == model_work)) {
      result.lock_step.work_differs = true;
      result.lock_step.examples.push_back(
          fmt::format("RTL {}; model {}", text_of(result.work), text_of(model_work)));
    }
    core.final();
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

  static void step(Vti_core& core) {
    core.clk_i = 0;
    core.eval();
    core.clk_i = 1;
    core.eval();
  }

  static void reset(Vti_core& core) {
    core.rst_ni = 0;
    for (int i = 0; i < 4; ++i) step(core);
    core.rst_ni = 1;
    step(core);
  }

  [[nodiscard]] bool stall(std::mt19937_64& random) const {
    return options_.stall_seed != 0 &&
           static_cast<double>(random() >> 11U) * 0x1p-53 < options_.stall_share;
  }

  void set_scene(Vti_core& core) const {
    const ImageHeader& header = image_.header();
    std::fill(std::begin(core.scene_i.m_storage), std::end(core.scene_i.m_storage), 0U);
    Packer scene(core.scene_i.m_storage);
    for (const auto& corner : {header.box_hi, header.box_lo}) {
      for (std::uint32_t bits : corner) scene.put(bits, kFpWidth);
    }
    for (std::uint32_t offset :
         {header.bary_offset, header.plane_offset, header.list_offset, header.node_offset}) {
      scene.put(Memory::kBase + offset, config::kAddrBits);
    }
    scene.put(header.root, 29);
  }

  static void put_ray(Vti_core& core, std::uint32_t id, const Ray& ray) {
    std::fill(std::begin(core.ray_data_i.m_storage), std::end(core.ray_data_i.m_storage), 0U);
    Packer packer(core.ray_data_i.m_storage);
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
  static std::uint64_t late_hits(Vti_core& core) {
    std::uint64_t hits = 0;
    core.ray_valid_i = 0;
    core.m_axi_rvalid = 0;
    core.hit_ready_i = 1;
    for (int i = 0; i < kSilence; ++i) {
      if (core.hit_valid_o) ++hits;
      step(core);
    }
    return hits;
  }

  static bool put_answer(Vti_core& core, Memory& memory, std::uint64_t cycle,
                         std::mt19937_64& random) {
    const auto answer = memory.answer(cycle, random);
    if (!answer) return false;
    core.m_axi_rid = static_cast<std::remove_reference_t<decltype(core.m_axi_rid)>>(answer->id);
    core.m_axi_rresp = answer->error ? 2 : 0;
    core.m_axi_rlast = 1;
    memory.read(*answer, core.m_axi_rdata.m_storage);
    return true;
  }

  void take(const Vti_core& core, std::span<const Ray> rays, std::vector<std::uint8_t>& answers,
            EngineResult& result, Work& model_work) const {
    Unpacker fields(core.hit_data_o.m_storage);
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

  static void read_counters(const Vti_core& core, std::uint64_t cycles, std::uint64_t bytes,
                            double seconds, EngineResult& result) {
    Work& work = result.work;
    CacheSum trv;
    CacheSum list;
    CacheSum ist1;
    std::uint64_t ids = 0;
    Unpacker trv_fields(core.trv_counters_o.m_storage);
    for (int i = 0; i < config::kNumTrv; ++i) {
      trv.add(trv_fields);
      (void)trv_fields.get(kCounterWidth);  // rays
      work.restarts += trv_fields.get(kCounterWidth);
      work.full_leaves += trv_fields.get(kCounterWidth);
      work.leaves += trv_fields.get(kCounterWidth);
      work.steps += trv_fields.get(kCounterWidth);
    }
    Unpacker list_fields(core.list_counters_o.m_storage);
    for (int i = 0; i < config::kNumList; ++i) {
      list.add(list_fields);
      ids += list_fields.get(kCounterWidth);
    }
    Unpacker ist1_fields(core.ist1_counters_o.m_storage);
    for (int i = 0; i < config::kNumIst1; ++i) {
      ist1.add(ist1_fields);
      work.b_tests += ist1_fields.get(kCounterWidth);
      work.a_tests += ist1_fields.get(kCounterWidth);
    }
    work.c_tests = core.ist2_counters_o;

    const auto share = [cycles](std::uint64_t busy, int units) {
      return cycles == 0 ? 0.0 : static_cast<double>(busy) / (static_cast<double>(cycles) * units);
    };
    RtlCounters counters;
    counters.cycles = cycles;
    counters.dram_bytes = bytes;
    counters.seconds = seconds;
    counters.trv_busy = share(work.steps, config::kNumTrv);
    counters.list_busy = share(ids, config::kNumList);
    counters.ist1_busy = share(work.a_tests + work.b_tests, config::kNumIst1);
    counters.ist2_busy = share(work.c_tests, 1);
    counters.caches = {trv.named("trv_l1"), list.named("list_l1"), ist1.named("ist1_l1")};
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
