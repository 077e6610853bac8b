// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "cli/hardcases.hpp"
#include "cli/progress.hpp"
#include "cli/ray_source.hpp"
#include "cli/summary.hpp"
#include "engine/session.hpp"
#include "io/file.hpp"
#include "io/npy.hpp"
#include "io/png.hpp"
#include "render/heat_map.hpp"
#include "render/shade.hpp"
#include "report/report.hpp"
#include "scene/rays.hpp"

namespace {

using ti::EngineKind;
using ti::Error;

constexpr int kGood = 0;
constexpr int kChecksFailed = 1;
constexpr int kBadInput = 2;
constexpr int kInterrupted = 130;

struct Arguments {
  std::string config_file;
  ti::RunOptions run;
  std::string size = "256x256";
  std::string effects = "none";
  std::string rays;
  std::string cases_file;
  int spp = 1;
  std::uint64_t seed = 1;
  int waves = 1;
  bool dump = false;
  bool progress = true;
};

struct Size {
  int width, height;
};

Size parse_size(const std::string& text) {
  int width = 0;
  int height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 1 ||
      height < 1 || width > ti::kMaxSide || height > ti::kMaxSide) {
    throw Error(
        fmt::format("SIZE={}: give a size as WIDTHxHEIGHT, each from 1 to {}, such as 256x256",
                    text, ti::kMaxSide));
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

/// Set by the first SIGINT; the second ends the program at once.
std::atomic<bool> interrupted{false};

void stop_at_interrupt(Arguments& arguments) {
  std::signal(SIGINT, [](int) {
    interrupted = true;
    std::signal(SIGINT, SIG_DFL);
  });
  arguments.run.stop = &interrupted;
}

/// The files of a run in its folder; the report is the last.
class Files {
 public:
  explicit Files(const Arguments& arguments) : folder_(arguments.run.out) {}

  void add(const std::string& name, std::string bytes) {
    files_.emplace_back(name, std::move(bytes));
  }
  void add_dump(const Arguments& arguments, std::span<const ti::Ray> rays, const ti::Wave& wave,
                bool hits) {
    if (arguments.dump) add("rays.npy", ti::rays_npy(rays.first(wave.hits.size())));
    if (arguments.dump || hits) {
      add("hits.npy", ti::hits_npy(wave.hits));
      add("prims.npy", ti::prims_npy(wave.hits));
    }
    if (!arguments.dump || arguments.run.engine == EngineKind::Embree) return;
    add("steps.npy", ti::steps_npy(wave.hits));
    add("tests.npy", ti::tests_npy(wave.tests));
  }
  void write() const {
    std::vector<std::pair<std::filesystem::path, std::string_view>> files;
    std::string names;
    for (const auto& [name, bytes] : files_) {
      files.emplace_back(folder_ / name, bytes);
      names += (names.empty() ? "" : ", ") + name;
    }
    ti::write_files(files);
    fmt::print("{}: {}\n", folder_.string(), names);
  }

 private:
  std::filesystem::path folder_;
  std::vector<std::pair<std::string, std::string>> files_;
};

/// A session with the progress of the engine on the terminal.
ti::Session start(Arguments& arguments, ti::Progress& progress) {
  if (arguments.progress) {
    arguments.run.rtl.progress = [&progress](std::uint64_t rays, std::uint64_t cycles) {
      progress.update(rays, cycles);
    };
  }
  ti::Session session(arguments.run, load(arguments));
  session.require_triangles();
  print_tree(session);
  return session;
}

/// Traces rays in the waves that were asked for.
void trace_waves(ti::Session& session, std::span<const ti::Ray> rays, int waves,
                 ti::Report& report) {
  const auto count = static_cast<std::size_t>(waves);
  for (std::size_t i = 0; i < count && !report.total.stopped; ++i) {
    const std::size_t begin = rays.size() * i / count;
    const std::size_t end = rays.size() * (i + 1) / count;
    report.add(session.trace(rays.subspan(begin, end - begin)));
  }
}

int finish(const ti::Report& report, const ti::Session& session, Files& files) {
  files.add("report.json", ti::to_json(report, session));
  ti::print_summary(report, session);
  files.write();
  if (report.total.stopped) {
    fmt::print("interrupted: what is written is of the first {} rays\n", report.total.hits.size());
    return kInterrupted;
  }
  return report.total.good() ? kGood : kChecksFailed;
}

/// Adds a picture of a count a pixel.
void add_heat_map(Files& files, const char* what, const std::vector<std::uint64_t>& per_pixel,
                  int spp, const Size& size) {
  ti::HeatMap map = ti::heat_map(per_pixel, spp, size.width, size.height);
  fmt::print("{0}.png: {0} a ray, from 0 (dark) to {1:.0f} and more (bright)\n", what, map.top);
  files.add(fmt::format("{}.png", what), std::move(map.png));
}

int render(Arguments& arguments) {
  const Size size = parse_size(arguments.size);
  ti::check_folder(arguments.run.out);
  if (arguments.effects != "none") {
    throw Error(fmt::format("EFFECTS={}: only EFFECTS=none (primary rays) is there so far",
                            arguments.effects));
  }
  if (arguments.spp < 1 || arguments.spp > 4096)
    throw Error(fmt::format("SPP={}: give 1 to 4096", arguments.spp));
  ti::check_ray_count(
      fmt::format("SIZE={} SPP={}", arguments.size, arguments.spp),
      static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height),
      static_cast<std::uint64_t>(arguments.spp));
  arguments.run.tests = true;
  const std::size_t pixel_count =
      static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  ti::Progress progress(pixel_count * static_cast<std::size_t>(arguments.spp));
  ti::Session session = start(arguments, progress);
  const auto primary = ti::primary_rays(session.scene().camera, size.width, size.height,
                                        arguments.spp, arguments.seed);
  ti::Report report{.request = {.command = "render",
                                .rays = {},
                                .size = {{size.width, size.height}},
                                .spp = arguments.spp,
                                .effects = arguments.effects,
                                .seed = arguments.seed},
                    .total = {},
                    .waves = {}};
  trace_waves(session, primary.rays, arguments.waves, report);

  const ti::Wave& wave = report.total;
  const auto rays = std::span(primary.rays).first(wave.hits.size());
  const auto colours = ti::shade(session.scene(), rays, wave.hits);
  std::vector<glm::vec3> pixels(pixel_count);
  std::vector<std::uint64_t> steps(pixel_count);
  std::vector<std::uint64_t> tests(pixel_count);
  for (std::size_t i = 0; i < colours.size(); ++i) {
    pixels[primary.index[i]] += colours[i] / static_cast<float>(arguments.spp);
    steps[primary.index[i]] += wave.hits[i].steps;
    if (!wave.tests.empty()) tests[primary.index[i]] += wave.tests[i];
  }
  Files files(arguments);
  files.add("image.png", ti::png_of(pixels, size.width, size.height));
  if (arguments.run.engine != EngineKind::Embree) {
    add_heat_map(files, "steps", steps, arguments.spp, size);
    add_heat_map(files, "tests", tests, arguments.spp, size);
  }
  files.add_dump(arguments, primary.rays, wave, false);
  return finish(report, session, files);
}

int trace(Arguments& arguments) {
  const ti::RaySource source = ti::parse_ray_source(arguments.rays);
  ti::check_folder(arguments.run.out);
  std::vector<ti::Ray> rays;
  if (!source.file.empty()) {
    rays = ti::load_rays(source.file);
    if (rays.empty())
      throw Error(fmt::format("{}: the array holds no ray; give one ray a row", source.file));
  }
  arguments.run.tests = arguments.dump;
  ti::Progress progress(source.file.empty() ? source.count : rays.size());
  ti::Session session = start(arguments, progress);
  if (source.file.empty()) {
    rays = ti::make_rays(source, session.scene(), session.model(), arguments.run.config.format,
                         arguments.seed);
  }
  if (arguments.run.log_ray && *arguments.run.log_ray >= rays.size()) {
    throw Error(fmt::format("LOG_RAY={}: there are {} rays, numbered from 0",
                            *arguments.run.log_ray, rays.size()));
  }
  ti::Report report{
      .request = {.command = "trace", .rays = arguments.rays, .size = {}, .seed = arguments.seed},
      .total = {},
      .waves = {}};
  trace_waves(session, rays, arguments.waves, report);
  Files files(arguments);
  files.add_dump(arguments, rays, report.total, true);
  return finish(report, session, files);
}

int image(Arguments& arguments) {
  const std::filesystem::path& file = arguments.run.out;
  ti::check_folder(file.parent_path());
  arguments.run.engine = EngineKind::Model;
  arguments.run.truth = false;
  const ti::Session session(arguments.run, load(arguments));
  session.require_triangles();
  print_tree(session);
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
    ti::RunOptions options = arguments.run;
    options.truth = false;
    ti::Scene scene;
    scene.mesh = mesh;
    const ti::Wave wave = ti::Session(options, std::move(scene)).trace(std::span(&ray, 1));
    mismatches += wave.lock_step.mismatches + wave.counts.lost + wave.counts.duplicated +
                  (wave.lock_step.work_differs ? 1 : 0);
    return wave.hits.front();
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
  command.add_option("--rtl", arguments.run.library, "library of the RTL that `make engine` built");
  command.add_flag("!--no-lock-step", arguments.run.lock_step,
                   "do not compare each hit with the model");
  command.add_flag("!--no-progress", arguments.progress, "no progress bar");
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
  command.add_option("--waves", arguments.waves, "number of parts in which the rays are traced")
      ->check(CLI::Range(1, 1000000));
  command.add_flag("--dump", arguments.dump,
                   "write rays, hits, and each ray's steps and tests too");
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
  stop_at_interrupt(arguments);
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
