// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace ti {

/// Work that rays took; the same numbers from the model and the RTL, ray by ray.
struct Work {
  std::uint64_t steps = 0;        ///< nodes visited, leaves included
  std::uint64_t leaves = 0;       ///< leaves visited
  std::uint64_t full_leaves = 0;  ///< of these, with triangles
  std::uint64_t restarts = 0;
  std::uint64_t a_tests = 0, b_tests = 0, c_tests = 0;  ///< tests that took pass (a), (b), (c)

  bool operator==(const Work&) const = default;
  Work& operator+=(const Work& other);
};

/// Takes one line a node visited; `docs/step-log.md`.
using StepLog = std::function<void(const std::string&)>;

}  // namespace ti
