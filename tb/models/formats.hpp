// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <string>
#include <tuple>

#include "model/fp.hpp"

namespace ti {

/// The formats that the tests of the operators name.
using FpFormats =
    std::tuple<Fp<8, 23>, Fp<7, 16>, Fp<5, 10>, Fp<5, 4>, Fp<4, 3>, Fp<3, 4>, Fp<3, 2>>;

/// The formats that the tests of the units name.
using UnitFormats = std::tuple<Fp<8, 23>, Fp<7, 16>, Fp<5, 10>>;

/// `operation.template operator()<Fp<e, m>>()`; a Python ValueError for a format not in `Formats`.
template <typename Formats, typename Operation>
auto in_format(int e, int m, Operation operation) {
  using Result = decltype(operation.template operator()<Fp<8, 23>>());
  Result result{};
  bool found = false;
  const auto attempt = [&]<typename F>() {
    if (F::kExpBits == e && F::kFracBits == m) {
      result = operation.template operator()<F>();
      found = true;
    }
  };
  [&]<typename... F>(std::tuple<F...>*) {
    (attempt.template operator()<F>(), ...);
  }(static_cast<Formats*>(nullptr));
  if (!found) {
    const std::string name = "(" + std::to_string(e) + "," + std::to_string(m) + ")";
    throw nanobind::value_error((name + ": no such format in tb/models/formats.hpp").c_str());
  }
  return result;
}

}  // namespace ti
