// SPDX-License-Identifier: Apache-2.0
#include "cli/summary.hpp"

#include <fmt/core.h>

#include <cstdio>

namespace ti {
namespace {

double ratio(double part, double whole) { return whole > 0 ? part / whole : 0.0; }
double ratio(std::uint64_t part, std::uint64_t whole) {
  return ratio(static_cast<double>(part), static_cast<double>(whole));
}
double percent(std::uint64_t part, std::uint64_t whole) { return 100 * ratio(part, whole); }

bool has_counters(const MachineCounts& machine) {
  return !machine.units.empty() && !machine.units.front().activities.empty();
}

/// What each kind of unit did, in percent of its cycles.
void print_units(const MachineCounts& machine) {
  fmt::print("  % of cycles");
  for (const auto& [activity, cycles] : machine.units.front().activities)
    fmt::print(" {:>11}", activity);
  fmt::print("\n");
  for (const UnitCounts& unit : machine.units) {
    fmt::print("  {:11}", unit.name);
    for (const auto& [activity, cycles] : unit.activities)
      fmt::print(" {:11.1f}", percent(cycles, machine.cycles * unit.units));
    fmt::print("\n");
  }
}

void print_work(const Counts& counts) {
  const Work& work = counts.work;
  if (work.steps == 0) return;
  const auto per_ray = [&counts](std::uint64_t count) { return ratio(count, counts.rays); };
  fmt::print(
      "per ray: {:.1f} steps, {:.1f} leaves ({:.1f} with triangles), {:.1f} tests, {:.3f} "
      "restarts; (b) {:.0f} % of tests, (c) {:.0f} %\n",
      per_ray(work.steps), per_ray(work.leaves), per_ray(work.full_leaves), per_ray(work.a_tests),
      per_ray(work.restarts), percent(work.b_tests, work.a_tests),
      percent(work.c_tests, work.a_tests));
}

void print_dram(const MachineCounts& machine, int mhz) {
  if (!machine.dram) return;
  const DramCounts& dram = *machine.dram;
  fmt::print(
      "dram: {:.1f} MB, {:.1f} % of 128 GB/s, {:.1f} % row hits, {:.1f} requests in a channel, "
      "{:.0f} "
      "cycles a read, {} refreshes\n",
      static_cast<double>(dram.bytes) * 1e-6,
      percent(dram.bytes, DramCounts::kBytesPerCycle * dram.cycles),
      percent(dram.row_hits, dram.reads), ratio(dram.queued, DramCounts::kChannels * dram.cycles),
      ratio(dram.waited, dram.answers) * mhz / DramCounts::kMhz, dram.refreshes);
}

void print_machine(const Counts& counts, int mhz) {
  const MachineCounts& machine = *counts.machine;
  const Work& work = counts.work;
  const auto busy = [&machine](const char* name, std::uint64_t operations) {
    const UnitCounts* unit = machine.unit(name);
    return unit == nullptr ? 0.0 : percent(operations, machine.cycles * unit->units);
  };
  const double rays_per_cycle = ratio(counts.rays, machine.cycles);
  fmt::print(
      "machine: {} cycles, {:.3f} rays/cycle, {:.1f} Mrays/s if the clock is {} MHz; {:.0f} B/ray "
      "from memory; ",
      machine.cycles, rays_per_cycle, rays_per_cycle * mhz, mhz,
      ratio(machine.memory_bytes, counts.rays));
  if (!has_counters(machine)) {
    fmt::print("it has no counters (SET=counters=true builds them)\n");
    print_dram(machine, mhz);
    return;
  }
  fmt::print("busy: TRV {:.0f} %, LIST {:.0f} %, IST1 {:.0f} %, IST2 {:.0f} %\n",
             busy("trv", work.steps), busy("list", work.a_tests),
             busy("ist1", work.a_tests + work.b_tests), busy("ist2", work.c_tests));
  for (const CacheCounts& cache : machine.caches) {
    fmt::print("  {:8s} {:>12} requests, {:5.1f} % hits, {:4.1f} % joined a line on its way\n",
               cache.name, cache.accesses, percent(cache.hits, cache.accesses),
               percent(cache.merged, cache.accesses));
  }
  print_dram(machine, mhz);
  print_units(machine);
}

/// Rays of a picture by their kind.
void print_rays(const Picture& picture) {
  if (!picture.plan) return;
  std::string kinds;
  for (std::size_t i = 0; i < kRayKinds; ++i) {
    if (picture.rays[i] == 0) continue;
    kinds += fmt::format("{}{} {}", kinds.empty() ? "" : ", ", picture.rays[i],
                         name_of(static_cast<RayKind>(i)));
  }
  fmt::print("rays: {}\n", kinds);
  if (picture.dim_paths.paths != 0)
    fmt::print("{} paths ended, as they could not add a step of the output\n",
               picture.dim_paths.paths);
}

/// A line a wave, so that one sees the caches get warm.
void print_waves(const std::vector<Counts>& waves) {
  if (waves.size() < 2) return;
  fmt::print("  {:>4} {:>9} {:>11} {:>11}", "wave", "rays", "cycles", "rays/cycle");
  if (waves.front().machine) {
    for (const CacheCounts& cache : waves.front().machine->caches)
      fmt::print(" {:>8} %", cache.name);
  }
  fmt::print("\n");
  for (std::size_t i = 0; i < waves.size(); ++i) {
    fmt::print("  {:>4} {:>9}", i, waves[i].rays);
    if (const auto& machine = waves[i].machine) {
      fmt::print(" {:>11} {:>11.3f}", machine->cycles, ratio(waves[i].rays, machine->cycles));
      for (const CacheCounts& cache : machine->caches)
        fmt::print(" {:>10.1f}", percent(cache.hits, cache.accesses));
    }
    fmt::print("\n");
  }
}

void print_status(const Wave& total) {
  const auto line = [&total](Status status, const char* what) {
    if (const auto count = total.with_status(status); count != 0)
      fmt::print("status:  {} of {} rays {}\n", count, total.hits.size(), what);
  };
  line(Status::InvalidRay,
       "are invalid: a number that is not finite in the format, or no direction");
  line(Status::MemoryError, "ended with an error of the memory");
  line(Status::Watchdog, "were ended by the watchdog");
}

void print_checks(const Wave& total) {
  const LockStep& lock_step = total.lock_step;
  if (lock_step.on) {
    fmt::print("model:   {} mismatches in {} rays; work {}; {} lost, {} duplicated\n",
               lock_step.mismatches, total.hits.size(),
               lock_step.work_differs ? "DIFFERS" : "equal", total.counts.lost,
               total.counts.duplicated);
    for (const std::string& example : lock_step.examples) fmt::print("  {}\n", example);
  } else if (total.counts.machine) {
    fmt::print("model:   not compared; {} lost, {} duplicated\n", total.counts.lost,
               total.counts.duplicated);
  }
  print_status(total);
  if (!total.truth) return;
  const TruthReport& truth = *total.truth;
  fmt::print(
      "truth:   {} agree, {} ties, {} at an edge, {} grazing, {} where exact arithmetic overrules "
      "Embree, {} unexplained\n",
      truth.agree, truth.tie, truth.edge, truth.grazing, truth.embree_wrong, truth.unexplained);
  if (truth.unjudged != 0)
    fmt::print("         {} more were not judged: the limit of exact tests\n", truth.unjudged);
  for (const std::string& example : truth.examples) fmt::print("  {}\n", example);
}

}  // namespace

void print_tree(const Session& session) {
  const BuildStats& tree = session.tree();
  const std::filesystem::path& image = session.options().image;
  const int scale = session.format().scale;
  for (const std::string& warning : session.warnings()) fmt::print("warning: {}\n", warning);
  fmt::print(
      "tree: {} triangles, {} nodes, {} leaves ({} empty), {:.2f} references a triangle, depth {}, "
      "{}{}\n",
      tree.triangles, tree.nodes, tree.leaves, tree.empty_leaves,
      ratio(static_cast<double>(tree.references), tree.triangles), tree.depth,
      image.empty() ? fmt::format("{:.2f} s", tree.seconds) : "from " + image.string(),
      scale == 0 ? "" : fmt::format(", scaled by 2^{}", scale));
  std::fflush(stdout);  // also into a pipe: what follows may take long
}

void print_plan(const Plan& plan) {
  fmt::print("plan: {} primary rays\n", plan.primary);
  for (const Decision& d : plan.decisions) {
    fmt::print("  {:15} {:3}  {:>12}  {}\n", name_of(d.effect), d.on ? "on" : "off",
               d.rays == 0 ? std::string() : fmt::format("<= {} rays", d.rays), d.reason);
  }
  std::fflush(stdout);
}

void print_frame(const FrameReport& frame) {
  fmt::print("frame {}: {} triangles moved, {} of {} tiles traced, {} rays", frame.number,
             frame.moved_triangles, frame.traced_tiles, frame.tiles, frame.rays);
  if (frame.cycles) fmt::print(", {} cycles", *frame.cycles);
  if (frame.traced_tiles != 0)
    fmt::print("; tree: {:.0f} % built anew, {:.2f} s",
               percent(frame.tree.new_references, frame.tree.references), frame.tree.seconds);
  fmt::print("\n");
  std::fflush(stdout);
}

void print_machine_plan(const MachinePlan& plan, const Config& base, const Config& built) {
  const std::string set = plan.set();
  fmt::print("machine plan: {} with {}\n", base.name, set.empty() ? "nothing changed" : set);
  for (const MachineDecision& d : plan.decisions) {
    const bool told = !d.set.empty() || d.bound != MachineDecision::kExact;
    fmt::print("  {:16} {:3}  {:28}  {}{}{}\n", d.what, d.on ? "on" : "off", d.set, d.reason,
               told ? "; " : "", told ? d.bound : "");
  }
  fmt::print("  what is built: {}\n", built.name);
  std::fflush(stdout);
}

void print_summary(const Report& report, const Session& session) {
  print_rays(report.picture);
  const Wave& total = report.total;
  const Counts& counts = total.counts;
  print_work(counts);
  if (counts.machine) {
    print_machine(counts, session.options().config.clock_mhz);
    if (!report.picture.plan) print_waves(report.waves);
    fmt::print(
        "simulation: {:.1f} s, {:.0f} cycles/s, {:.0f} rays/s; checks and shading on the host "
        "{:.1f} s, {:.0f} "
        "% of the time\n",
        counts.seconds, ratio(static_cast<double>(counts.machine->cycles), counts.seconds),
        ratio(static_cast<double>(counts.rays), counts.seconds),
        total.times.lock_step + total.times.truth + report.picture.shading,
        100 * report.host_share());
  } else if (!report.picture.plan) {
    print_waves(report.waves);
  }
  print_checks(total);
}

}  // namespace ti
