// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "cli/progress.hpp"
#include "report/report.hpp"

namespace ti {

/// The scene of the arguments, with a warning when it is empty.
[[nodiscard]] Scene load(const Arguments& arguments);

/// The files of a run in its folder; the report is the last.
class Files {
 public:
  explicit Files(const Arguments& arguments) : folder_(arguments.run.out) {}

  void add(const std::string& name, std::string bytes) {
    files_.emplace_back(name, std::move(bytes));
  }
  /// The arrays that were asked for; hits and prims in any case when `hits`.
  void add_dump(const Arguments& arguments, std::span<const Ray> rays, const Wave& wave, bool hits);
  /// Writes all and prints their names.
  void write() const;

 private:
  std::filesystem::path folder_;
  std::vector<std::pair<std::string, std::string>> files_;
};

/// Lets the engine of a run show its progress.
void show_progress(Arguments& arguments, Progress& progress);

/// A session with the progress of the engine on the terminal.
[[nodiscard]] Session start(Arguments& arguments, Progress& progress);

/// Throws `Error` when the ray to log is none of so many.
void check_log_ray(const Session& session, std::size_t rays);

/// Traces rays in the waves that were asked for.
void trace_waves(Session& session, std::span<const Ray> rays, int waves, Report& report);

/// Writes the files with the report, prints the summary; the exit status.
int finish(const Report& report, const Session& session, Files& files);

}  // namespace ti
