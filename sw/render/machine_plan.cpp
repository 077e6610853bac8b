// SPDX-License-Identifier: Apache-2.0
#include "render/machine_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace ti {
namespace {

/// Bits of an entry of the stack beside its number: the number of a node (`ti_pkg::node_index_t`).
constexpr int kNodeBits = 29;

/// A kind of unit with caches, and what it reads.
struct Reader {
  const char* name;
  int units, l1_bytes, l1_ways, l2_bytes;
  std::vector<std::uint64_t> sections;  ///< bytes; each starts at a line

  /// The most lines of one set: those of a section stand in sets in turn.
  [[nodiscard]] bool fits_l1(int line_bytes) const {
    const auto ways = static_cast<std::uint64_t>(l1_ways);
    const std::uint64_t sets = static_cast<std::uint64_t>(l1_bytes) / line_bytes / ways;
    std::uint64_t in_a_set = 0;
    for (const std::uint64_t bytes : sections)
      in_a_set += (lines_of(bytes, line_bytes) + sets - 1) / sets;
    return in_a_set <= ways;
  }
  [[nodiscard]] std::uint64_t lines(int line_bytes) const {
    std::uint64_t sum = 0;
    for (const std::uint64_t bytes : sections) sum += lines_of(bytes, line_bytes);
    return sum;
  }
  [[nodiscard]] std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t section : sections) sum += section;
    return sum;
  }

 private:
  [[nodiscard]] static std::uint64_t lines_of(std::uint64_t bytes, int line_bytes) {
    return (bytes + static_cast<std::uint64_t>(line_bytes) - 1) / line_bytes;
  }
};

std::vector<Reader> readers_of(const ImageParts& parts, const Config& base) {
  const auto bytes = [](std::uint64_t count, std::uint64_t element) { return count * element; };
  return {{"trv",
           base.num_trv,
           base.trv_l1_bytes,
           base.trv_l1_ways,
           base.trv_l2_bytes,
           {bytes(parts.node_count, sizeof(ImageNode))}},
          {"list",
           base.num_list,
           base.list_l1_bytes,
           base.list_l1_ways,
           base.list_l2_bytes,
           {bytes(parts.list_count, sizeof(std::uint32_t))}},
          {"ist1",
           base.num_ist1,
           base.ist1_l1_bytes,
           base.ist1_l1_ways,
           base.ist1_l2_bytes,
           {bytes(parts.triangle_count, sizeof(ImagePlane)),
            bytes(parts.triangle_count, sizeof(ImageBary))}}};
}

/// Cycles of that many reads of a line, one after the other.
std::uint64_t cycles_of(std::uint64_t lines, const MachineFacts& facts, const Config& base) {
  const double read =
      facts.memory_latency + std::ceil(base.line_bytes / facts.memory_bytes_per_cycle);
  return static_cast<std::uint64_t>(static_cast<double>(lines) * read);
}

MachineDecision any_hit(const Plan& plan) {
  MachineDecision d{.what = "any-hit rays", .bound = MachineDecision::kExact};
  if (const auto effect = any_hit_effect(plan)) {
    d.on = true;
    d.reason = fmt::format("{} asks whether anything is before a light", name_of(*effect));
    if (*effect == Effect::AmbientOcclusion)
      d.reason = "ambient occlusion asks whether anything is near";
  } else {
    d.set = "any_hit=false";
    d.reason = "no effect of the plan traces a ray that may end at any hit";
  }
  return d;
}

/// Whether no walk through the tree overflows the stack of the base.
bool never_overflows(const MachineFacts& facts, const Config& base) {
  return facts.bounds && facts.bounds->stack <= base.stack_depth;
}

MachineDecision restarts(const MachineFacts& facts, const Config& base) {
  MachineDecision d{.what = "restarts", .on = base.restart, .bound = MachineDecision::kExact};
  if (!facts.bounds) {
    d.reason = "the nodes of the image share children";
  } else if (never_overflows(facts, base)) {
    d.on = false;
    d.set = fmt::format("restart=false stack_depth={}", facts.bounds->stack);
    d.reason = fmt::format("a ray has at most {} entries on its stack of {}", facts.bounds->stack,
                           base.stack_depth);
  } else {
    d.reason = fmt::format(
        "a ray may have {} entries, the stack has {}, and each more takes {} bits a slot",
        facts.bounds->stack, base.stack_depth, kNodeBits + base.format.width());
  }
  return d;
}

MachineDecision watchdog(const MachineFacts& facts, const Config& base) {
  MachineDecision d{.what = "watchdog", .on = true, .bound = MachineDecision::kExact};
  if (!facts.bounds) {
    d.reason = "the nodes of the image share children";
    return d;
  }
  const std::uint64_t steps =
      never_overflows(facts, base) ? facts.bounds->nodes : facts.bounds->steps;
  const auto now = static_cast<std::uint64_t>(base.watchdog_steps);
  d.reason = fmt::format("a ray through this tree visits at most {} nodes", steps);
  if (std::bit_width(steps) < std::bit_width(now)) {
    // All that these bits can count, so that scenes of one size share an engine.
    d.set = fmt::format("watchdog_steps={}", (std::uint64_t{1} << std::bit_width(steps)) - 1);
    d.reason += fmt::format(", a count of {} bits in place of {}", std::bit_width(steps),
                            std::bit_width(now));
  } else {
    d.reason += ": a bound that saves no bit";
  }
  return d;
}

