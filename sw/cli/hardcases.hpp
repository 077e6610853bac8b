// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "accel/image.hpp"
#include "base/format.hpp"
#include "scene/mesh.hpp"
#include "scene/ray.hpp"

namespace ti {

/// What a hard case asks for; `docs/hardcases.md` tells each in full.
enum class CaseRule : std::uint8_t { Exact, Watertight, NoHit, Tie, Policy, Self };

/// One line of a file in the form of `scenes/hardcases.jsonl`.
struct HardCase {
  int n = 0;
  std::string name;
  CaseRule rule = CaseRule::Exact;
  Ray ray;
  Mesh mesh;
  bool exact_hit = false;               ///< in exact arithmetic, tmin and tmax as they stand
  std::vector<std::int32_t> exact_ids;  ///< every triangle of least t
  std::string exact_t;                  ///< integer, fraction or decimal; empty when nothing is hit
};

/// Reads a file of cases. Throws `Error`, one sentence with file and line, for anything that is not
/// in the form.
[[nodiscard]] std::vector<HardCase> load_hardcases(const std::filesystem::path& path);

/// How a case went; `docs/hardcases.md` has the words.
enum class CaseOutcome : std::uint8_t {
  Pass,    ///< what exact arithmetic requires
  Bound,   ///< not that, but within the error bounds of the test in a format other than (8, 23)
  Policy,  ///< by a choice of ours that `docs/hardcases.md` writes down
  Absent,  ///< the format cannot hold the case
  Fail,
};
constexpr std::array<const char*, 5> kOutcomeNames{"pass", "bound", "policy", "n.a.", "FAIL"};

struct CaseResult {
  CaseOutcome outcome = CaseOutcome::Fail;
  std::string required;  ///< what had to come out
  std::string text;      ///< what came out, and why that is right or wrong
  std::string absent;    ///< why the format cannot hold the case; empty: it can

  [[nodiscard]] bool pass() const { return outcome != CaseOutcome::Fail; }
};

/// Judges what an engine of `format` with that triangle test reported, in the units of the case.
/// Bounds are those of the case as the engine has it, scaled.
///
/// (8, 23): by the results in the case. Other formats and modes: the case is rounded first and its
/// results are computed anew by integers; what differs from them passes where the error bounds of
/// the test in that format explain it.
[[nodiscard]] CaseResult judge_case(const HardCase& hard_case, const Hit& hit,
                                    const Format& format = {}, TestKind test = TestKind::Local);

/// The case times 2^scale, as an engine has it (`scene_scale`).
[[nodiscard]] HardCase scaled_case(const HardCase& hard_case, int scale);

/// The case as an engine of `format` sees it: numbers rounded, triangles that the builder drops for
/// that test left out of its results, which are computed by integers of any length.
[[nodiscard]] HardCase rounded_case(const HardCase& hard_case, const Format& format, TestKind test);

/// How the required answer of a case is known.
[[nodiscard]] std::string oracle_of(const HardCase& hard_case);

/// Traces one ray through one mesh on an engine.
using CaseTracer = std::function<Hit(const Mesh&, const Ray&)>;

/// Traces and judges all cases, prints a table to standard output and gives the number of failures.
[[nodiscard]] int run_hardcases(const std::vector<HardCase>& cases, const CaseTracer& trace,
                                const Format& format = {}, TestKind test = TestKind::Local);

}  // namespace ti
