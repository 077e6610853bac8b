// SPDX-License-Identifier: Apache-2.0
//
// The commands of `ti`; each gives its exit status and throws `Error` for bad input.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/session.hpp"

namespace ti {

constexpr int kGood = 0;
constexpr int kChecksFailed = 1;
constexpr int kBadInput = 2;
constexpr int kInterrupted = 130;

struct Arguments {
  std::string config_file;
  std::vector<std::string> config_files;  ///< of accuracy, in place of the one
  std::vector<double> move;               ///< of accuracy: 3 numbers, or none
  RunOptions run;
  std::string size = "256x256";
  std::string effects = "auto";
  std::string rays;
  std::string cases_file;
  std::string formats = "5,10 8,13 7,16 8,20 8,23";  ///< of the ladder
  std::string tests = "np local woop";
  std::string ladder_rays = "uniform edges vertices grazing far secondary";
  std::optional<int> case_number;  ///< of hard cases: that one alone, with its steps
  std::string base_file;           ///< configuration that a machine was planned on; empty: none was
  std::filesystem::path keys;      ///< of machine: file for them; empty: render
  std::uint64_t count = 100000;    ///< of accuracy and ladder: rays of each kind; of faults: images
  std::uint64_t first = 0;         ///< of faults: number of the first image
  double work = 1e8;               ///< of accuracy: steps and tests for rays of a kind in a format
  int spp = 1;
  int bounces = 4;
  std::string frames;  ///< of an animation; empty: a picture
  double fps = 24.0;   ///< frames a second of a node animation
  std::uint64_t seed = 1;
  int waves = 1;
  bool dump = false;
  bool progress = true;
};

int render(Arguments& arguments);
int trace(Arguments& arguments);
int image(Arguments& arguments);
/// Hits of models against exact ones, for rays of several kinds, and pictures; JSON lines and PNGs
/// in the folder `arguments.run.out`.
int accuracy(Arguments& arguments);
int hardcases(const Arguments& arguments);
/// All hard cases and kinds of rays on the model of each format and test; a table and JSON lines in
/// the folder `arguments.run.out`.
int ladder(const Arguments& arguments);
/// Rays on many damaged copies of the scene's image, on the model or on RTL and model; a table and
/// `faults.json` in the folder `arguments.run.out`.
int faults(Arguments& arguments);
/// The keys that a picture calls for, as `SET=` has them, in the file `arguments.run.out`.
int machine(Arguments& arguments);

/// From now on the first SIGINT stops the run of `arguments`; the second ends the program at once.
void stop_at_interrupt(Arguments& arguments);

}  // namespace ti
