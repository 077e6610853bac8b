// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include "cli/commands.hpp"
#include "cli/hardcases.hpp"

namespace ti {

int hardcases(const Arguments& arguments) {
  const auto cases = load_hardcases(arguments.cases_file);
  const Config& config = arguments.run.config;
  std::uint64_t mismatches = 0;
  const auto one = [&](const Mesh& mesh, const Ray& ray) {
    RunOptions options = arguments.run;
    options.truth = false;
    Scene scene;
    scene.mesh = mesh;
    const Wave wave = Session(options, std::move(scene)).trace(std::span(&ray, 1));
    mismatches += wave.lock_step.mismatches + wave.counts.lost + wave.counts.duplicated +
                  (wave.lock_step.work_differs ? 1 : 0);
    return wave.hits.front();
  };
  const int failures = run_hardcases(cases, one, config.format);
  if (arguments.run.engine == EngineKind::Rtl)
    fmt::print("{} mismatches between RTL and model\n", mismatches);
  return failures == 0 && mismatches == 0 ? kGood : kChecksFailed;
}

}  // namespace ti
