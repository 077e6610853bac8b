// SPDX-License-Identifier: Apache-2.0
#include "truth/accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <tuple>

#include "accel/prepare.hpp"
#include "accel/scene_scale.hpp"
#include "base/config.hpp"
#include "base/error.hpp"
#include "base/vec.hpp"
#include "cli/picture.hpp"
#include "cli/ray_source.hpp"
#include "cli/traced_run.hpp"
#include "io/file.hpp"
#include "io/png.hpp"
#include "scene/scaling.hpp"
#include "truth/exact_picture.hpp"

namespace ti {
namespace {

using Json = nlohmann::ordered_json;

constexpr Format kGiven{8, 23};  ///< of scenes and rays before they are rounded

/// Steps and tests that a picture may take, of those of the rays of a kind.
constexpr double kPictureWork = 10.0;

/// The value below which a share of the sorted `errors` lie.
double quantile(const std::vector<float>& errors, double share) {
  if (errors.empty()) return 0.0;
  const double last = static_cast<double>(errors.size() - 1);
  return double{errors[static_cast<std::size_t>(share * last + 0.5)]};
}

Json quantiles_of(const std::vector<float>& errors) {
  return {{"median", quantile(errors, 0.5)},
          {"p99_9", quantile(errors, 0.999)},
          {"max", quantile(errors, 1.0)}};
}

/// Where the cracks are in the picture: x, y, and 1 where it is seen.
Json places_json(const std::vector<CrackPlace>& cracks, const ExactPicture& picture, int scale) {
  std::vector<glm::dvec3> points;
  points.reserve(cracks.size());
  for (const CrackPlace& crack : cracks) points.push_back(std::ldexp(1.0, -scale) * crack.point);
  Json places = Json::array();
  for (const ExactPicture::Place& place : picture.places_of(points)) {
    const auto tenths = [](double x) { return std::floor(10.0 * x) / 10.0; };
    places.push_back({tenths(place.x), tenths(place.y), place.seen ? 1 : 0});
  }
  return places;
}

/// Errors were found at 2^scale times the size of the scene.
Json json_of(const std::string& kind, const HitErrors& errors, const ExactPicture& picture,
             int scale) {
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
          {"t_ulp", quantiles_of(errors.t_ulps)},
          {"u_ulp", quantiles_of(errors.u_ulps)},
          {"v_ulp", quantiles_of(errors.v_ulps)},
          {"steps_per_ray", static_cast<double>(errors.work.steps) / rays},
          {"tests_per_ray", static_cast<double>(errors.work.a_tests) / rays},
          {"restarts_per_ray", static_cast<double>(errors.work.restarts) / rays},
          {"crack_places", places_json(errors.crack_places, picture, scale)}};
}

const char* walk_name(const Config& config) {
  return kTraversalNames[static_cast<std::size_t>(config.traversal)];
}

const char* test_name_of(const Config& config) {
  return test_name(test_kind(config.triangle_test));
}

/// What a machine is called, as in the names of its files.
std::string machine_name(const Config& config) {
  return fmt::format("{}-{}-{}-{}", config.format.exp_bits, config.format.frac_bits,
                     test_name_of(config), walk_name(config));
}

std::vector<Config> configs_of(const std::vector<std::string>& files) {
  std::vector<Config> configs;
  std::set<std::string> names;
  for (const std::string& file : files) {
    configs.push_back(load_config(file));
    const Config& first = configs.front();
    const Config& last = configs.back();
    if (std::tie(first.layout, first.tree_test_cost, first.tree_leaf_cost, first.tree_bad_splits) !=
        std::tie(last.layout, last.tree_test_cost, last.tree_leaf_cost, last.tree_bad_splits)) {
      throw Error(
          fmt::format("{}: its tree is not built as that of {}; give the same layout and "
                      "tree_... keys to all",
                      file, files.front()));
    }
    if (!names.insert(machine_name(configs.back())).second) {
      throw Error(
          fmt::format("{}: another configuration has its format, test and walk, {}; give "
                      "each once",
                      file, machine_name(configs.back())));
    }
  }
  return configs;
}

/// Moves a scene by a vector; each coordinate is rounded once.
void move_scene(Scene& scene, const glm::dvec3& by) {
  const auto move = [&by](glm::vec3& place) { place = glm::vec3(glm::dvec3(place) + by); };
  for (glm::vec3& vertex : scene.mesh.vertices) move(vertex);
  move(scene.camera.eye);
  move(scene.camera.target);
}

bool has_usable_triangle(const Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Corners corners = mesh.corners(i);
    if (std::all_of(corners.begin(), corners.end(), [](const glm::vec3& p) { return finite(p); }) &&
        !has_zero_area(corners))
      return true;
  }
  return false;
}

