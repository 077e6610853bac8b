// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <filesystem>

#include "base/error.hpp"
#include "cli/commands.hpp"
#include "cli/hardcases.hpp"
#include "io/file.hpp"

namespace ti {

int hardcases(const Arguments& arguments) {
  auto cases = load_hardcases(arguments.cases_file);
  if (arguments.case_number) {
    const int wanted = *arguments.case_number;
    std::erase_if(cases, [wanted](const HardCase& c) { return c.n != wanted; });
    if (cases.empty())
      throw Error(
          fmt::format("ID={}: {} has no case of that number", wanted, arguments.cases_file));
    if (cases.size() > 1) {
      throw Error(fmt::format("ID={}: {} has {} cases of that number; give a file with one", wanted,
                              arguments.cases_file, cases.size()));
    }
    check_folder(arguments.run.out);
    std::filesystem::create_directories(arguments.run.out);
  }
  const Config& config = arguments.run.config;
  std::uint64_t mismatches = 0;
  const auto one = [&](const Mesh& mesh, const Ray& ray) {
    RunOptions options = arguments.run;
    options.truth = false;
    if (arguments.case_number) options.log_ray = 0;
    Scene scene;
    scene.mesh = mesh;
    const Wave wave = Session(options, std::move(scene)).trace(std::span(&ray, 1));
    mismatches += wave.lock_step.mismatches + wave.counts.lost + wave.counts.duplicated +
                  (wave.lock_step.work_differs ? 1 : 0);
    return wave.hits.front();
  };
  const int failures = run_hardcases(cases, one, config.format, test_kind(config.triangle_test));
  if (arguments.run.engine == EngineKind::Rtl)
    fmt::print("{} mismatches between RTL and model\n", mismatches);
  if (arguments.case_number)
    fmt::print("steps: {}/ray-0.model.log{}\n", arguments.run.out.string(),
               arguments.run.engine == EngineKind::Rtl ? ", ray-0.rtl.log" : "");
  return failures == 0 && mismatches == 0 ? kGood : kChecksFailed;
}

}  // namespace ti
