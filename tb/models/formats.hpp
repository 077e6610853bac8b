// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <tuple>

#include "model/fp.hpp"

namespace ti {

/// The formats that the tests of the operators name, in their default modes.
using FpFormats =
    std::tuple<Fp<8, 23>, Fp<7, 16>, Fp<5, 10>, Fp<5, 4>, Fp<4, 3>, Fp<3, 4>, Fp<3, 2>>;

/// The formats that the tests of the units name, in their default modes.
using UnitFormats = std::tuple<Fp<8, 23>, Fp<7, 16>, Fp<5, 10>>;

/// `operation.template operator()<F>()`, F a number of `format`: compiled for those of `Formats`.
template <typename Formats, typename Operation>
auto in_format(const Format& format, Operation operation) {
  using Result = decltype(operation.template operator()<AnyFp>());
  Result result{};
  bool found = false;
  const auto attempt = [&]<typename F>() {
    if (Format{F::kExpBits, F::kFracBits, F::modes()} == format) {
      result = operation.template operator()<F>();
      found = true;
    }
  };
  [&]<typename... F>(std::tuple<F...>*) {
    (attempt.template operator()<F>(), ...);
  }(static_cast<Formats*>(nullptr));
  if (found) return result;
  const FpRules rules(format);
  const FormatScope scope(rules);
  return operation.template operator()<AnyFp>();
}

}  // namespace ti
