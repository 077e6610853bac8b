// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_group.h>

#include <cstddef>

namespace ti {

/// For tasks that compute as the thread that starts them does: the workers are Embree's too, which
/// flushes subnormals in some of its own tasks.
[[nodiscard]] inline tbb::task_group_context same_arithmetic() {
  using Context = tbb::task_group_context;
  return Context(Context::bound, Context::default_traits | Context::fp_settings);
}

/// Calls `work(first, last)` on pieces of [0, count) of at most `piece`, on all processors.
template <typename Work>
void parallel_pieces(std::size_t count, std::size_t piece, const Work& work) {
  tbb::task_group_context context = same_arithmetic();
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, count, piece),
      [&work](const auto& range) { work(range.begin(), range.end()); }, tbb::simple_partitioner(),
      context);
}

/// Calls both, perhaps at the same time. What `first` throws ends this call, and `second` too where
/// it waits for tasks of its own.
template <typename First, typename Second>
void parallel_both(const First& first, const Second& second) {
  tbb::task_group_context context = same_arithmetic();
  tbb::parallel_invoke(second, first, context);  // this thread takes the last one
}

}  // namespace ti
