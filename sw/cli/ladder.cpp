// SPDX-License-Identifier: Apache-2.0
#include "cli/ladder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "accel/build.hpp"
#include "accel/scene_scale.hpp"
#include "base/error.hpp"
#include "cli/hardcase_file.hpp"
#include "engine/session.hpp"
#include "scene/aimed_rays.hpp"
#include "scene/scaling.hpp"
#include "truth/exact_tracer.hpp"

namespace ti {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// E and M of "E,M".
Format format_of(const std::string& word) {
  Format format{0, 0};
  const char* end = word.data() + word.size();
  const auto exponent = std::from_chars(word.data(), end, format.exp_bits);
  bool good = exponent.ec == std::errc() && exponent.ptr != end && *exponent.ptr == ',';
  if (good) {
    const auto fraction = std::from_chars(exponent.ptr + 1, end, format.frac_bits);
    good = fraction.ec == std::errc() && fraction.ptr == end;
  }
  if (!good || format.exp_bits < 3 || format.exp_bits > 8 || format.frac_bits < 2 ||
      format.frac_bits > 23) {
    throw Error(
        fmt::format("FORMATS={}: not E,M with E from 3 to 8 and M from 2 to 23, as in 8,23", word));
  }
  const int least = 1 + static_cast<int>(std::bit_width(unsigned(format.frac_bits - 1)));
  if (format.exp_bits < least) {
    throw Error(fmt::format("FORMATS={}: {} bits of fraction ask for an exponent of {} or more",
                            word, format.frac_bits, least));
  }
  return format;
}

/// Units that cover the three roundings of the t of a plane, as scripts/configure.py has it.
int outward_ulps(const Format& format) {
  return format.reciprocal_half_ulps() + (format.modes.toward_zero ? 6 : 3);
}

Config machine_of(const Config& base, const Format& format, TriangleTest test) {
  Config config = base;
  config.exp_bits = config.format.exp_bits = format.exp_bits;
  config.frac_bits = config.format.frac_bits = format.frac_bits;
  config.triangle_test = test;
  config.traversal = test == TriangleTest::kWoop ? Traversal::kPadded : Traversal::kPlain;
  // A guard of the user's own stays.
  if (base.interval_guard == outward_ulps(base.format))
    config.interval_guard = outward_ulps(config.format);
  return config;
}

Hit trace_alone(const Rung& rung, const HardCase& c) {
  RunOptions options;
  options.config = rung.config;
  options.engine = EngineKind::Model;
  options.truth = false;
  Scene scene;
  scene.mesh = c.mesh;
  return Session(options, std::move(scene)).trace(std::span(&c.ray, 1)).hits.front();
}

/// Rows of cells with columns that line up; the first one is the head. Columns from `left` to
/// `right` are numbers or short words, the others texts.
std::string markdown(const std::vector<std::vector<std::string>>& rows, std::size_t left,
                     std::size_t right = 1000) {
  std::vector<std::size_t> widths(rows.front().size(), 3);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    text += "|";
    for (std::size_t i = 0; i < row.size(); ++i) {
      text += i < left || i >= right ? fmt::format(" {:<{}} |", row[i], widths[i])
                                     : fmt::format(" {:>{}} |", row[i], widths[i]);
    }
    text += "\n";
    if (&row != &rows.front()) continue;
    text += "|";
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string rule(widths[i], '-');
      text += i < left || i >= right ? fmt::format(" {} |", rule) : fmt::format(" {}:|", rule);
    }
    text += "\n";
  }
  return text;
}

const char* word_of(CaseOutcome outcome) {
  return kOutcomeNames[static_cast<std::size_t>(outcome)];
}

/// As in "3 a corner overflows, 1 1/d overflows": the reasons of a machine's empty cells.
std::string reasons(const std::vector<CaseRow>& rows, std::size_t rung) {
  std::vector<std::pair<std::string, int>> counts;
  for (const CaseRow& row : rows) {
    if (row[rung].outcome != CaseOutcome::Absent) continue;
    const auto found = std::find_if(counts.begin(), counts.end(), [&](const auto& count) {
      return count.first == row[rung].absent;
    });
    if (found == counts.end())
      counts.emplace_back(row[rung].absent, 1);
    else
      ++found->second;
  }
  std::string text;
  for (const auto& [reason, count] : counts)
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", reason, count);
  return text;
}

/// Rungs [first, last) are of one format and have the scene times one power of two.
struct Rise {
  std::size_t first, last;
  int scale;
};
std::vector<Rise> rises_of(const std::vector<Rung>& rungs, double largest) {
  std::vector<Rise> rises;
  for (std::size_t i = 0; i < rungs.size(); ++i) {
    const Config& config = rungs[i].config;
    const int scale = scene_scale(largest, config.format, test_kind(config.triangle_test));
    if (i == 0 || rungs[i].format != rungs[i - 1].format || scale != rises.back().scale)
      rises.push_back({i, i, scale});
    rises.back().last = i + 1;
  }
  return rises;
}

