// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>

#include "base/error.hpp"
#include "cli/hardcases.hpp"
#include "cli/ray_source.hpp"
#include "engine/session.hpp"
#include "io/file.hpp"
#include "io/npy.hpp"
#include "io/png.hpp"
#include "scene/rays.hpp"

namespace {

using ti::EngineKind;
using ti::Error;

constexpr int kGood = 0;
constexpr int kChecksFailed = 1;
constexpr int kBadInput = 2;

struct Arguments {
  std::string config_file;
  ti::RunOptions run;
  std::string size = "256x256";
  std::string effects = "none";
  std::string rays;
  std::string cases_file;
  int spp = 1;
  std::uint64_t seed = 1;
  bool dump = false;
};

struct Size {
  int width, height;
};

Size parse_size(const std::string& text) {
  int width = 0;
  int height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 1 ||
      height < 1 || width > 16384 || height > 16384) {
    throw Error(fmt::format(
        "SIZE={}: give a size as WIDTHxHEIGHT, each from 1 to 16384, such as 256x256", text));
  }
  return {width, height};
}

ti::Scene load(const Arguments& arguments) {
  ti::Scene scene = ti::load_scene(arguments.run.scene);
  if (scene.mesh.triangles.empty()) {
    scene.warnings.push_back(
        fmt::format("{} has no triangle: every ray misses", arguments.run.scene.string()));
  }
  return scene;
}

void dump(const std::filesystem::path& folder, std::span<const ti::Hit> hits) {
  ti::save_hits(folder / "hits.npy", hits);
  ti::save_prims(folder / "prims.npy", hits);
}

int render(const Arguments& arguments) {
  const Size size = parse_size(arguments.size);
  ti::check_folder(arguments.run.out);
  if (arguments.effects != "none") {
    throw Error(fmt::format("EFFECTS={}: only EFFECTS=none (primary rays) is there so far",
                            arguments.effects));
  }
  if (arguments.spp < 1 || arguments.spp > 4096)
    throw Error(fmt::format("SPP={}: give 1 to 4096", arguments.spp));
  const ti::Session session(arguments.run, load(arguments));
  const auto primary = ti::primary_rays(session.scene().camera, size.width, size.height,
                                        arguments.spp, arguments.seed);
  const auto outcome = session.trace(primary.rays);

  const auto colours = ti::shade(session.scene(), primary.rays, outcome.hits);
  std::vector<glm::vec3> pixels(static_cast<std::size_t>(size.width) *
                                static_cast<std::size_t>(size.height));
  for (std::size_t i = 0; i < colours.size(); ++i) {
    pixels[primary.index[i]] += colours[i] / static_cast<float>(arguments.spp);
  }
  const std::filesystem::path folder = arguments.run.out;
  ti::save_png(folder / "image.png", pixels, size.width, size.height);
  if (arguments.dump) {
    ti::save_rays(folder / "rays.npy", primary.rays);
    dump(folder, outcome.hits);
  }
  ti::report(session, outcome, primary.rays.size(), folder);
  fmt::print("{}: image.png, report.json{}\n", folder.string(),
             arguments.dump ? ", rays.npy, hits.npy, prims.npy" : "");
  return outcome.good() ? kGood : kChecksFailed;
}

int trace(const Arguments& arguments) {
  const ti::RaySource source = ti::parse_ray_source(arguments.rays);
  ti::check_folder(arguments.run.out);
  std::vector<ti::Ray> rays;
  if (!source.file.empty()) {
    rays = ti::load_rays(source.file);
    if (rays.empty())
      throw Error(fmt::format("{}: the array holds no ray; give one ray a row", source.file));
  }
  const ti::Session session(arguments.run, load(arguments));
  if (source.file.empty()) {
    rays = ti::make_rays(source, session.scene(), *session.model(), arguments.run.config.format,
                         arguments.seed);
  }
  const auto outcome = session.trace(rays);
  const std::filesystem::path folder = arguments.run.out;
  if (arguments.dump) ti::save_rays(folder / "rays.npy", rays);
  dump(folder, outcome.hits);
  ti::report(session, outcome, rays.size(), folder);
  fmt::print("{}: {}hits.npy, prims.npy, report.json\n", folder.string(),
             arguments.dump ? "rays.npy, " : "");
  return outcome.good() ? kGood : kChecksFailed;
}

int image(const Arguments& arguments) {
  const std::filesystem::path& file = arguments.run.out;
  ti::check_folder(file.parent_path());
  const ti::Session session(arguments.run, load(arguments));
  const auto bytes = session.image().bytes();
  ti::write_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  fmt::print("{}: {} bytes\n", file.string(), bytes.size());
  return kGood;
}

int hardcases(const Arguments& arguments) {
  const auto cases = ti::load_hardcases(arguments.cases_file);
  const ti::Config& config = arguments.run.config;
  std::uint64_t mismatches = 0;
  const auto one = [&](const ti::Mesh& mesh, const ti::Ray& ray) {
    if (arguments.run.engine == EngineKind::Embree) {
      return ti::Truth(mesh, config.format).trace(std::span(&ray, 1)).front();
    }
    ti::BuildOptions build;
    build.format = config.format;
    ti::BuildStats stats;
    const ti::Image image = ti::build_image(mesh, build, stats);
    const auto model = ti::Tracer::create(
        image, {.stack_depth = config.stack_depth, .watchdog_steps = config.watchdog_steps});
    ti::RtlOptions rtl = arguments.run.rtl;
    rtl.progress = false;
    const auto engine = arguments.run.engine == EngineKind::Rtl
                            ? ti::make_rtl_engine(image, config, *model, rtl)
                            : ti::make_model_engine(*model);
    const auto result = engine->trace(std::span(&ray, 1));
    mismatches += result.lock_step.mismatches + result.lost + result.duplicated +
                  (result.lock_step.work_differs ? 1 : 0);
    return ti::hit_of(config.format, result.hits[0]);
  };
  const int failures = ti::run_hardcases(cases, one, config.format);
  if (arguments.run.engine == EngineKind::Rtl)
    fmt::print("{} mismatches between RTL and model\n", mismatches);
  return failures == 0 && mismatches == 0 ? kGood : kChecksFailed;
}

