// SPDX-License-Identifier: Apache-2.0

#include <cstdint>
#include <string>
#include <tuple>
#include <utility>

#include "bind.hpp"
#include "common/format.hpp"
#include "model/fp.hpp"

namespace ti {
namespace {

namespace nb = nanobind;
using Bits = std::uint32_t;

/// The formats that the tests name.
using Formats = std::tuple<Fp<8, 23>, Fp<7, 16>, Fp<5, 10>, Fp<5, 4>, Fp<4, 3>, Fp<3, 4>, Fp<3, 2>>;

/// `operation.template operator()<Fp<e, m>>()`; a Python ValueError for a format not in `Formats`.
template <typename Operation>
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
    throw nb::value_error((name + ": no such format in tb/models/bind_fp.cpp").c_str());
  }
  return result;
}

/// Binds `fp_<name>(e, m, a, b)`, an operation on two values.
template <typename Operation>
void bind_binary(nb::module_& module, const char* name, Operation operation) {
  module.def(
      name,
      [operation](int e, int m, Bits a, Bits b) {
        return in_format(e, m, [&]<typename F>() {
          return operation(F::from_bits(a), F::from_bits(b));
        });
      },
      nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("a"), nb::arg("b"));
}

}  // namespace

void bind_fp(nb::module_& module) {
  bind_binary(module, "fp_add", [](auto a, auto b) { return (a + b).bits(); });
  bind_binary(module, "fp_sub", [](auto a, auto b) { return (a - b).bits(); });
  bind_binary(module, "fp_mul", [](auto a, auto b) { return (a * b).bits(); });
  bind_binary(module, "fp_lt", [](auto a, auto b) { return a < b; });
  bind_binary(module, "fp_le", [](auto a, auto b) { return a <= b; });
  bind_binary(module, "fp_eq", [](auto a, auto b) { return a == b; });
  module.def(
      "fp_rcp",
      [](int e, int m, Bits a) {
        return in_format(
            e, m, [&]<typename F>() { return reciprocal(F::from_bits(a)).bits(); });
      },
      nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("a"));
  module.def(
      "fp_ulps_up",
      [](int e, int m, Bits a, std::uint32_t n) {
        return in_format(e, m, [&]<typename F>() { return F::from_bits(a).ulps_up(n).bits(); });
      },
      nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("a"), nb::arg("n"));
  module.def(
      "fp_ulps_down",
      [](int e, int m, Bits a, std::uint32_t n) {
        return in_format(e, m, [&]<typename F>() { return F::from_bits(a).ulps_down(n).bits(); });
      },
      nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("a"), nb::arg("n"));
  module.def(
      "fp_from_double",
      [](int e, int m, double value) {
        return in_format(e, m, [&]<typename F>() { return F::from_double(value).bits(); });
      },
      nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("value"),
      "Bits of the value of the format nearest to a float, ties to even.");
  module.def(
      "fp_to_double", [](int e, int m, Bits a) { return value_of_bits(Format{e, m}, a); },
      nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("a"));
}

}  // namespace ti
