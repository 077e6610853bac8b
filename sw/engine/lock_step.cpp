// SPDX-License-Identifier: Apache-2.0
#include "engine/lock_step.hpp"

#include <fmt/core.h>

#include <mutex>

#include "base/parallel.hpp"

namespace ti {
namespace {

constexpr std::size_t kExamples = 4;
constexpr std::int32_t kNoPrim = HitBits{}.prim;  // a damaged image may name any other

std::string text_of(const Work& work) {
  return fmt::format("steps {} leaves {} ({} full) restarts {} tests {} / {} / {}", work.steps,
                     work.leaves, work.full_leaves, work.restarts, work.a_tests, work.b_tests,
                     work.c_tests);
}

std::string text_of(const HitBits& hit) {
  return fmt::format("prim {} t {:08x} u {:08x} v {:08x} status {} steps {}", hit.prim, hit.t,
                     hit.u, hit.v, static_cast<int>(hit.status), hit.steps);
}

}  // namespace

LockStep& LockStep::operator+=(const LockStep& other) {
  on = on || other.on;
  mismatches += other.mismatches;
  work_differs = work_differs || other.work_differs;
  for (const std::string& example : other.examples)
    if (examples.size() < kExamples) examples.push_back(example);
  return *this;
}

ModelRun run_model(const Tracer& model, std::span<const Ray> rays) {
  ModelRun run;
  run.hits.resize(rays.size());
  run.tests.resize(rays.size());
  std::mutex guard;
  parallel_pieces(rays.size(), 1024, [&](std::size_t first, std::size_t last) {
    Work sum;
    for (std::size_t i = first; i < last; ++i) {
      const std::uint64_t before = sum.a_tests;
      run.hits[i] = model.trace(rays[i], sum);
      run.tests[i] = static_cast<std::uint32_t>(sum.a_tests - before);
    }
    const std::lock_guard lock(guard);
    run.work += sum;
  });
  return run;
}

LockStep compare(const ModelRun& model, std::span<const Answer> answers, std::uint64_t first,
                 const Work* work, bool excuse_memory) {
  LockStep result;
  result.on = true;
  for (const Answer& answer : answers) {
    const HitBits& expected = model.hits[answer.ray - first];
    const bool excused = excuse_memory && answer.hit.status == Status::MemoryError && !answer.found;
    if (excused || (answer.hit == expected && answer.found == (expected.prim != kNoPrim))) continue;
    ++result.mismatches;
    if (result.examples.size() < kExamples) {
      result.examples.push_back(fmt::format("ray {}: RTL {}; model {}", answer.ray,
                                            text_of(answer.hit), text_of(expected)));
    }
  }
  if (work != nullptr && !excuse_memory && !(*work == model.work)) {
    result.work_differs = true;
    result.examples.push_back(fmt::format("RTL {}; model {}", text_of(*work), text_of(model.work)));
  }
  return result;
}

}  // namespace ti