/// An option whose value is one of a few words.
template <typename T>
CLI::Option* add_choice(CLI::App& command, const std::string& name, T& target,
                        const std::map<std::string, T>& choices) {
  std::string words;
  for (const auto& [word, value] : choices) words += (words.empty() ? "" : ", ") + word;
  const auto choose = [name, &target, choices, words](const std::string& word) {
    const auto found = choices.find(word);
    if (found == choices.end())
      throw Error(fmt::format("{} {}: no such choice; there are {}", name, word, words));
    target = found->second;
  };
  return command.add_option_function<std::string>(name, choose, words);
}

void add_config(CLI::App& command, Arguments& arguments) {
  command.add_option("--config", arguments.config_file, "config.json of the configuration")
      ->required();
}

void add_engine(CLI::App& command, Arguments& arguments) {
  add_choice<EngineKind>(
      command, "--engine", arguments.run.engine,
      {{"rtl", EngineKind::Rtl}, {"model", EngineKind::Model}, {"embree", EngineKind::Embree}});
  ti::RtlOptions& rtl = arguments.run.rtl;
  command
      .add_option("--mem-latency", rtl.memory_latency, "cycles from a line request to its answer")
      ->check(CLI::Range(1, 1000000));
  command
      .add_option("--mem-bytes-per-cycle", rtl.memory_bytes_per_cycle, "bandwidth of the memory")
      ->check(CLI::Range(0.001, 1e6));
  command.add_option("--stall-seed", rtl.stall_seed,
                     "not 0: random stalls on every port of the engine");
  command.add_option("--stall-share", rtl.stall_share, "share of the cycles with a stall")
      ->check(CLI::Range(0.0, 0.99));
  command.add_option("--error-every", rtl.error_every,
                     "not 0: each n-th answer of the memory is an error");
  command.add_flag("!--no-lock-step", rtl.lock_step, "do not compare each hit with the model");
  command.add_flag("!--no-progress", rtl.progress, "no progress bar");
  command.add_flag("!--no-truth", arguments.run.truth,
                   "do not compare with Embree and exact arithmetic");
}

CLI::Option* add_scene(CLI::App& command, Arguments& arguments) {
  command.add_option("--scene", arguments.run.scene, "glTF, OBJ, PLY or .ply.zst")->required();
  return add_choice<ti::Layout>(command, "--layout", arguments.run.layout,
                                {{"odfl", ti::Layout::Odfl}, {"dfl", ti::Layout::Dfl}});
}

void add_run(CLI::App& command, Arguments& arguments) {
  add_config(command, arguments);
  add_engine(command, arguments);
  CLI::Option* layout = add_scene(command, arguments);
  command
      .add_option("--image", arguments.run.image,
                  "memory image of the scene, in place of building one")
      ->excludes(layout);
  command.add_option("--out", arguments.run.out, "folder for what is written")->required();
  command.add_option("--seed", arguments.seed, "of the rays");
  command.add_option("--log-ray", arguments.run.log_ray,
                     "number of a ray whose steps are written, by model and RTL");
  command.add_flag("--dump", arguments.dump, "write the rays and the hits too");
}

int run(int argc, char** argv) {
  Arguments arguments;
  CLI::App app{"Traversal and intersection engine: render, trace, image, hard cases"};
  app.require_subcommand(1);

  CLI::App* render_command =
      app.add_subcommand("render", "trace a picture and write a PNG and a report");
  add_run(*render_command, arguments);
  render_command->add_option("--size", arguments.size, "WIDTHxHEIGHT");
  render_command->add_option("--spp", arguments.spp, "rays a pixel");
  render_command->add_option("--effects", arguments.effects, "none");

  CLI::App* trace_command =
      app.add_subcommand("trace", "trace rays and write hits.npy, prims.npy, report.json");
  add_run(*trace_command, arguments);
  trace_command
      ->add_option("--rays", arguments.rays, "rays.npy, float32 [N,8], or KIND:COUNT to make them")
      ->required();

  CLI::App* image_command =
      app.add_subcommand("image", "build the tree of a scene and write its memory image");
  add_config(*image_command, arguments);
  add_scene(*image_command, arguments);
  image_command->add_option("--out", arguments.run.out, "file to write, .tiim")->required();

  CLI::App* cases_command = app.add_subcommand("hardcases", "trace and judge a file of hard cases");
  add_config(*cases_command, arguments);
  add_engine(*cases_command, arguments);
  cases_command->add_option("--file", arguments.cases_file, "cases, one JSON object a line")
      ->required();

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    fmt::print(stderr, "{}\n", error.what());
    return kBadInput;
  }
  arguments.run.config = ti::load_config(arguments.config_file);
  if (render_command->parsed()) return render(arguments);
  if (trace_command->parsed()) return trace(arguments);
  if (image_command->parsed()) return image(arguments);
  return hardcases(arguments);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Error& error) {
    fmt::print(stderr, "{}\n", error.what());
  } catch (const std::exception& error) {
    fmt::print(stderr, "unexpected: {}\n", error.what());
    return 3;
  }
  return kBadInput;
}
