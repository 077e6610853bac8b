// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/config.hpp"
#include "cli/hardcases.hpp"
#include "truth/accuracy.hpp"

namespace ti {

/// A machine of the ladder: a number format and a triangle test, all else as in its base.
struct Rung {
  Config config;
  std::string format;  ///< as in "8,23"
  std::string test;    ///< `np`, `local`, or `woop`, which walks the tree padded: watertight

  [[nodiscard]] std::string name() const { return format + " " + test; }
};

/// The machines of `formats` ("5,10 8,23") times `tests` ("np local woop"), those of a format
/// together. Throws `Error`, one sentence, for a word that names none.
[[nodiscard]] std::vector<Rung> rungs_of(const Config& base, const std::string& formats,
                                         const std::string& tests);

/// The results of a case, one a machine.
using CaseRow = std::vector<CaseResult>;

/// Traces and judges each case on the model of each machine.
[[nodiscard]] std::vector<CaseRow> climb(const std::vector<HardCase>& cases,
                                         const std::vector<Rung>& rungs);

/// Cases against machines, and how many went how, in Markdown with columns that line up.
[[nodiscard]] std::string table_of(const std::vector<HardCase>& cases,
                                   const std::vector<Rung>& rungs,
                                   const std::vector<CaseRow>& rows);
/// The same as JSON, a line a cell.
[[nodiscard]] std::string lines_of(const std::vector<HardCase>& cases,
                                   const std::vector<Rung>& rungs,
                                   const std::vector<CaseRow>& rows);

/// Rays of a kind in volume on each machine.
struct VolumeRow {
  std::string kind;
  std::vector<HitErrors> errors;  ///< one a machine
};

/// What is counted of a volume: its name and its count.
struct VolumeCount {
  const char* name;
  std::uint64_t HitErrors::* count;
};
constexpr std::array<VolumeCount, 7> kVolumeCounts{{{"cracks", &HitErrors::cracks},
                                                    {"missed", &HitErrors::missed},
                                                    {"through", &HitErrors::through},
                                                    {"false hits", &HitErrors::false_hits},
                                                    {"wrong triangle", &HitErrors::wrong},
                                                    {"self-hits", &HitErrors::self_hits},
                                                    {"failed", &HitErrors::failed}}};

/// Traces `count` rays of each kind (of `kAimNames`, or `secondary`) through `mesh` on the model of
/// each machine, against exact arithmetic.
[[nodiscard]] std::vector<VolumeRow> volumes(const Mesh& mesh,
                                             const std::vector<std::string>& kinds,
                                             std::uint64_t count, std::uint64_t seed,
                                             const std::vector<Rung>& rungs);

/// Whether a machine promises that there are none of these.
[[nodiscard]] bool promised_none(const Rung& rung, const VolumeCount& what);

/// Machines against kinds of rays: rates of a million with their 95 % intervals, in Markdown.
[[nodiscard]] std::string table_of(const VolumeCount& what, const std::vector<Rung>& rungs,
                                   const std::vector<VolumeRow>& rows);
/// All counts as JSON, a line a kind and machine.
[[nodiscard]] std::string lines_of(const std::vector<Rung>& rungs,
                                   const std::vector<VolumeRow>& rows);

/// The 95 % interval of a rate (Wilson 1927), of `count` in `of`.
struct Interval {
  double low = 0.0, high = 1.0;
};
[[nodiscard]] Interval wilson(std::uint64_t count, std::uint64_t of);

}  // namespace ti
