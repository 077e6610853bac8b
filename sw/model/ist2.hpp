// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "model/ist1.hpp"

namespace ti::model {

template <class F>
struct Candidate {
  F t, u, v;
};

/// Pass (c): one reciprocal, three products; nothing when t is not finite.
///
/// Bit-exact model of `ti_ist2`.
template <class F>
[[nodiscard]] std::optional<Candidate<F>> pass_c(const AfterB<F>& b) {
  const F r = reciprocal(b.det);
  const F t = b.dett * r;
  if (!t.is_finite()) return std::nullopt;
  return Candidate<F>{t, b.detu * r, b.detv * r};
}

}  // namespace ti::model