/// The machines of one format on one scene, whose images are built once a test.
struct Machines {
  std::vector<std::unique_ptr<Session>> sessions;
  std::vector<std::string> refused;  ///< why a machine cannot hold the scene; empty for those above
};

Machines machines_of(RunOptions run, const std::vector<Config>& configs, const Scene& scene) {
  std::vector<TestKind> tests;
  for (const Config& config : configs) {
    const TestKind test = test_kind(config.triangle_test);
    if (std::find(tests.begin(), tests.end(), test) == tests.end()) tests.push_back(test);
  }
  Machines machines;
  std::vector<SceneImage> images;
  try {
    run.config = configs.front();
    images = scene_images_of(scene, run, tests);
  } catch (const Error& error) {
    machines.refused.assign(configs.size(), error.what());
    return machines;
  }
  for (const Config& config : configs) {
    run.config = config;
    std::string& why = machines.refused.emplace_back();
    const auto test = std::find(tests.begin(), tests.end(), test_kind(config.triangle_test));
    try {
      auto session = std::make_unique<Session>(
          run, scene, images[static_cast<std::size_t>(test - tests.begin())]);
      session->require_triangles();
      machines.sessions.push_back(std::move(session));
    } catch (const Error& error) {
      why = error.what();
    }
  }
  return machines;
}

/// Counts, writes and prints what becomes of the machines of one format.
class Sweep {
 public:
  Sweep(const Arguments& arguments, const Scene& scene)
      : arguments_(arguments),
        scene_(scene),
        kinds_(kinds_of(arguments.rays)),
        size_(parse_size(arguments.size)),
        given_(scene.mesh, kGiven),
        picture_(scene, given_, size_.width, size_.height) {
    write_file(arguments.run.out / "reference.png",
               png_of(picture_.picture().pixels, size_.width, size_.height));
    fmt::print("{:<22} {:<10} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>12}\n", "per million", "",
               "rays", "missed", "cracks", "false", "wrong", "self", "t p99.9 ulp");
  }

  /// Adds machines of one format and scale. One that cannot hold the scene gets a line that says
  /// why.
  void add(const std::vector<Config>& configs);

  /// The exponent of the power of two by which a machine has the scene.
  [[nodiscard]] int scale_of(const Config& config) const {
    return scene_scale(largest_coordinate(scene_.mesh), config.format,
                       test_kind(config.triangle_test));
  }

 private:
  [[nodiscard]] Json head_of(const Config& config) const;
  [[nodiscard]] std::vector<HitErrors> count(const std::string& kind,
                                             const std::vector<const Tracer*>& models,
                                             const ExactTracer& exact, const Mesh& mesh,
                                             const ScaledFormat& format) const;

  const Arguments& arguments_;
  const Scene& scene_;
  std::vector<std::string> kinds_;
  Size size_;
  ExactTracer given_;
  ExactPicture picture_;
  std::string lines_;
};

Json Sweep::head_of(const Config& config) const {
  return {{"scene", arguments_.run.scene.string()},
          {"move", arguments_.move},
          {"seed", arguments_.seed},
          {"rays", arguments_.rays},
          {"count", arguments_.count},
          {"work", arguments_.work},
          {"size", arguments_.size},
          {"format", ti::name_of(config.format)},
          {"test", test_name_of(config)},
          {"traversal", walk_name(config)},
          {"triangles", scene_.mesh.triangles.size()}};
}

