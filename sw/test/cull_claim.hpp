// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "accel/image.hpp"
#include "model/ist1.hpp"
#include "model/ist2.hpp"

namespace ti {

/// All numbers greater than 0, infinity included; without those that an engine flushes.
template <class F>
std::vector<F> positive() {
  std::vector<F> all;
  for (std::uint32_t bits = 1; bits <= F::kInfBits; ++bits) {
    if (!F::from_bits(bits).is_zero()) all.push_back(F::from_bits(bits));
  }
  return all;
}

/// Tests that pass (a) of the test `local` drops for their distance, and those of them whose t
/// would have counted: of all dett and det, against all ends of the range, near and far.
struct Drops {
  int dropped = 0;
  int wrong = 0;
};
template <class F>
Drops wrong_drops() {
  const std::vector<F> numbers = positive<F>();
  Drops drops;
  for (const F det : numbers) {
    if (!det.is_finite()) continue;
    for (const F dett : numbers) {
      if (!dett.is_finite()) continue;
      // A plane across the ray: det = d_w, dett = p_w.
      ImagePlane plane{};
      plane.pw = dett.bits();
      plane.axis = 2;
      const Vec3<F> o{};
      const Vec3<F> d{F{}, F{}, det};
      const auto c = model::pass_c(model::AfterB<F>{det, dett, F{}, F{}});
      for (const F end : numbers) {
        if (!model::pass_a<TestKind::Local, F>(plane, o, d, {F{}, end})) {
          ++drops.dropped;
          drops.wrong += c && c->t <= end;
        }
        if (!model::pass_a<TestKind::Local, F>(plane, o, d, {end, F::from_bits(F::kInfBits)})) {
          ++drops.dropped;
          drops.wrong += !(dett.to_double() < end.to_double() * det.to_double());
        }
      }
    }
  }
  return drops;
}

}  // namespace ti
