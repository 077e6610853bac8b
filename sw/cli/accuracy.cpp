// SPDX-License-Identifier: Apache-2.0
#include "truth/accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "cli/traced_run.hpp"
#include "io/file.hpp"
#include "scene/scaling.hpp"

namespace ti {
namespace {

using Json = nlohmann::ordered_json;

/// The value below which a share of the sorted `errors` lie.
double quantile(const std::vector<float>& errors, double share) {
  if (errors.empty()) return 0.0;
  const double last = static_cast<double>(errors.size() - 1);
  return double{errors[static_cast<std::size_t>(share * last + 0.5)]};
}

Json json_of(const std::string& kind, const HitErrors& errors) {
  const double rays = static_cast<double>(std::max<std::uint64_t>(1, errors.rays));
  return {{"rays", kind},
          {"count", errors.rays},
          {"exact_hits", errors.exact_hits},
          {"missed", errors.missed},
          {"through", errors.through},
          {"cracks", errors.cracks},
          {"false_hits", errors.false_hits},
          {"wrong_triangle", errors.wrong},
          {"self_hits", errors.self_hits},
          {"failed", errors.failed},
          {"t_ulp",
           {{"median", quantile(errors.t_ulps, 0.5)},
            {"p99_9", quantile(errors.t_ulps, 0.999)},
            {"max", quantile(errors.t_ulps, 1.0)}}},
          {"steps_per_ray", static_cast<double>(errors.work.steps) / rays},
          {"tests_per_ray", static_cast<double>(errors.work.a_tests) / rays},
          {"restarts_per_ray", static_cast<double>(errors.work.restarts) / rays}};
}

/// The kinds that `text` names.
std::vector<std::string> kinds_of(const std::string& text) {
  std::istringstream words(text);
  std::vector<std::string> kinds;
  for (std::string kind; words >> kind;) {
    const bool known = kind == "secondary" ||
                       std::find(kAimNames.begin(), kAimNames.end(), kind) != kAimNames.end();
    if (!known) {
      throw Error(fmt::format("RAYS={}: there is no kind `{}` of rays; the kinds are {}, secondary",
                              text, kind, fmt::join(kAimNames, ", ")));
    }
    kinds.push_back(kind);
  }
  if (kinds.empty()) throw Error("RAYS=: give kinds of rays, such as edges vertices");
  return kinds;
}

}  // namespace

int accuracy(Arguments& arguments) {
  const std::vector<std::string> kinds = kinds_of(arguments.rays);
  const std::filesystem::path& file = arguments.run.out;
  check_folder(file.parent_path());
  arguments.run.engine = EngineKind::Model;
  arguments.run.truth = false;
  const Session session(arguments.run, load(arguments));
  session.require_triangles();
  if (session.image().parts().triangle_count == 0) {
    throw Error(fmt::format("{}: it has no triangle, so there is nothing to aim at",
                            arguments.run.scene.string()));
  }
  // All is done in the space of the engine.
  const Mesh mesh = scaled(session.scene().mesh, session.format());
  const Format& format = arguments.run.config.format;
  const ScaledFormat in_engine(format, 0, session.format().by_area);
  const ExactTracer exact(mesh, format);
  Json points = Json::array();
  fmt::print("{:<10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>12}\n", "per million", "rays",
             "missed", "cracks", "false", "wrong", "self", "t p99.9 ulp");
  for (const std::string& kind : kinds) {
    const auto at = std::find(kAimNames.begin(), kAimNames.end(), kind);
    const bool secondary = at == kAimNames.end();
    const auto aim = secondary ? Aim::Uniform : static_cast<Aim>(at - kAimNames.begin());
    const AimedRays rays(mesh, aim, arguments.seed);
    const HitErrors errors =
        secondary ? secondary_errors(session.model(), exact, mesh, in_engine, rays, arguments.count,
                                     arguments.seed)
                  : hit_errors(session.model(), exact, mesh, format, rays, arguments.count);
    const double scale = 1e6 / static_cast<double>(std::max<std::uint64_t>(1, errors.rays));
    const auto rate = [scale](std::uint64_t n) { return static_cast<double>(n) * scale; };
    fmt::print("{:<11} {:>10} {:>10.1f} {:>10.1f} {:>10.1f} {:>10.1f} {:>10.1f} {:>12.2f}\n", kind,
               errors.rays, rate(errors.missed), rate(errors.cracks), rate(errors.false_hits),
               rate(errors.wrong), rate(errors.self_hits), quantile(errors.t_ulps, 0.999));
    points.push_back(json_of(kind, errors));
  }
  const Json out{{"scene", arguments.run.scene.string()},
                 {"seed", arguments.seed},
                 {"format", name_of(format)},
                 {"scale", session.format().scale},
                 {"points", points}};
  write_file(file, out.dump(1) + "\n");
  fmt::print("{}\n", file.string());
  return kGood;
}

}  // namespace ti