/// The models of one format on a mesh.
struct Models {
  std::vector<Image> images;
  std::vector<std::unique_ptr<Tracer>> tracers;
  std::vector<const Tracer*> all;
};
Models models_of(const Mesh& mesh, const std::vector<Rung>& rungs, const Rise& rise) {
  Models models;
  for (std::size_t i = rise.first; i < rise.last; ++i) {
    BuildStats stats;
    models.images.push_back(
        build_image(mesh, build_options_of(rungs[i].config, largest_coordinate(mesh)), stats));
  }
  for (std::size_t i = rise.first; i < rise.last; ++i) {
    models.tracers.push_back(
        Tracer::create(models.images[i - rise.first], tracer_options_of(rungs[i].config)));
    models.all.push_back(models.tracers.back().get());
  }
  return models;
}

Json json_of(const VolumeCount& what, const HitErrors& errors) {
  const std::uint64_t count = errors.*what.count;
  const Interval interval = wilson(count, errors.rays);
  const double rays = static_cast<double>(std::max<std::uint64_t>(1, errors.rays));
  return {{"count", count},
          {"per_million", 1e6 * static_cast<double>(count) / rays},
          {"low", 1e6 * interval.low},
          {"high", 1e6 * interval.high}};
}

}  // namespace

std::vector<Rung> rungs_of(const Config& base, const std::string& formats,
                           const std::string& tests) {
  std::vector<TriangleTest> kinds;
  for (const std::string& word : words_of(tests)) {
    const auto at = std::find(std::begin(kTriangleTestNames), std::end(kTriangleTestNames), word);
    if (at == std::end(kTriangleTestNames)) {
      throw Error(fmt::format("TESTS={}: there is no such triangle test; there are {}", word,
                              fmt::join(kTriangleTestNames, ", ")));
    }
    kinds.push_back(static_cast<TriangleTest>(at - std::begin(kTriangleTestNames)));
  }
  std::vector<Rung> rungs;
  for (const std::string& word : words_of(formats)) {
    const Format format = format_of(word);
    for (const TriangleTest kind : kinds) {
      rungs.push_back({machine_of(base, format, kind),
                       fmt::format("{},{}", format.exp_bits, format.frac_bits),
                       test_name(test_kind(kind))});
    }
  }
  if (rungs.empty()) throw Error("FORMATS= TESTS=: give at least one of each, as in 8,23 and woop");
  return rungs;
}

std::vector<CaseRow> climb(const std::vector<HardCase>& cases, const std::vector<Rung>& rungs) {
  std::vector<CaseRow> rows;
  for (const HardCase& c : cases) {
    CaseRow& row = rows.emplace_back();
    for (const Rung& rung : rungs) {
      row.push_back(judge_case(c, trace_alone(rung, c), rung.config.format,
                               test_kind(rung.config.triangle_test)));
    }
  }
  return rows;
}

std::string table_of(const std::vector<HardCase>& cases, const std::vector<Rung>& rungs,
                     const std::vector<CaseRow>& rows) {
  std::vector<std::vector<std::string>> cells{{"n", "case", "rule", "oracle"}};
  for (const Rung& rung : rungs) cells.front().push_back(rung.name());
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const HardCase& c = cases[i];
    auto& row = cells.emplace_back();
    row = {std::to_string(c.n), c.name, std::string(rule_name(c.rule)), oracle_of(c)};
    for (const CaseResult& result : rows[i]) row.emplace_back(word_of(result.outcome));
  }
  std::vector<std::vector<std::string>> sums{{"machine"}};
  for (const char* name : kOutcomeNames) sums.front().emplace_back(name);
  sums.front().emplace_back("why n.a.");
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    auto& row = sums.emplace_back();
    row.push_back(rungs[r].name());
    for (std::size_t k = 0; k < kOutcomeNames.size(); ++k) {
      row.push_back(std::to_string(std::count_if(rows.begin(), rows.end(), [&](const CaseRow& c) {
        return static_cast<std::size_t>(c[r].outcome) == k;
      })));
    }
    row.push_back(reasons(rows, r));
  }
  return markdown(cells, 4) + "\n" + markdown(sums, 1, 1 + kOutcomeNames.size());
}

