// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include "base/error.hpp"
#include "cli/ray_source.hpp"
#include "cli/traced_run.hpp"
#include "io/file.hpp"
#include "io/npy.hpp"

namespace ti {

int trace(Arguments& arguments) {
  const RaySource source = parse_ray_source(arguments.rays);
  check_folder(arguments.run.out);
  std::vector<Ray> rays;
  if (!source.file.empty()) {
    rays = load_rays(source.file);
    if (rays.empty())
      throw Error(fmt::format("{}: the array holds no ray; give one ray a row", source.file));
  }
  arguments.run.tests = arguments.dump;
  Progress progress(source.file.empty() ? source.count : rays.size());
  Session session = start(arguments, progress);
  if (source.file.empty()) {
    rays = make_rays(source, session.scene(), session.model(), session.format(), arguments.seed);
  }
  Report report{
      .request = {.command = "trace", .rays = arguments.rays, .size = {}, .seed = arguments.seed},
      .total = {},
      .waves = {}};
  check_log_ray(session, rays.size());
  trace_waves(session, rays, arguments.waves, report);
  Files files(arguments);
  files.add_dump(arguments, rays, report.total, true);
  return finish(report, session, files);
}

}  // namespace ti
