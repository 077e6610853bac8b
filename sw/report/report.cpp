// SPDX-License-Identifier: Apache-2.0
#include "report/report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

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
    case EngineKind::Board:
      return "board";
  }
  return "";
}

double ratio(double part, double whole) { return whole > 0 ? part / whole : 0.0; }
double ratio(std::uint64_t part, std::uint64_t whole) {
  return ratio(static_cast<double>(part), static_cast<double>(whole));
}

/// `value`, or null when it is not known.
template <typename T>
ordered_json if_known(bool known, const T& value) {
  return known ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json provenance_json(const Report& report, const Session& session) {
  const RunOptions& options = session.options();
  const Request& request = report.request;
  ordered_json json = {
      {"commit", commit()},
      {"command", request.command},
      {"scene", options.scene.filename().string()},
      {"rays", request.command == "trace" ? ordered_json(request.rays) : ordered_json(nullptr)},
      {"seed", request.seed},
      {"size", nullptr},
      {"spp", if_known(request.size.has_value(), request.spp)},
      {"effects", if_known(request.size.has_value(), request.effects)},
      {"bounces", if_known(request.size.has_value(), request.bounces)},
      {"frames", if_known(!request.frames.empty(), request.frames)},
      {"layout", options.config.layout == Layout::kOdfl ? "odfl" : "dfl"},
      {"image_given", !options.image.empty()},
      {"waves", report.waves.size()}};
  if (request.size) json["size"] = *request.size;
  return json;
}

/// What was switched on in the simulation and its checks.
ordered_json switches_json(const RunOptions& options) {
  return {{"lock_step", options.compared()},
          {"truth", options.truth && options.engine != EngineKind::Embree},
          {"stall_seed", options.rtl.stall_seed},
          {"stall_share", options.rtl.stall_seed != 0 ? options.rtl.stall_share : 0.0},
          {"error_every", options.rtl.error_every},
          {"lose_every", options.rtl.lose_every},
          {"late_every", options.rtl.late_every},
          {"spoil_every", options.rtl.spoil_every}};
}

ordered_json tree_json(const Session& session) {
  const BuildStats& tree = session.tree();
  const bool built = session.options().image.empty();
  return {{"nodes", tree.nodes},
          {"leaves", tree.leaves},
          {"empty_leaves", tree.empty_leaves},
          {"depth", tree.depth},
          {"references", tree.references},
          {"largest_leaf", tree.largest_leaf},
          {"sah_cost", if_known(built, tree.sah_cost)},
          {"dropped_zero_area", tree.dropped_zero_area},
          {"dropped_nonfinite", tree.dropped_nonfinite}};
}

ordered_json losses_json(const RangeLosses& losses) {
  return {{"overflow", losses.overflowed},
          {"vanish", losses.vanished},
          {"keep_few_bits", losses.shortened}};
}

/// How the engine has the scene, and what its format does not hold of it.
ordered_json range_json(const Session& session) {
  const RangeAudit& range = session.tree().range;
  return {
      {"scale", session.format().scale},           {"coordinates", losses_json(range.coordinates)},
      {"constants", losses_json(range.constants)}, {"moved", range.moved},
      {"merged_vertices", range.merged},           {"dropped_overflow", range.dropped_overflow},
      {"dropped_rounded", range.dropped_rounded}};
}

ordered_json check_json(const Wave& total) {
  ordered_json check;
  const LockStep& lock_step = total.lock_step;
  check["lock_step"] = lock_step.on;
  check["model_mismatches"] = if_known(lock_step.on, lock_step.mismatches);
  check["work_differs"] = lock_step.work_differs;
  check["truth_unexplained"] =
      total.truth ? ordered_json(total.truth->unexplained) : ordered_json(nullptr);
  check["lost"] = total.counts.lost;
  check["duplicated"] = total.counts.duplicated;
  check["status"] = {{"ok", total.with_status(Status::Ok)},
                     {"invalid_ray", total.with_status(Status::InvalidRay)},
                     {"memory_error", total.with_status(Status::MemoryError)},
                     {"watchdog", total.with_status(Status::Watchdog)}};
  if (total.truth) {
    const TruthReport& truth = *total.truth;
    check["truth"] = {{"agree", truth.agree},      {"embree_wrong", truth.embree_wrong},
                      {"tie", truth.tie},          {"edge", truth.edge},
                      {"grazing", truth.grazing},  {"unexplained", truth.unexplained},
                      {"unjudged", truth.unjudged}};
  }
  return check;
}

ordered_json caches_json(const MachineCounts& machine) {
  ordered_json json = ordered_json::object();
  for (const CacheCounts& cache : machine.caches) {
    json[cache.name] = {{"accesses", cache.accesses},
                        {"hits", cache.hits},
                        {"merged", cache.merged},
                        {"misses", cache.misses}};
  }
  return json;
}

/// Share of the cycles in which the units of a kind worked.
double busy(const MachineCounts& machine, const char* name, std::uint64_t operations) {
  const UnitCounts* unit = machine.unit(name);
  return unit == nullptr ? 0.0 : ratio(operations, machine.cycles * unit->units);
}

/// What the DRAM did; null without one.
ordered_json dram_json(const Counts& counts, int clock_mhz) {
  if (!counts.machine || !counts.machine->dram) return nullptr;
  const DramCounts& dram = *counts.machine->dram;
  return {{"mhz", DramCounts::kMhz},
          {"cycles", dram.cycles},
          {"reads", dram.reads},
          {"row_hits", dram.row_hits},
          {"row_hit_share", ratio(dram.row_hits, dram.reads)},
          {"bytes", dram.bytes},
          {"bandwidth_share", ratio(dram.bytes, DramCounts::kBytesPerCycle * dram.cycles)},
          {"queue", ratio(dram.queued, DramCounts::kChannels * dram.cycles)},
          {"latency", ratio(dram.waited, dram.answers) * clock_mhz / DramCounts::kMhz},
          {"refreshes", dram.refreshes}};
}

ordered_json memory_json(const RunOptions& options, const Counts& counts) {
  const RtlOptions& rtl = options.rtl;
  const bool fixed = rtl.memory == MemoryKind::Fixed;
  return {{"kind", name_of(rtl.memory)},
          {"latency", if_known(fixed, rtl.memory_latency)},
          {"bytes_per_cycle", if_known(fixed, rtl.memory_bytes_per_cycle)},
          {"dram", dram_json(counts, options.config.clock_mhz)}};
}

ordered_json machine_json(const Session& session, const Counts& counts) {
  ordered_json json;
  const Work& work = counts.work;
  const bool rtl = counts.machine.has_value();
  const MachineCounts machine = counts.machine.value_or(MachineCounts{});
  const double rays_per_cycle = ratio(counts.rays, machine.cycles);
  const int mhz = session.options().config.clock_mhz;
  const auto per_ray = [&counts](std::uint64_t count) { return ratio(count, counts.rays); };

  json["cycles"] = if_known(rtl, machine.cycles);
  json["clock_mhz"] = mhz;
  json["mrays_per_s"] = if_known(rtl, rays_per_cycle * mhz);
  json["rays_per_cycle"] = if_known(rtl, rays_per_cycle);
  json["per_ray"] = {{"steps", per_ray(work.steps)},
                     {"leaves", per_ray(work.leaves)},
                     {"full_leaves", per_ray(work.full_leaves)},
                     {"tests", per_ray(work.a_tests)},
                     {"restarts", per_ray(work.restarts)},
                     {"dram_bytes", if_known(rtl, per_ray(machine.memory_bytes))}};
  json["phase"] = {{"a_tests", work.a_tests},
                   {"b_share", ratio(work.b_tests, work.a_tests)},
                   {"c_share", ratio(work.c_tests, work.a_tests)}};
  const std::uint64_t passes = work.a_tests + work.b_tests;
  json["utilization"] = {{"trv", if_known(rtl, busy(machine, "trv", work.steps))},
                         {"list", if_known(rtl, busy(machine, "list", work.a_tests))},
                         {"ist1", if_known(rtl, busy(machine, "ist1", passes))},
                         {"ist2", if_known(rtl, busy(machine, "ist2", work.c_tests))}};
  json["stalls"] = ordered_json::object();
  for (const UnitCounts& unit : machine.units) {
    for (const auto& [activity, cycles] : unit.activities)
      json["stalls"][unit.name][activity] = ratio(cycles, machine.cycles * unit.units);
  }
  json["cache"] = caches_json(machine);
  return json;
}

ordered_json waves_json(const Report& report, int clock_mhz) {
  ordered_json json = ordered_json::array();
  for (const Counts& wave : report.waves) {
    const bool rtl = wave.machine.has_value();
    const MachineCounts machine = wave.machine.value_or(MachineCounts{});
    json.push_back({{"rays", wave.rays},
                    {"cycles", if_known(rtl, machine.cycles)},
                    {"dram_bytes", if_known(rtl, machine.memory_bytes)},
                    {"dram", dram_json(wave, clock_mhz)},
                    {"cache", caches_json(machine)}});
  }
  return json;
}

ordered_json plan_json(const Picture& picture) {
  if (!picture.plan) return nullptr;
  ordered_json json = ordered_json::array();
  for (const Decision& d : picture.plan->decisions) {
    json.push_back({{"effect", name_of(d.effect)},
                    {"on", d.on},
                    {"reason", d.reason},
                    {"rays", d.rays},
                    {"bound", d.bound}});
  }
  return json;
}

/// The frames of an animation; null for anything else.
ordered_json frames_json(const Report& report) {
  if (report.frames.empty()) return nullptr;
  ordered_json json = ordered_json::array();
  for (const FrameReport& f : report.frames) {
    json.push_back({{"number", f.number},
                    {"seconds", f.seconds},
                    {"moved_triangles", f.moved_triangles},
                    {"tiles", f.tiles},
                    {"traced_tiles", f.traced_tiles},
                    {"rays", f.rays},
                    {"cycles", if_known(f.cycles.has_value(), f.cycles.value_or(0))},
                    {"tree",
                     {{"nodes", f.tree.nodes},
                      {"references", f.tree.references},
                      {"new_cells", f.tree.new_cells},
                      {"new_references", f.tree.new_references},
                      {"sah_cost", f.tree.sah_cost}}}});
  }
  return json;
}

/// Seconds that each frame took, and its tree.
ordered_json frame_times_json(const Report& report) {
  if (report.frames.empty()) return nullptr;
  ordered_json json = ordered_json::array();
  for (const FrameReport& f : report.frames)
    json.push_back({{"frame", f.host_seconds}, {"tree", f.tree.seconds}});
  return json;
}

ordered_json machine_plan_json(const Picture& picture) {
  if (!picture.machine) return nullptr;
  ordered_json json = ordered_json::array();
  for (const MachineDecision& d : picture.machine->decisions) {
    json.push_back({{"what", d.what},
                    {"on", d.on},
                    {"set", d.set},
                    {"reason", d.reason},
                    {"bound", d.bound},
                    {"cycles", d.cycles}});
  }
  return json;
}

/// Paths that ended early, and what a pixel can lack by it in steps of the output.
ordered_json dim_paths_json(const Picture& picture) {
  if (!picture.plan) return nullptr;
  const double steps = picture.dim_paths.bound * picture.exposure / kOutputStep;
  return {{"paths", picture.dim_paths.paths}, {"bound_steps", steps}};
}

ordered_json rays_json(const Picture& picture) {
  if (!picture.plan) return nullptr;
  ordered_json json;
  for (std::size_t i = 0; i < kRayKinds; ++i)
    json[name_of(static_cast<RayKind>(i))] = picture.rays[i];
  return json;
}

ordered_json spread_json(std::vector<std::uint32_t> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  std::uint64_t sum = 0;
  for (const std::uint32_t value : values) sum += value;
  const std::size_t last = values.size() - 1;
  return {{"mean", ratio(sum, values.size())},
          {"median", values[last / 2]},
          {"p99", values[last * 99 / 100]},
          {"max", values[last]}};
}

}  // namespace