std::string lines_of(const std::vector<HardCase>& cases, const std::vector<Rung>& rungs,
                     const std::vector<CaseRow>& rows) {
  std::string lines;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (std::size_t r = 0; r < rungs.size(); ++r) {
      const CaseResult& result = rows[i][r];
      const Json line{{"case", cases[i].n},
                      {"name", cases[i].name},
                      {"rule", rule_name(cases[i].rule)},
                      {"oracle", oracle_of(cases[i])},
                      {"format", rungs[r].format},
                      {"test", rungs[r].test},
                      {"outcome", word_of(result.outcome)},
                      {"required", result.required},
                      {"got", result.text},
                      {"absent", result.absent}};
      lines += line.dump() + "\n";
    }
  }
  return lines;
}

Interval wilson(std::uint64_t count, std::uint64_t of) {
  if (of == 0) return {};
  constexpr double kZ = 1.96;
  const double n = static_cast<double>(of);
  const double share = static_cast<double>(count) / n;
  const double middle = (share + kZ * kZ / (2.0 * n)) / (1.0 + kZ * kZ / n);
  const double half =
      kZ / (1.0 + kZ * kZ / n) * std::sqrt(share * (1.0 - share) / n + kZ * kZ / (4.0 * n * n));
  return {count == 0 ? 0.0 : middle - half, count == of ? 1.0 : middle + half};
}

std::vector<VolumeRow> volumes(const Mesh& given, const std::vector<std::string>& kinds,
                               std::uint64_t count, std::uint64_t seed,
                               const std::vector<Rung>& rungs) {
  std::vector<VolumeRow> rows;
  for (const std::string& kind : kinds) rows.push_back({kind, {}});
  for (const Rise& rise : rises_of(rungs, largest_coordinate(given))) {
    const Format& format = rungs[rise.first].config.format;
    const Mesh mesh = scaled(given, {format, rise.scale});
    const ScaledFormat in_engine(format, 0, true);  // rays leave hits as they do for Woop's test
    const ExactTracer exact(mesh, format);
    const Models models = models_of(given, rungs, rise);
    for (VolumeRow& row : rows) {
      const auto at = std::find(kAimNames.begin(), kAimNames.end(), row.kind);
      const bool secondary = at == kAimNames.end();
      const AimedRays rays(
          mesh, secondary ? Aim::Uniform : static_cast<Aim>(at - kAimNames.begin()), seed);
      const std::vector<HitErrors> errors =
          secondary ? secondary_errors(models.all, exact, mesh, in_engine, rays, count, seed)
                    : hit_errors(models.all, exact, mesh, format, rays, count);
      row.errors.insert(row.errors.end(), errors.begin(), errors.end());
    }
  }
  return rows;
}

bool promised_none(const Rung& rung, const VolumeCount& what) {
  const bool watertight = rung.config.triangle_test == TriangleTest::kWoop;
  return what.count == &HitErrors::failed || what.count == &HitErrors::self_hits ||
         (watertight && what.count == &HitErrors::cracks);
}

std::string table_of(const VolumeCount& what, const std::vector<Rung>& rungs,
                     const std::vector<VolumeRow>& rows) {
  std::vector<std::vector<std::string>> cells{{std::string(what.name) + " of a million"}};
  for (const VolumeRow& row : rows) cells.front().push_back(row.kind);
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    auto& line = cells.emplace_back();
    line.push_back(rungs[r].name());
    for (const VolumeRow& row : rows) {
      const std::uint64_t count = row.errors[r].*what.count;
      const std::uint64_t rays = row.errors[r].rays;
      const Interval interval = wilson(count, rays);
      line.push_back(fmt::format(
          "{:.0f} ({:.0f} to {:.0f}){}",
          1e6 * static_cast<double>(count) / static_cast<double>(std::max<std::uint64_t>(1, rays)),
          1e6 * interval.low, 1e6 * interval.high,
          promised_none(rungs[r], what) && count != 0 ? " FAIL" : ""));
    }
  }
  return markdown(cells, 1);
}

std::string lines_of(const std::vector<Rung>& rungs, const std::vector<VolumeRow>& rows) {
  std::string lines;
  for (const VolumeRow& row : rows) {
    for (std::size_t r = 0; r < rungs.size(); ++r) {
      Json line{{"rays", row.kind},
                {"format", rungs[r].format},
                {"test", rungs[r].test},
                {"traced", row.errors[r].rays},
                {"exact_hits", row.errors[r].exact_hits}};
      for (const VolumeCount& what : kVolumeCounts) {
        std::string name = what.name;
        std::replace_if(name.begin(), name.end(), [](char c) { return c == ' ' || c == '-'; }, '_');
        line[name] = json_of(what, row.errors[r]);
      }
      lines += line.dump() + "\n";
    }
  }
  return lines;
}

}  // namespace ti
