// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "cli/commands.hpp"
#include "cli/ray_source.hpp"
#include "cli/traced_run.hpp"
#include "engine/fault_campaign.hpp"
#include "engine/session.hpp"
#include "io/file.hpp"

namespace ti {
namespace {

constexpr const char* kLegend =
    "refused: by the reader, before any ray. changed: rays answered unlike on the whole image. "
    "memory, watchdog: rays that ended with that status. silent: rays through an unsound leaf that "
    "end well. false: rays that say memory failed in a sound image. differ: rays in which RTL and "
    "model differ. lost: rays lost or doubled.\n";

std::string row(const std::string& name, const FaultCount& c) {
  return fmt::format("{:<14}{:>9}{:>9}{:>9}{:>10}{:>10}{:>10}{:>10}{:>8}{:>8}{:>8}{:>8}\n", name,
                     c.images, c.refused, c.sound, c.rays, c.changed, c.memory_errors, c.watchdogs,
                     c.silent, c.false_alarm, c.mismatches, c.lost);
}

nlohmann::ordered_json json_of(const std::string& name, const FaultCount& c) {
  return {{"fault", name},
          {"images", c.images},
          {"refused", c.refused},
          {"sound", c.sound},
          {"rays", c.rays},
          {"changed", c.changed},
          {"memory_error", c.memory_errors},
          {"watchdog", c.watchdogs},
          {"silent", c.silent},
          {"false_alarm", c.false_alarm},
          {"mismatches", c.mismatches},
          {"lost", c.lost}};
}

}  // namespace

int faults(Arguments& arguments) {
  const RaySource source = parse_ray_source(arguments.rays);
  if (!source.file.empty())
    throw Error(fmt::format("RAYS={}: rays of a campaign are made: give KIND:COUNT, as random:16",
                            arguments.rays));
  if (arguments.run.engine != EngineKind::Model && arguments.run.engine != EngineKind::Rtl)
    throw Error("ENGINE: faults are traced by the model, or by rtl beside it");
  const std::filesystem::path& out = arguments.run.out;
  check_folder(out);
  const RunOptions& options = arguments.run;
  const Scene scene = load(arguments);
  const SceneImage whole = scene_image_of(scene, options);
  FaultSettings settings;
  settings.model = tracer_options_of(options.config);
  settings.first = arguments.first;
  settings.images = arguments.count;
  settings.seed = arguments.seed;
  settings.stop = options.stop;
  const auto model = Tracer::create(whole.image, settings.model);
  const ScaledFormat format{options.config.format, whole.image.header().scale,
                            whole.image.header().test == TestKind::Woop};
  settings.rays = [&](std::uint64_t number) {
    return make_rays(source, scene, *model, format, arguments.seed + number);
  };
  if (options.engine == EngineKind::Rtl) {
    settings.engine = [&options](const Image& image) {
      return load_rtl_engine(options.library, image, options.config, options.rtl);
    };
  }
  Progress progress(arguments.count);
  if (arguments.progress)
    settings.progress = [&progress](std::uint64_t images) { progress.update(images, 0); };
  const FaultCampaign campaign = run_faults(whole.image, settings);
  if (*options.stop) return kInterrupted;
  std::string text =
      fmt::format("{:<14}{:>9}{:>9}{:>9}{:>10}{:>10}{:>10}{:>10}{:>8}{:>8}{:>8}{:>8}\n", "fault",
                  "images", "refused", "sound", "rays", "changed", "memory", "watchdog", "silent",
                  "false", "differ", "lost");
  nlohmann::ordered_json lines = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < kImageFaults; ++i) {
    text += row(kImageFaultNames[i], campaign.counts[i]);
    lines.push_back(json_of(kImageFaultNames[i], campaign.counts[i]));
  }
  text += row("all", campaign.sum());
  for (const std::string& example : campaign.examples) text += example + "\n";
  fmt::print("{}{}", text, kLegend);
  const nlohmann::ordered_json report{{"command", "faults"},
                                      {"configuration", options.config.name},
                                      {"scene", options.scene.string()},
                                      {"rays", arguments.rays},
                                      {"seed", arguments.seed},
                                      {"first", arguments.first},
                                      {"faults", lines},
                                      {"examples", campaign.examples}};
  std::filesystem::create_directories(out);
  const std::string json = report.dump(2) + "\n";
  write_files({{out / "faults.json", json}});
  return campaign.sum().good() ? kGood : kChecksFailed;
}

}  // namespace ti