void Report::add(Wave wave) {
  waves.push_back(wave.counts);
  total += wave;
}

double Report::host_share() const {
  const HostTimes& times = total.times;
  const double host = times.lock_step + times.truth + picture.shading;
  return ratio(host, times.engine + host);
}

std::string to_json(const Report& report, const Session& session) {
  const RunOptions& options = session.options();
  const Wave& total = report.total;
  const Counts& counts = total.counts;
  std::vector<std::uint32_t> steps;
  for (const Hit& hit : total.hits) steps.push_back(hit.steps);

  ordered_json json;
  json["schema"] = fmt::format("ti-report-{}", Report::kVersion);
  json["provenance"] = provenance_json(report, session);
  json["config"] = options.config.name;
  json["keys"] = ordered_json::parse(options.config.json);
  json["switches"] = switches_json(options);
  json["memory"] = memory_json(options, counts);
  json["scene"] = session.scene().name;
  json["engine"] = name_of(options.engine);
  const Format& format = options.config.format;
  json["format"] = {format.exp_bits, format.frac_bits};
  json["rounding"] = format.modes.toward_zero ? "zero" : "nearest";
  json["subnormals"] = format.modes.flush ? "flush" : "keep";
  json["reciprocal"] = format.modes.rcp_table_bits > 0 ? "newton" : "division";
  json["triangles"] = session.tree().triangles;
  json["tree"] = tree_json(session);
  json["range"] = range_json(session);
  json["image_bytes"] = session.image().bytes().size();
  json["rays"] = total.hits.size();
  json["plan"] = plan_json(report.picture);
  json["machine_plan"] = machine_plan_json(report.picture);
  json["rays_of"] = rays_json(report.picture);
  json["dim_paths"] = dim_paths_json(report.picture);
  json["exposure"] = if_known(report.picture.plan.has_value(), report.picture.exposure);
  json["hits"] = std::count_if(total.hits.begin(), total.hits.end(),
                               [](const Hit& hit) { return hit.is_hit(); });
  json["stopped"] = total.stopped;
  json.update(machine_json(session, counts));
  json["spread"] = {{"steps", options.engine == EngineKind::Embree ? ordered_json(nullptr)
                                                                   : spread_json(std::move(steps))},
                    {"tests", spread_json(total.tests)}};
  json["frames"] = frames_json(report);
  json["waves"] = waves_json(report, options.config.clock_mhz);
  json["check"] = check_json(total);
  const double cycles = counts.machine ? static_cast<double>(counts.machine->cycles) : 0.0;
  const double seconds = counts.seconds;
  json["sim"] = {{"seconds", seconds},
                 {"cycles_per_s", if_known(counts.machine.has_value(), ratio(cycles, seconds))},
                 {"rays_per_s", ratio(static_cast<double>(counts.rays), seconds)}};
  json["time"] = {{"build", if_known(options.image.empty(), session.tree().seconds)},
                  {"engine", total.times.engine},
                  {"lock_step", total.times.lock_step},
                  {"truth", total.times.truth},
                  {"shading", report.picture.shading},
                  {"frames", frame_times_json(report)},
                  {"host_share", report.host_share()}};
  return json.dump(2) + "\n";
}

}  // namespace ti