MachineDecision l2(const Reader& reader, const MachineFacts& facts, const Config& base) {
  MachineDecision d{.what = fmt::format("L2 of {}", reader.name), .bound = MachineDecision::kExact};
  if (reader.l2_bytes == 0) {
    d.reason = "the base has none";
    return d;
  }
  const std::uint64_t lines = reader.lines(base.line_bytes);
  d.on = !reader.fits_l1(base.line_bytes);
  if (d.on) {
    d.reason = fmt::format("{} bytes do not fit in the {} bytes of an L1, or not in its sets",
                           reader.bytes(), reader.l1_bytes);
    return d;
  }
  d.set = fmt::format("{}_l2_bytes=0", reader.name);
  d.reason = fmt::format("{} lines stay in each L1 once they are there", lines);
  const std::uint64_t reads =
      lines * static_cast<std::uint64_t>(reader.units) * static_cast<std::uint64_t>(base.cores);
  d.bound = fmt::format("no hit differs; {} cold misses", reads);
  if (facts.memory == MemoryKind::Dram) {
    d.bound += ", each at most a read of the DRAM";
  } else {
    d.cycles = cycles_of(reads, facts, base);
    d.bound += fmt::format(", at most {} cycles if none overlaps another", d.cycles);
  }
  return d;
}

MachineDecision memory(const std::vector<Reader>& readers, const MachineFacts& facts,
                       const Config& base) {
  std::uint64_t lines = 0;
  bool fits = true;
  for (const Reader& reader : readers) {
    lines += reader.lines(base.line_bytes);
    // Lines stand in banks and sets in turn, so a section as large as the cache has room.
    fits = fits && (reader.fits_l1(base.line_bytes) ||
                    (reader.sections.size() == 1 &&
                     reader.bytes() <= static_cast<std::uint64_t>(reader.l2_bytes)));
  }
  MachineDecision d{.what = "timing of memory", .on = !fits, .bound = MachineDecision::kExact};
  d.reason = fits ? fmt::format("the caches hold all {} lines, read once", lines)
                  : fmt::format("the caches do not hold all {} lines", lines);
  d.reason += fmt::format("; MEM= stays {}", name_of(facts.memory));
  if (fits && facts.memory != MemoryKind::Dram) {
    const std::uint64_t reads = lines * static_cast<std::uint64_t>(base.cores);
    d.bound = fmt::format(
        "another memory would change the cold misses alone, here {} cycles if "
        "none overlaps another",
        cycles_of(reads, facts, base));
  }
  return d;
}

MachineDecision cores(const Config& base) {
  return {.what = "cores",
          .on = true,
          .reason = fmt::format("{} as the base has; whether a core has idle slots is known after "
                                "a run, not before",
                                base.cores),
          .bound = MachineDecision::kExact};
}

MachineDecision rescaling(const MachineFacts& facts) {
  return {
      .what = "rescaling",
      .on = facts.scale != 0,
      .reason =
          facts.scale == 0
              ? fmt::format("coordinates up to {:.3g} are in the range of the test", facts.extent)
              : fmt::format("the host scales by 2^{}: coordinates up to {:.3g} are not in "
                            "the range of the test",
                            facts.scale, facts.extent),
      .bound = MachineDecision::kExact};
}

}  // namespace

std::string MachinePlan::set() const {
  std::string words;
  for (const MachineDecision& d : decisions) {
    if (!d.set.empty()) words += (words.empty() ? "" : " ") + d.set;
  }
  return words;
}

std::optional<Effect> any_hit_effect(const Plan& plan) {
  for (const Decision& d : plan.decisions) {
    const bool any = d.effect == Effect::Shadows || d.effect == Effect::SoftShadows ||
                     d.effect == Effect::AmbientOcclusion;
    if (any && d.on && d.rays != 0) return d.effect;
  }
  return std::nullopt;
}

MachineFacts machine_facts(const Image& image, const RtlOptions& memory) {
  MachineFacts facts{.bounds = tree_bounds(image), .parts = image.parts()};
  facts.memory = memory.memory;
  facts.memory_latency = memory.memory == MemoryKind::Ideal ? 1 : memory.memory_latency;
  facts.memory_bytes_per_cycle = memory.memory == MemoryKind::Ideal
                                     ? std::numeric_limits<double>::infinity()
                                     : memory.memory_bytes_per_cycle;
  facts.scale = image.header().scale;
  for (const auto& corner : {image.header().box_lo, image.header().box_hi}) {
    for (const std::uint32_t bits : corner)
      facts.extent = std::max(
          facts.extent, std::ldexp(std::abs(value_of_bits(image.format(), bits)), -facts.scale));
  }
  return facts;
}

MachinePlan make_machine_plan(const MachineFacts& facts, const Plan& plan, const Config& base) {
  const std::vector<Reader> readers = readers_of(facts.parts, base);
  MachinePlan out;
  out.decisions = {any_hit(plan), restarts(facts, base), watchdog(facts, base)};
  for (const Reader& reader : readers) out.decisions.push_back(l2(reader, facts, base));
  out.decisions.push_back(memory(readers, facts, base));
  out.decisions.push_back(cores(base));
  out.decisions.push_back(rescaling(facts));
  return out;
}

}  // namespace ti
