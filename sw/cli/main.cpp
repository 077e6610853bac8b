// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "base/error.hpp"
#include "cli/commands.hpp"

namespace {

using ti::Arguments;
using ti::EngineKind;
using ti::Error;

/// An option whose value is one of a few words.
template <typename T>
void add_choice(CLI::App& command, const std::string& name, T& target,
                const std::map<std::string, T>& choices) {
  std::string words;
  for (const auto& [word, value] : choices) words += (words.empty() ? "" : ", ") + word;
  const auto choose = [name, &target, choices, words](const std::string& word) {
    const auto found = choices.find(word);
    if (found == choices.end())
      throw Error(fmt::format("{} {}: no such choice; there are {}", name, word, words));
    target = found->second;
  };
  command.add_option_function<std::string>(name, choose, words);
}

void add_config(CLI::App& command, Arguments& arguments) {
  command.add_option("--config", arguments.config_file, "config.json of the configuration")
      ->required();
}

void add_engine(CLI::App& command, Arguments& arguments) {
  add_choice<EngineKind>(command, "--engine", arguments.run.engine,
                         {{"rtl", EngineKind::Rtl},
                          {"model", EngineKind::Model},
                          {"embree", EngineKind::Embree},
                          {"board", EngineKind::Board}});
  ti::RtlOptions& rtl = arguments.run.rtl;
  command.add_option_function<std::string>(
      "--mem", [&rtl](const std::string& name) { rtl.memory = ti::memory_kind(name); },
      "ideal, fixed, dram");
  command.add_option("--mem-latency", rtl.memory_latency, "of a fixed one: cycles to the answer")
      ->check(CLI::Range(1, 1000000));
  command.add_option("--mem-bytes-per-cycle", rtl.memory_bytes_per_cycle, "its bandwidth")
      ->check(CLI::Range(0.001, 1e6));
  command.callback([&command, &rtl] {
    if (rtl.memory != ti::MemoryKind::Fixed &&
        command.count("--mem-latency") + command.count("--mem-bytes-per-cycle") != 0)
      throw Error("--mem-latency and --mem-bytes-per-cycle are of --mem fixed alone");
  });
  command.add_option("--stall-seed", rtl.stall_seed,
                     "not 0: random stalls on every port of the engine");
  command.add_option("--stall-share", rtl.stall_share, "share of the cycles with a stall")
      ->check(CLI::Range(0.0, 0.99));
  command.add_option("--error-every", rtl.error_every,
                     "not 0: each n-th answer of the memory is an error");
  command.add_option("--lose-every", rtl.lose_every, "not 0: each n-th never comes");
  command.add_option("--late-every", rtl.late_every, "not 0: each n-th comes after its time-out");
  command.add_option("--spoil-every", rtl.spoil_every, "not 0: each n-th has a wrong bit");
  command.add_option("--rtl", arguments.run.library, "library of the RTL that `make engine` built");
  command.add_option("--board", arguments.run.board, "of --engine board: where its devices are");
  command.add_flag("!--no-lock-step", arguments.run.lock_step,
                   "do not compare each hit with the model");
  command.add_flag("!--no-progress", arguments.progress, "no progress bar");
  command.add_flag("!--no-truth", arguments.run.truth,
                   "do not compare with Embree and exact arithmetic");
}

void add_scene(CLI::App& command, Arguments& arguments) {
  command.add_option("--scene", arguments.run.scene, "glTF, OBJ, PLY or .ply.zst")->required();
}

void add_run(CLI::App& command, Arguments& arguments) {
  add_config(command, arguments);
  add_engine(command, arguments);
  add_scene(command, arguments);
  command.add_option("--image", arguments.run.image,
                     "memory image of the scene, in place of building one");
  command.add_option("--out", arguments.run.out, "folder for what is written")->required();
  command.add_option("--seed", arguments.seed, "of the rays");
  command.add_option("--log-ray", arguments.run.log_ray,
                     "number of a ray whose steps are written, by model and RTL");
  command.add_option("--waves", arguments.waves, "number of parts in which the rays are traced")
      ->check(CLI::Range(1, 1000000));
  command.add_flag("--dump", arguments.dump,
                   "write rays, hits, and each ray's steps and tests too");
}

void add_picture(CLI::App& command, Arguments& arguments) {
  command.add_option("--size", arguments.size, "WIDTHxHEIGHT");
  command.add_option("--spp", arguments.spp, "rays a pixel");
  command.add_option("--effects", arguments.effects,
                     "auto, all, none, then effects with + or -; or one effect");
  command.add_option("--bounces", arguments.bounces, "scatterings of a path at most");
  command.add_option("--frames", arguments.frames,
                     "A:B of an animation, B left out; or one number");
  command.add_option("--fps", arguments.fps, "frames a second of a node animation");
}

int run(int argc, char** argv) {
  Arguments arguments;
  CLI::App app{"Traversal and intersection engine: render, trace, image, hard cases"};
  app.require_subcommand(1);

  CLI::App* render_command =
      app.add_subcommand("render", "trace a picture and write a PNG and a report");
  add_run(*render_command, arguments);
  add_picture(*render_command, arguments);
  render_command->add_option("--base", arguments.base_file,
                             "config.json of the configuration that the machine was planned on");

  CLI::App* machine_command =
      app.add_subcommand("machine", "write the keys of the machine that a picture calls for");
  add_run(*machine_command, arguments);
  add_picture(*machine_command, arguments);

  CLI::App* trace_command =
      app.add_subcommand("trace", "trace rays and write hits.npy, prims.npy, report.json");
  add_run(*trace_command, arguments);
  trace_command
      ->add_option("--rays", arguments.rays, "rays.npy, float32 [N,8], or KIND:COUNT to make them")
      ->required();

  trace_command->add_option("--waves-file", arguments.run.rtl.waves_file,
                            "FST for every signal of the RTL");

  CLI::App* image_command =
      app.add_subcommand("image", "build the tree of a scene and write its memory image");
  add_config(*image_command, arguments);
  add_scene(*image_command, arguments);
  image_command->add_option("--out", arguments.run.out, "file to write, .tiim")->required();

  CLI::App* accuracy_command = app.add_subcommand(
      "accuracy", "count wrong hits of models by exact arithmetic; write JSON lines and pictures");
  accuracy_command
      ->add_option("--config", arguments.config_files,
                   "config.json of a machine; repeat for more, which share what is exact")
      ->required();
  add_scene(*accuracy_command, arguments);
  accuracy_command
      ->add_option("--move", arguments.move, "X,Y,Z: where the origin of the scene is moved to")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Range(-3e38, 3e38));
  accuracy_command->add_option("--size", arguments.size, "of the picture, WIDTHxHEIGHT");
  accuracy_command->add_option("--rays", arguments.rays, "kinds of rays, with spaces between")
      ->required();
  accuracy_command->add_option("--count", arguments.count, "rays of each kind")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40));
  accuracy_command
      ->add_option("--work", arguments.work,
                   "steps and tests for the rays of a kind in a format at most; then fewer rays")
      ->check(CLI::Range(1.0, 1e18));
  accuracy_command->add_option("--seed", arguments.seed, "of the rays");
  accuracy_command->add_option("--out", arguments.run.out, "folder for what is written")
      ->required();

  CLI::App* cases_command = app.add_subcommand("hardcases", "trace and judge a file of hard cases");
  add_config(*cases_command, arguments);
  add_engine(*cases_command, arguments);
  cases_command->add_option("--file", arguments.cases_file, "cases, one JSON object a line")
      ->required();
  CLI::Option* one = cases_command->add_option("--id", arguments.case_number,
                                               "number of one case, whose steps are written too");
  one->needs(cases_command->add_option("--out", arguments.run.out, "folder for the steps"));
  cases_command
      ->add_option("--waves-file", arguments.run.rtl.waves_file,
                   "FST for every signal of the RTL in that case")
      ->needs(one);

  CLI::App* ladder_command = app.add_subcommand(
      "ladder", "judge hard cases and rays in volume on the models of formats and tests");
  add_config(*ladder_command, arguments);
  add_scene(*ladder_command, arguments);
  ladder_command->add_option("--file", arguments.cases_file, "cases, one JSON object a line")
      ->required();
  ladder_command->add_option("--formats", arguments.formats, "E,M of each, with spaces between");
  ladder_command->add_option("--tests", arguments.tests, "of local, np, woop");
  ladder_command->add_option("--rays", arguments.ladder_rays, "kinds of rays, with spaces between");
  ladder_command->add_option("--count", arguments.count, "rays of each kind; 0: none")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 40));
  ladder_command->add_option("--seed", arguments.seed, "of the rays");
  ladder_command->add_option("--out", arguments.run.out, "folder for the table")->required();

  CLI::App* faults_command =
      app.add_subcommand("faults", "trace rays on damaged copies of a scene's memory image");
  add_config(*faults_command, arguments);
  add_engine(*faults_command, arguments);
  add_scene(*faults_command, arguments);
  faults_command->add_option("--rays", arguments.rays, "KIND:COUNT of each image")->required();
  faults_command->add_option("--images", arguments.count, "number of damaged images")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40));
  faults_command->add_option("--first", arguments.first, "number of the first one");
  faults_command->add_option("--seed", arguments.seed, "of faults and rays");
  faults_command->add_option("--out", arguments.run.out, "folder for the report")->required();

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    fmt::print(stderr, "{}\n", error.what());
    return ti::kBadInput;
  }
  ti::stop_at_interrupt(arguments);
  if (accuracy_command->parsed()) return ti::accuracy(arguments);
  arguments.run.config = ti::load_config(arguments.config_file);
  if (machine_command->parsed()) return ti::machine(arguments);
  if (render_command->parsed()) return ti::render(arguments);
  if (trace_command->parsed()) return ti::trace(arguments);
  if (image_command->parsed()) return ti::image(arguments);
  if (ladder_command->parsed()) return ti::ladder(arguments);
  if (faults_command->parsed()) return ti::faults(arguments);
  return ti::hardcases(arguments);
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
  return ti::kBadInput;
}