void Sweep::add(const std::vector<Config>& configs) {
  const Format format = configs.front().format;
  const int scale = scale_of(configs.front());
  const ScaledFormat whole(format, scale);
  const ScaledFormat in_engine(format, 0, true);  // rays leave hits as they do for Woop's test
  const Machines machines = machines_of(arguments_.run, configs, scene_);
  std::vector<const Tracer*> models;
  for (const auto& session : machines.sessions) models.push_back(&session->model());

  std::vector<std::vector<HitErrors>> found;  // [kind][model]
  if (!models.empty()) {
    const Mesh mesh = scaled(scene_.mesh, whole);
    std::optional<ExactTracer> own;
    if (!(format == kGiven) || scale != 0) own.emplace(mesh, format);
    const ExactTracer& exact = own ? *own : given_;
    for (const std::string& kind : kinds_)
      found.push_back(count(kind, models, exact, mesh, in_engine));
  }
  std::size_t m = 0;
  for (std::size_t i = 0; i < configs.size(); ++i) {
    Json line = head_of(configs[i]);
    if (!machines.refused[i].empty()) {
      line["refused"] = machines.refused[i];
      fmt::print("{:<22} {}\n", machine_name(configs[i]), machines.refused[i]);
      lines_ += line.dump() + "\n";
      continue;
    }
    const BuildStats& tree = machines.sessions[m]->tree();
    const auto picture = picture_.of(*models[m], whole, kPictureWork * arguments_.work);
    double seconds = 0.0;
    Json points = Json::array();
    for (std::size_t k = 0; k < kinds_.size(); ++k) {
      const HitErrors& errors = found[k][m];
      seconds += errors.seconds;
      points.push_back(json_of(kinds_[k], errors, picture_, scale));
      const double scale = 1e6 / static_cast<double>(std::max<std::uint64_t>(1, errors.rays));
      const auto rate = [scale](std::uint64_t n) { return static_cast<double>(n) * scale; };
      fmt::print("{:<22} {:<10} {:>8} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>12.2f}\n",
                 machine_name(configs[i]), kinds_[k], errors.rays, rate(errors.missed),
                 rate(errors.cracks), rate(errors.false_hits), rate(errors.wrong),
                 rate(errors.self_hits), quantile(errors.t_ulps, 0.999));
    }
    line["scale"] = scale;
    line["dropped"] = tree.dropped_nonfinite + tree.dropped_zero_area;
    line["kinds"] = std::move(points);
    line["picture"] = nullptr;
    if (picture) {
      const std::string file = machine_name(configs[i]) + ".png";
      write_file(arguments_.run.out / file, png_of(picture->pixels, size_.width, size_.height));
      line["picture"] = {{"file", file}, {"wrong_pixels", picture->wrong}};
    }
    line["model_seconds"] = seconds;
    lines_ += line.dump() + "\n";
    ++m;
  }
  write_file(arguments_.run.out / "points.jsonl", lines_);
  std::fflush(stdout);
}

std::vector<HitErrors> Sweep::count(const std::string& kind,
                                    const std::vector<const Tracer*>& models,
                                    const ExactTracer& exact, const Mesh& mesh,
                                    const ScaledFormat& format) const {
  const auto at = std::find(kAimNames.begin(), kAimNames.end(), kind);
  const bool secondary = at == kAimNames.end();
  const AimedRays rays(mesh, secondary ? Aim::Uniform : static_cast<Aim>(at - kAimNames.begin()),
                       arguments_.seed);
  const MostRays most(arguments_.count, arguments_.work);
  if (!secondary) return hit_errors(models, exact, mesh, format.numbers, rays, most);
  return secondary_errors(models, exact, mesh, format, rays, most, arguments_.seed);
}

}  // namespace

int accuracy(Arguments& arguments) {
  check_folder(arguments.run.out);
  arguments.run.engine = EngineKind::Model;
  arguments.run.truth = false;
  const std::vector<Config> configs = configs_of(arguments.config_files);
  Scene scene = load(arguments);
  if (scene.mesh.triangles.empty()) {
    throw Error(fmt::format("{}: it has no triangle, so there is nothing to aim at",
                            arguments.run.scene.string()));
  }
  if (!arguments.move.empty())
    move_scene(scene, {arguments.move[0], arguments.move[1], arguments.move[2]});
  if (!has_usable_triangle(scene.mesh)) {
    throw Error(
        fmt::format("{}: none of its {} triangles has an area and finite vertices; "
                    "correct the mesh, or move it less",
                    arguments.run.scene.string(), scene.mesh.triangles.size()));
  }
  Sweep sweep(arguments, scene);
  std::vector<std::vector<Config>> groups;
  for (const Config& config : configs) {
    const auto same = [&](const auto& group) {
      return group[0].format == config.format && sweep.scale_of(group[0]) == sweep.scale_of(config);
    };
    const auto group = std::find_if(groups.begin(), groups.end(), same);
    if (group == groups.end()) {
      groups.push_back({config});
    } else {
      group->push_back(config);
    }
  }
  for (const auto& group : groups) {
    if (*arguments.run.stop) return kInterrupted;
    sweep.add(group);
  }
  fmt::print("{}\n", (arguments.run.out / "points.jsonl").string());
  return kGood;
}

}  // namespace ti
