// SPDX-License-Identifier: Apache-2.0
// The written cases agree with exact arithmetic; an honest engine passes all; a wrong answer, file
// or line is told.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "accel/scene_scale.hpp"
#include "base/error.hpp"
#include "cli/hardcase_file.hpp"
#include "cli/hardcases.hpp"
#include "embree_devices.hpp"
#include "reference_test.hpp"
#include "scene/scaling.hpp"
#include "truth/truth.hpp"

namespace {

using namespace ti;

constexpr Format kF32{8, 23};

std::vector<HardCase> own_cases() {
  return load_hardcases(std::filesystem::path(__FILE__).parent_path() /
                        "../../scenes/hardcases.jsonl");
}

Hit honest(const HardCase& c, Format format = kF32) {
  const int scale = scene_scale(largest_coordinate(c.mesh), format, TestKind::Local);
  const Mesh mesh = scaled(c.mesh, {format, scale});
  return scaled(reference::Engine(mesh, format).trace(scaled(c.ray, scale)), -scale);
}

constexpr const char* kGood =
    R"({"n": 1, "name": "one", "rule": "exact", "why": "", "o": ["00000000", "00000000", "00000000"], )"
    R"("d": ["00000000", "00000000", "3F800000"], "tmin": "00000000", "tmax": "7F800000", "tris": [[["BF800000", )"
    R"("BF800000", "40A00000"], ["3F800000", "BF800000", "40A00000"], ["00000000", "3F800000", "40A00000"]]], )"
    R"("exact_hit": true, "exact_ids": [0], "exact_t": "5"})";

/// A file that lives as long as the test.
struct TemporaryFile {
  explicit TemporaryFile(const std::string& text)
      : path(std::filesystem::temp_directory_path() /
             fmt::format("ti_hardcases_{}.jsonl", ++count)) {
    std::ofstream(path) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path); }
  std::filesystem::path path;
  static inline int count = 0;
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

std::string message(const std::string& text) {
  const TemporaryFile file(text);
  try {
    (void)load_hardcases(file.path);
  } catch (const Error& error) {
    return replaced(error.what(), file.path.string(), "FILE");
  }
  return "no error";
}

TEST_CASE("the exact results of every case are those of exact arithmetic") {
  const auto cases = own_cases();
  CHECK(cases.size() == 63);
  for (const HardCase& c : cases) {
    CAPTURE(c.n);
    std::vector<std::int32_t> ids;
    mpq_class least;
    const bool finite =
        std::isfinite(c.ray.o.x + c.ray.o.y + c.ray.o.z + c.ray.d.x + c.ray.d.y + c.ray.d.z);
    for (std::size_t i = 0; finite && i < c.mesh.triangles.size(); ++i) {
      const Corners tri = c.mesh.corners(i);
      const auto met = test_constants(tri, kF32) ? exact_meeting(c.ray, tri) : std::nullopt;
      const double t = met ? to_double(met->t) : 0.0;
      if (!met || !(t >= double{c.ray.tmin} && t <= double{c.ray.tmax})) {
        continue;
      }
      if (ids.empty() || met->t < least) {
        ids.clear();
        least = met->t;
      }
      if (met->t == least) {
        ids.push_back(static_cast<std::int32_t>(i));
      }
    }
    CHECK(c.exact_hit == !ids.empty());
    CHECK(c.exact_ids == ids);
    if (c.exact_hit) {
      CHECK(parse_rational(c.exact_t) == least);
    }
    // Truth says the same save where the engine's rules are narrower.
    const auto exact = Truth(c.mesh, kF32).exact(c.ray);
    const bool ruled_out = !valid_ray(c.ray, kF32) || (c.exact_hit && sgn(least) < 0);
    CHECK(exact.hit == (c.exact_hit && !ruled_out));
    CHECK(exact.prims == (ruled_out ? std::vector<std::int32_t>{} : c.exact_ids));
  }
}

TEST_CASE("an honest engine passes every case, in every format") {
  for (const Format format : {kF32, Format{7, 16}, Format{5, 10}}) {
    CAPTURE(format.frac_bits);
    for (const HardCase& c : own_cases()) {
      const CaseResult result = judge_case(c, honest(c, format), format);
      CAPTURE(c.n);
      CAPTURE(result.required);
      CAPTURE(result.text);
      CHECK(result.pass());
    }
  }
}

TEST_CASE("the truth explains what Embree and an honest engine say of every case") {
  const std::string device = test::each_embree_device();
  for (const HardCase& c : own_cases()) {
    CAPTURE(c.n);
    const Truth truth(c.mesh, kF32, device);
    CHECK(truth.judge(c.ray, honest(c), truth.trace(std::span(&c.ray, 1)).front()) !=
          Verdict::Unexplained);
  }
}

TEST_CASE("a dropped, invented, moved or renamed hit fails every case that forbids it") {
  for (const HardCase& c : own_cases()) {
    CAPTURE(c.n);
    const Hit good = honest(c);
    const bool free = c.rule == CaseRule::Self || c.n == 59;
    const bool t_open = c.n == 46 || c.n == 62;  // t is within its bound of zero, det of zero
    if (!good.is_hit()) {
      CHECK_FALSE(judge_case(c, {5.0F, 0, 0, 0, Status::Ok, 0}).pass());
      continue;
    }
    CHECK((free || !judge_case(c, {}).pass()));
    Hit moved = good;
    moved.t = good.t * 1.001F + 1e-30F;
    CHECK((t_open || c.n == 59 || !judge_case(c, moved).pass()));
    Hit renamed = good;
    renamed.prim = static_cast<std::int32_t>(c.mesh.triangles.size());
    CHECK_FALSE(judge_case(c, renamed).pass());
    if (c.rule == CaseRule::Tie || (c.rule == CaseRule::Exact && c.mesh.triangles.size() > 1)) {
      renamed.prim = 1 - good.prim;
      CHECK_FALSE(judge_case(c, renamed).pass());
    }
  }
}

TEST_CASE("the runner counts failures and goes on after an engine's error") {
  const TemporaryFile file(std::string(kGood) + "\n\n" + kGood + "\n");
  const auto cases = load_hardcases(file.path);
  REQUIRE(cases.size() == 2);
  CHECK(run_hardcases(cases, [&](const Mesh& mesh, const Ray& ray) {
          return reference::Engine(mesh, kF32).trace(ray);
        }) == 0);
  CHECK(run_hardcases(cases, [](const Mesh&, const Ray&) { return Hit{}; }) == 2);
  CHECK(run_hardcases(cases, [](const Mesh&, const Ray&) -> Hit { throw Error("no engine."); }) ==
        2);
}

TEST_CASE("numbers are integers, fractions or decimals") {
  CHECK(parse_rational("5") == mpq_class(5));
  CHECK(parse_rational("-10/4") == mpq_class(-5, 2));
  CHECK(parse_rational("0.125") == mpq_class(1, 8));
  CHECK(parse_rational("010") == mpq_class(10));
  for (const char* bad : {"", "x", "1/0", "1/-2", "1e5", " 5", "5.", "0x5", "1/2/3"}) {
    CAPTURE(bad);
    CHECK_FALSE(parse_rational(bad));
  }
}

TEST_CASE("a bad file is told in one sentence with its line") {
  const std::string good = kGood;
  const std::string second = good + "\n" + good + "\n";
  CHECK(message(good) == "no error");
  CHECK(message("") == "FILE: the file holds no case; write one JSON object a line.");
  CHECK(message("\n \n") == "FILE: the file holds no case; write one JSON object a line.");
  CHECK(message(good + "\n{\"n\": 2") == "FILE, line 2: this is not JSON.");
  CHECK(message("[1]") == "FILE, line 1: a case must be a JSON object.");
  CHECK(message(replaced(good, "\"d\"", "\"e\"")) == "FILE, line 1: the field \"d\" is missing.");
  CHECK(message(replaced(good, "\"n\": 1", "\"n\": \"1\"")) ==
        "FILE, line 1: the field \"n\" must be an integer.");
  CHECK(message(replaced(good, "\"exact\"", "\"exactly\"")) ==
        "FILE, line 1: the rule \"exactly\" is not one of exact, watertight, nohit, tie, policy, "
        "self.");
  CHECK(message(replaced(good, "7F800000", "7F8")) ==
        "FILE, line 1: \"tmax\" must hold binary32 words of 8 hex digits, not \"7F8\".");
  CHECK(message(replaced(good, "\"tmin\": \"00000000\"", "\"tmin\": 0")) ==
        "FILE, line 1: \"tmin\" must hold binary32 words of 8 hex digits, not 0.");
  CHECK(message(replaced(good, "[0], \"exact_t\"", "[1], \"exact_t\"")) ==
        "FILE, line 1: \"exact_ids\" names 1, which is not a triangle of \"tris\".");
  CHECK(message(replaced(good, "[0], \"exact_t\"", "[], \"exact_t\"")) ==
        "FILE, line 1: \"exact_ids\" must be a list, empty exactly when \"exact_hit\" is false.");
  CHECK(message(replaced(good, "\"exact_t\": \"5\"", "\"exact_t\": \"five\"")) ==
        "FILE, line 1: \"exact_t\" must be an integer, a fraction or a decimal, not \"five\".");
  CHECK_THROWS_AS((void)load_hardcases("/nonexistent/cases.jsonl"), Error);
  CHECK_THROWS_AS((void)load_hardcases(std::filesystem::temp_directory_path()), Error);
}

}  // namespace
