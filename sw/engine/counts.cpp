// SPDX-License-Identifier: Apache-2.0
#include "engine/counts.hpp"

#include <algorithm>

namespace ti {
namespace {

/// `a` op= `b` for every count of two values of one engine.
template <typename Op>
void combine(DramCounts& a, const DramCounts& b, Op op) {
  op(a.cycles, b.cycles);
  op(a.reads, b.reads);
  op(a.row_hits, b.row_hits);
  op(a.bytes, b.bytes);
  op(a.refreshes, b.refreshes);
  op(a.answers, b.answers);
  op(a.waited, b.waited);
  op(a.queued, b.queued);
}

template <typename Op>
void combine(MachineCounts& a, const MachineCounts& b, Op op) {
  op(a.cycles, b.cycles);
  op(a.memory_bytes, b.memory_bytes);
  if (a.dram && b.dram) combine(*a.dram, *b.dram, op);
  for (std::size_t i = 0; i < a.caches.size(); ++i) {
    op(a.caches[i].accesses, b.caches.at(i).accesses);
    op(a.caches[i].hits, b.caches[i].hits);
    op(a.caches[i].merged, b.caches[i].merged);
    op(a.caches[i].misses, b.caches[i].misses);
  }
  for (std::size_t i = 0; i < a.units.size(); ++i) {
    for (std::size_t k = 0; k < a.units[i].activities.size(); ++k)
      op(a.units[i].activities[k].second, b.units.at(i).activities.at(k).second);
  }
}

template <typename Op>
void combine(Counts& a, const Counts& b, Op op) {
  op(a.rays, b.rays);
  op(a.lost, b.lost);
  op(a.duplicated, b.duplicated);
  op(a.seconds, b.seconds);
  op(a.work.steps, b.work.steps);
  op(a.work.leaves, b.work.leaves);
  op(a.work.full_leaves, b.work.full_leaves);
  op(a.work.restarts, b.work.restarts);
  op(a.work.a_tests, b.work.a_tests);
  op(a.work.b_tests, b.work.b_tests);
  op(a.work.c_tests, b.work.c_tests);
  if (a.machine && b.machine) combine(*a.machine, *b.machine, op);
}

}  // namespace

const UnitCounts* MachineCounts::unit(const std::string& name) const {
  const auto found = std::find_if(units.begin(), units.end(),
                                  [&name](const UnitCounts& u) { return u.name == name; });
  return found == units.end() ? nullptr : &*found;
}

Counts& Counts::operator+=(const Counts& other) {
  if (!machine && other.machine) {
    machine = other.machine;
    combine(*machine, *other.machine, [](auto& a, const auto& b) { a -= b; });
  }
  combine(*this, other, [](auto& a, const auto& b) { a += b; });
  return *this;
}

Counts& Counts::operator-=(const Counts& other) {
  combine(*this, other, [](auto& a, const auto& b) { a -= b; });
  return *this;
}

DramCounts& DramCounts::operator+=(const DramCounts& other) {
  combine(*this, other, [](auto& a, const auto& b) { a += b; });
  return *this;
}

Counts operator-(Counts after, const Counts& before) { return after -= before; }

}  // namespace ti
