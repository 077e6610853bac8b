// SPDX-License-Identifier: Apache-2.0
#include "cli/traced_run.hpp"

#include <fmt/core.h>

#include <atomic>
#include <csignal>

#include "base/error.hpp"
#include "cli/summary.hpp"
#include "io/file.hpp"
#include "io/npy.hpp"

namespace ti {
namespace {

/// Set by the first SIGINT.
std::atomic<bool> interrupted{false};

}  // namespace

void stop_at_interrupt(Arguments& arguments) {
  std::signal(SIGINT, [](int) {
    interrupted = true;
    std::signal(SIGINT, SIG_DFL);
  });
  arguments.run.stop = &interrupted;
}

Scene load(const Arguments& arguments) {
  Scene scene = load_scene(arguments.run.scene);
  if (scene.mesh.triangles.empty()) {
    scene.warnings.push_back(
        fmt::format("{} has no triangle: every ray misses", arguments.run.scene.string()));
  }
  return scene;
}

void Files::add_dump(const Arguments& arguments, std::span<const Ray> rays, const Wave& wave,
                     bool hits) {
  if (arguments.dump) add("rays.npy", rays_npy(rays.first(wave.hits.size())));
  if (arguments.dump || hits) {
    add("hits.npy", hits_npy(wave.hits));
    add("prims.npy", prims_npy(wave.hits));
  }
  if (!arguments.dump || arguments.run.engine == EngineKind::Embree) return;
  add("steps.npy", steps_npy(wave.hits));
  add("tests.npy", tests_npy(wave.tests));
}

void Files::write() const {
  std::vector<std::pair<std::filesystem::path, std::string_view>> files;
  std::string names;
  for (const auto& [name, bytes] : files_) {
    files.emplace_back(folder_ / name, bytes);
    names += (names.empty() ? "" : ", ") + name;
  }
  write_files(files);
  fmt::print("{}: {}\n", folder_.string(), names);
}

Session start(Arguments& arguments, Progress& progress) {
  if (arguments.progress) {
    arguments.run.rtl.progress = [&progress](std::uint64_t rays, std::uint64_t cycles) {
      progress.update(rays, cycles);
    };
  }
  Session session(arguments.run, load(arguments));
  session.require_triangles();
  if (arguments.keys.empty()) print_tree(session);
  return session;
}

void check_log_ray(const Session& session, std::size_t rays) {
  const auto& log_ray = session.options().log_ray;
  if (log_ray && *log_ray >= rays)
    throw Error(fmt::format("LOG_RAY={}: there are {} rays, numbered from 0", *log_ray, rays));
}

void trace_waves(Session& session, std::span<const Ray> rays, int waves, Report& report) {
  const auto count = static_cast<std::size_t>(waves);
  for (std::size_t i = 0; i < count && !report.total.stopped; ++i) {
    const std::size_t begin = rays.size() * i / count;
    const std::size_t end = rays.size() * (i + 1) / count;
    report.add(session.trace(rays.subspan(begin, end - begin)));
  }
}

int finish(const Report& report, const Session& session, Files& files) {
  files.add("report.json", to_json(report, session));
  print_summary(report, session);
  files.write();
  if (report.total.stopped) {
    fmt::print("interrupted: what is written is of the first {} rays\n", report.total.hits.size());
    return kInterrupted;
  }
  return report.total.good() ? kGood : kChecksFailed;
}

}  // namespace ti
