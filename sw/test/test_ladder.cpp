// SPDX-License-Identifier: Apache-2.0
// The ladder of formats and tests: which machines it has, what a case asks of each, and what its
// table and its lines say.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "base/error.hpp"
#include "cli/hardcase_file.hpp"
#include "cli/ladder.hpp"
#include "reference_test.hpp"

namespace ti {
namespace {

constexpr Format kF32{8, 23};

const std::vector<HardCase>& own_cases() {
  static const auto cases = load_hardcases(std::filesystem::path(__FILE__).parent_path() /
                                           "../../scenes/hardcases.jsonl");
  return cases;
}

const HardCase& own_case(int n) {
  return *std::find_if(own_cases().begin(), own_cases().end(),
                       [n](const HardCase& c) { return c.n == n; });
}

std::string refusal(const std::string& formats, const std::string& tests) {
  try {
    (void)rungs_of({}, formats, tests);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST_CASE("the ladder: machines are formats times tests, watertight with Woop's") {
  const auto rungs = rungs_of({}, "8,23  7,16", "local woop");
  REQUIRE(rungs.size() == 4);
  CHECK(rungs[0].name() == "8,23 local");
  CHECK(rungs[3].name() == "7,16 woop");
  CHECK(rungs[3].config.format == Format{7, 16});
  CHECK(rungs[3].config.traversal == Traversal::kPadded);
  CHECK(rungs[2].config.traversal == Traversal::kPlain);
  CHECK(rungs[2].config.exp_bits == 7);
}

TEST_CASE("the ladder: a word that names no format or test is told") {
  for (const char* bad : {"9,9", "8,24", "2,5", "8", "8,", ",8", "8,23x", "half", "-8,23"}) {
    CAPTURE(bad);
    CHECK(refusal(bad, "local").find(fmt::format("FORMATS={}", bad)) == 0);
  }
  CHECK(refusal("4,23", "local") ==
        "FORMATS=4,23: 23 bits of fraction ask for an exponent of 6 or more");
  CHECK(refusal("8,23", "embree") ==
        "TESTS=embree: there is no such triangle test; there are local, np, woop");
  CHECK(refusal("", "local").find("FORMATS=") == 0);
  CHECK(refusal("8,23", " ").find("at least one") != std::string::npos);
}

TEST_CASE("the rounded case in binary32 has the results of the file") {
  for (const HardCase& c : own_cases()) {
    CAPTURE(c.n);
    const HardCase again = rounded_case(c, kF32, TestKind::Local);
    CHECK(again.exact_hit == c.exact_hit);
    CHECK(again.exact_ids == c.exact_ids);
    if (c.exact_hit) CHECK(parse_rational(again.exact_t) == parse_rational(c.exact_t));
  }
}

TEST_CASE("a case that a format cannot hold is absent, with the reason") {
  const auto result = [](int n, const Format& format, TestKind test) {
    const HardCase& c = own_case(n);
    const Hit hit =
        test == TestKind::Local ? reference::Engine(c.mesh, format).trace(c.ray) : Hit{};
    return judge_case(c, hit, format, test);
  };
  const auto absent = [&](int n, const Format& format) {
    const CaseResult got = result(n, format, TestKind::Local);
    CHECK(got.outcome == CaseOutcome::Absent);
    return got.absent;
  };
  CHECK(absent(49, {5, 10}) == "the ray overflows");
  CHECK(absent(47, {7, 16}) == "a triangle loses its area");
  CHECK(absent(51, {5, 10}) == "1/d overflows");
  CHECK(result(20, kF32, TestKind::Woop).outcome == CaseOutcome::Fail);
  CHECK(result(1, {7, 16}, TestKind::Local).outcome == CaseOutcome::Pass);
  CHECK(result(23, {7, 16}, TestKind::Local).outcome == CaseOutcome::Policy);
}

TEST_CASE("a miss of a plain triangle fails in every format") {
  for (const Format& format : {Format{5, 10}, Format{7, 16}, kF32}) {
    for (const TestKind test : {TestKind::Np, TestKind::Local, TestKind::Woop})
      CHECK(judge_case(own_case(1), Hit{}, format, test).outcome == CaseOutcome::Fail);
  }
}

TEST_CASE("the table and the lines have a cell for each case and machine") {
  const std::vector<HardCase> cases{own_case(1), own_case(23), own_case(49)};
  HardCase wrong = own_case(1);
  wrong.exact_hit = false;
  wrong.exact_ids.clear();
  const std::vector<HardCase> all{cases[0], cases[1], cases[2], wrong};
  const auto rungs = rungs_of({}, "5,10 8,23", "local");
  const auto rows = climb(all, rungs);
  const std::string table = table_of(all, rungs, rows);
  CHECK(table.find("5,10 local | 8,23 local |") != std::string::npos);
  CHECK(std::count(table.begin(), table.end(), '\n') == 6 + 1 + 4);
  CHECK(table.find("the ray overflows (1)") != std::string::npos);
  std::istringstream lines(lines_of(all, rungs, rows));
  std::vector<std::string> outcomes;
  for (std::string line; std::getline(lines, line);)
    outcomes.push_back(nlohmann::json::parse(line).at("outcome"));
  // In (5,10) the results are computed anew, so a wrong one in the file is no matter there.
  CHECK(outcomes == std::vector<std::string>{"pass", "pass", "policy", "policy", "n.a.", "pass",
                                             "pass", "FAIL"});
}

TEST_CASE("volumes: the watertight machine keeps its promises, and the other has cracks") {
  const auto rungs = rungs_of({}, "7,16", "local woop");
  const auto rows = volumes(reference::sphere(2), {"edges", "secondary"}, 3000, 1, rungs);
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].errors[0].cracks > 50);
  for (const VolumeRow& row : rows) {
    REQUIRE(row.errors.size() == 2);
    for (std::size_t r = 0; r < rungs.size(); ++r) {
      for (const VolumeCount& what : kVolumeCounts) {
        if (promised_none(rungs[r], what)) CHECK(row.errors[r].*what.count == 0);
      }
    }
  }
  CHECK_FALSE(promised_none(rungs[0], kVolumeCounts[0]));
  CHECK(promised_none(rungs[1], kVolumeCounts[0]));
  CHECK(table_of(kVolumeCounts[0], rungs, rows).find("FAIL") == std::string::npos);
  auto broken = rows;
  broken[0].errors[1].cracks = 1;
  CHECK(table_of(kVolumeCounts[0], rungs, broken).find("FAIL") != std::string::npos);
}

TEST_CASE("Wilson's interval") {
  CHECK(wilson(0, 100).low == 0.0);
  CHECK(wilson(0, 100).high == doctest::Approx(0.0370).epsilon(0.01));
  CHECK(wilson(50, 100).low == doctest::Approx(0.4038).epsilon(0.001));
  CHECK(wilson(100, 100).high == 1.0);
  CHECK(wilson(0, 0).high == 1.0);
}

}  // namespace
}  // namespace ti
