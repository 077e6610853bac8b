// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "engine/session.hpp"
#include "io/file.hpp"

namespace ti {
namespace {

using nlohmann::ordered_json;

const char* name_of(EngineKind kind) {
  switch (kind) {
    case EngineKind::Rtl:
      return "rtl";
    case EngineKind::Model:
      return "model";
    case EngineKind::Embree:
      return "embree";
  }
  return "";
}

double ratio(double part, double whole) { return whole > 0 ? part / whole : 0.0; }

ordered_json tree_json(const Session& session) {
  const BuildStats& tree = session.tree();
  const bool built = session.options().image.empty();
  const auto when_built = [built](double value) {
    return built ? ordered_json(value) : ordered_json(nullptr);
  };
  return {{"nodes", tree.nodes},
          {"leaves", tree.leaves},
          {"empty_leaves", tree.empty_leaves},
          {"depth", tree.depth},
          {"references", tree.references},
          {"largest_leaf", tree.largest_leaf},
          {"sah_cost", when_built(tree.sah_cost)},
          {"build_seconds", when_built(tree.seconds)},
          {"dropped_zero_area", tree.dropped_zero_area},
          {"dropped_nonfinite", tree.dropped_nonfinite}};
}

ordered_json check_json(const Session::Outcome& outcome) {
  ordered_json check;
  const LockStep& lock_step = outcome.engine.lock_step;
  check["lock_step"] = lock_step.on;
  check["model_mismatches"] =
      lock_step.on ? ordered_json(lock_step.mismatches) : ordered_json(nullptr);
  check["work_differs"] = lock_step.work_differs;
  check["truth_unexplained"] =
      outcome.truth ? ordered_json(outcome.truth->unexplained) : ordered_json(nullptr);
  check["lost"] = outcome.engine.lost;
  check["duplicated"] = outcome.engine.duplicated;
  check["status"] = {{"ok", outcome.with_status(Status::Ok)},
                     {"invalid_ray", outcome.with_status(Status::InvalidRay)},
                     {"memory_error", outcome.with_status(Status::MemoryError)},
                     {"watchdog", outcome.with_status(Status::Watchdog)}};
  if (outcome.truth) {
    const TruthReport& truth = *outcome.truth;
    check["truth"] = {{"agree", truth.agree},      {"embree_wrong", truth.embree_wrong},
                      {"tie", truth.tie},          {"edge", truth.edge},
                      {"grazing", truth.grazing},  {"unexplained", truth.unexplained},
                      {"unjudged", truth.unjudged}};
  }
  return check;
}

ordered_json machine_json(const Session& session, const Session::Outcome& outcome,
                          std::size_t rays) {
  ordered_json json;
  const Work& work = outcome.engine.work;
  const double n = static_cast<double>(rays);
  const bool rtl = outcome.engine.rtl.has_value();
  const RtlCounters counters = rtl ? *outcome.engine.rtl : RtlCounters{};
  const auto when_rtl = [rtl](double value) {
    return rtl ? ordered_json(value) : ordered_json(nullptr);
  };
  const double cycles = static_cast<double>(counters.cycles);
  const double rays_per_cycle = ratio(n, cycles);

  json["cycles"] = rtl ? ordered_json(counters.cycles) : ordered_json(nullptr);
  json["clock_mhz"] = session.options().config.clock_mhz;
  json["mrays_per_s"] = when_rtl(rays_per_cycle * session.options().config.clock_mhz);
  json["rays_per_cycle"] = when_rtl(rays_per_cycle);
  json["per_ray"] = {{"steps", ratio(static_cast<double>(work.steps), n)},
                     {"leaves", ratio(static_cast<double>(work.leaves), n)},
                     {"full_leaves", ratio(static_cast<double>(work.full_leaves), n)},
                     {"tests", ratio(static_cast<double>(work.a_tests), n)},
                     {"restarts", ratio(static_cast<double>(work.restarts), n)},
                     {"dram_bytes", when_rtl(ratio(static_cast<double>(counters.dram_bytes), n))}};
  json["phase"] = {
      {"a_tests", work.a_tests},
      {"b_share", ratio(static_cast<double>(work.b_tests), static_cast<double>(work.a_tests))},
      {"c_share", ratio(static_cast<double>(work.c_tests), static_cast<double>(work.a_tests))}};
  json["utilization"] = {{"trv", when_rtl(counters.trv_busy)},
                         {"list", when_rtl(counters.list_busy)},
                         {"ist1", when_rtl(counters.ist1_busy)},
                         {"ist2", when_rtl(counters.ist2_busy)}};
  json["stalls"] = ordered_json::object();
  for (const UnitAccount& account : counters.accounts) {
    for (const auto& [activity, cycles_so] : account.activities) {
      json["stalls"][account.unit][activity] =
          ratio(static_cast<double>(cycles_so), static_cast<double>(account.unit_cycles));
    }
  }
  json["cache"] = ordered_json::object();
  for (const CacheCounters& cache : counters.caches) {
    json["cache"][cache.name] = {{"accesses", cache.accesses},
                                 {"hits", cache.hits},
                                 {"merged", cache.merged},
                                 {"misses", cache.misses}};
  }
  return json;
}

/// What each kind of unit did, in percent of its cycles.
void print_accounts(const std::vector<UnitAccount>& accounts) {
  if (accounts.empty()) return;
  fmt::print("  % of cycles");
  for (const auto& [activity, cycles] : accounts.front().activities)
    fmt::print(" {:>11}", activity);
  fmt::print("\n");
  for (const UnitAccount& account : accounts) {
    fmt::print("  {:11}", account.unit);
    for (const auto& [activity, cycles] : account.activities) {
      fmt::print(" {:11.1f}", 100 * ratio(static_cast<double>(cycles),
                                          static_cast<double>(account.unit_cycles)));
    }
    fmt::print("\n");
  }
}

void print_status(const Session::Outcome& outcome, std::size_t rays) {
  const auto line = [&outcome, rays](Status status, const char* what) {
    if (const auto count = outcome.with_status(status); count != 0)
      fmt::print("status:  {} of {} rays {}\n", count, rays, what);
  };
  line(Status::InvalidRay, "are invalid: a number that is not finite, or no direction");
  line(Status::MemoryError, "ended with an error of the memory");
  line(Status::Watchdog, "were ended by the watchdog");
}

void print_summary(const Session& session, const Session::Outcome& outcome, std::size_t rays) {
  const double n = static_cast<double>(rays);
  const Work& work = outcome.engine.work;
  if (work.steps != 0) {
    fmt::print(
        "per ray: {:.1f} steps, {:.1f} leaves ({:.1f} with triangles), {:.1f} tests, {:.3f} "
        "restarts; (b) {:.0f} % of "
        "tests, (c) {:.0f} %\n",
        static_cast<double>(work.steps) / n, static_cast<double>(work.leaves) / n,
        static_cast<double>(work.full_leaves) / n, static_cast<double>(work.a_tests) / n,
        static_cast<double>(work.restarts) / n,
        100 * ratio(static_cast<double>(work.b_tests), static_cast<double>(work.a_tests)),
        100 * ratio(static_cast<double>(work.c_tests), static_cast<double>(work.a_tests)));
  }
  if (outcome.engine.rtl) {
    const RtlCounters& rtl = *outcome.engine.rtl;
    const double cycles = static_cast<double>(rtl.cycles);
    fmt::print(
        "machine: {} cycles, {:.3f} rays/cycle, {:.1f} Mrays/s at {} MHz; busy: TRV {:.0f} %, LIST "
        "{:.0f} %, IST1 {:.0f} "
        "%, IST2 {:.0f} %; {:.0f} B/ray from memory\n",
        rtl.cycles, n / cycles, n / cycles * session.options().config.clock_mhz,
        session.options().config.clock_mhz, 100 * rtl.trv_busy, 100 * rtl.list_busy,
        100 * rtl.ist1_busy, 100 * rtl.ist2_busy, static_cast<double>(rtl.dram_bytes) / n);
    for (const CacheCounters& cache : rtl.caches) {
      fmt::print(
          "  {:8s} {:>12} requests, {:5.1f} % hits, {:4.1f} % joined a line on its way\n",
          cache.name, cache.accesses,
          100 * ratio(static_cast<double>(cache.hits), static_cast<double>(cache.accesses)),
          100 * ratio(static_cast<double>(cache.merged), static_cast<double>(cache.accesses)));
    }
    print_accounts(rtl.accounts);
    fmt::print("simulation: {:.1f} s, {:.0f} cycles/s, {:.0f} rays/s\n", rtl.seconds,
               cycles / rtl.seconds, n / rtl.seconds);
  }
  const LockStep& lock_step = outcome.engine.lock_step;
  if (lock_step.on) {
    fmt::print("model:   {} mismatches in {} rays; work {}; {} lost, {} duplicated\n",
               lock_step.mismatches, rays, lock_step.work_differs ? "DIFFERS" : "equal",
               outcome.engine.lost, outcome.engine.duplicated);
    for (const std::string& example : lock_step.examples) fmt::print("  {}\n", example);
  } else if (outcome.engine.rtl) {
    fmt::print("model:   not compared; {} lost, {} duplicated\n", outcome.engine.lost,
               outcome.engine.duplicated);
  }
  print_status(outcome, rays);
  if (outcome.truth) {
    const TruthReport& truth = *outcome.truth;
    fmt::print(
        "truth:   {} agree, {} ties, {} at an edge, {} grazing, {} where exact arithmetic "
        "overrules Embree, {} "
        "unexplained\n",
        truth.agree, truth.tie, truth.edge, truth.grazing, truth.embree_wrong, truth.unexplained);
    if (truth.unjudged > 0) {
      fmt::print("         {} disagreements with Embree are not judged: that would take too long\n",
                 truth.unjudged);
    }
    for (const std::string& example : truth.examples) fmt::print("  {}\n", example);
  }
}

}  // namespace

void report(const Session& session, const Session::Outcome& outcome, std::size_t rays,
            const std::filesystem::path& folder) {
  const RunOptions& options = session.options();
  ordered_json json;
  json["config"] = options.config.name;
  json["scene"] = session.scene().name;
  json["engine"] = name_of(options.engine);
  json["format"] = {options.config.format.exp_bits, options.config.format.frac_bits};
  json["triangles"] = session.tree().triangles;
  json["rays"] = rays;
  json.update(machine_json(session, outcome, rays));
  json["check"] = check_json(outcome);
  const bool rtl = outcome.engine.rtl.has_value();
  const double seconds = rtl ? outcome.engine.rtl->seconds : outcome.seconds;
  json["sim"] = {
      {"seconds", seconds},
      {"cycles_per_s",
       rtl ? ordered_json(ratio(static_cast<double>(outcome.engine.rtl->cycles), seconds))
           : ordered_json(nullptr)},
      {"rays_per_s", ratio(static_cast<double>(rays), seconds)}};
  json["memory"] = {{"latency", options.rtl.memory_latency},
                    {"bytes_per_cycle", options.rtl.memory_bytes_per_cycle}};
  json["tree"] = tree_json(session);
  json["image_bytes"] = session.image().bytes().size();
  write_file(folder / "report.json", json.dump(2) + "\n");
  print_summary(session, outcome, rays);
}

}  // namespace ti
