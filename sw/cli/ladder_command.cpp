// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>

#include "base/error.hpp"
#include "cli/commands.hpp"
#include "cli/ladder.hpp"
#include "cli/ray_source.hpp"
#include "cli/traced_run.hpp"
#include "io/file.hpp"

namespace ti {
namespace {

constexpr const char* kLegend =
    "pass: what exact arithmetic requires, t within the bound of the test. bound: not that, but "
    "within the error bounds of the test in the format. policy: by a choice that "
    "docs/hardcases.md writes down. n.a.: the format cannot hold the case. FAIL: none of these.\n"
    "In (8,23) exact results are those of the file, in other formats those of the rounded case, "
    "by integers of any length.\n";

std::string cases_text(const std::vector<HardCase>& cases, const std::vector<Rung>& rungs,
                       const std::vector<CaseRow>& rows) {
  return table_of(cases, rungs, rows) + "\n" + kLegend;
}

/// What traces a case of a file alone on a machine, on model and RTL.
std::string repeat(const std::string& file, const HardCase& c, const Rung& rung) {
  const std::string& name = rung.config.name;  // of a configuration, then its overrides
  const auto space = name.find(' ');
  const std::string overrides = space == std::string::npos ? "" : name.substr(space + 1) + " ";
  return fmt::format(
      "make hardcase ID={} CONFIG={} SET=\"{}exp_bits={} frac_bits={} triangle_test={} "
      "traversal={}\" FILE={}",
      c.n, name.substr(0, space), overrides, rung.config.exp_bits, rung.config.frac_bits, rung.test,
      rung.config.traversal == Traversal::kPadded ? "padded" : "plain", file);
}

/// What is not as it must be, a line or two each.
struct Failures {
  int count = 0;
  std::string text;

  void add(const std::string& what) {
    ++count;
    text += "failed: " + what + "\n";
  }
};

/// The cells that fail.
void add_cases(Failures& failures, const std::string& file, const std::vector<HardCase>& cases,
               const std::vector<Rung>& rungs, const std::vector<CaseRow>& rows) {
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (std::size_t r = 0; r < rungs.size(); ++r) {
      const CaseResult& result = rows[i][r];
      if (result.pass()) continue;
      failures.add(fmt::format("case {} with {}: required {}, got {}\nrepeat: {}", cases[i].n,
                               rungs[r].name(), result.required, result.text,
                               repeat(file, cases[i], rungs[r])));
    }
  }
}

/// The promises that do not hold.
void add_volumes(Failures& failures, const std::vector<Rung>& rungs,
                 const std::vector<VolumeRow>& rows) {
  for (const VolumeRow& row : rows) {
    for (std::size_t r = 0; r < rungs.size(); ++r) {
      for (const VolumeCount& what : kVolumeCounts) {
        const std::uint64_t count = row.errors[r].*what.count;
        if (count == 0 || !promised_none(rungs[r], what)) continue;
        failures.add(fmt::format("{} of {} rays {} with {}: {}, promised none", what.name,
                                 row.errors[r].rays, row.kind, rungs[r].name(), count));
      }
    }
  }
}

}  // namespace

int ladder(const Arguments& arguments) {
  const auto cases = load_hardcases(arguments.cases_file);
  const auto rungs = rungs_of(arguments.run.config, arguments.formats, arguments.tests);
  const std::vector<std::string> kinds = kinds_of(arguments.ladder_rays);
  const std::filesystem::path& out = arguments.run.out;
  check_folder(out);
  const Mesh mesh = load(arguments).mesh;
  if (mesh.triangles.empty()) {
    throw Error(fmt::format("{}: it has no triangle, so there is nothing to aim at",
                            arguments.run.scene.string()));
  }

  const auto rows = climb(cases, rungs);
  std::string text = cases_text(cases, rungs, rows);
  fmt::print("{}\n", text);
  const auto counted = arguments.count == 0
                           ? std::vector<VolumeRow>{}
                           : volumes(mesh, kinds, arguments.count, arguments.seed, rungs);
  if (!counted.empty()) {
    text += fmt::format(
        "\n{} rays of each kind on {}, seed {}; secondary: one from each hit. Rates of a million "
        "with 95 % intervals, by exact arithmetic (docs/accuracy.md).\n",
        arguments.count, arguments.run.scene.filename().string(), arguments.seed);
    for (const VolumeCount& what : kVolumeCounts) text += "\n" + table_of(what, rungs, counted);
    fmt::print("{}\n", table_of(kVolumeCounts.front(), rungs, counted));
  }
  Failures failures;
  add_cases(failures, arguments.cases_file, cases, rungs, rows);
  add_volumes(failures, rungs, counted);
  const auto table = out / "table.md";
  const auto lines = out / "hardcases.json";
  const std::string json = lines_of(cases, rungs, rows) + lines_of(rungs, counted);
  write_files({{table, text}, {lines, json}});
  fmt::print("{}{} cases and {} kinds of rays on {} machines, {} failed\n{}\n{}\n", failures.text,
             cases.size(), counted.size(), rungs.size(), failures.count, table.string(),
             lines.string());
  return failures.count == 0 ? kGood : kChecksFailed;
}

}  // namespace ti
