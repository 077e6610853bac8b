// SPDX-License-Identifier: Apache-2.0

#include <cstdint>

#include "base/format.hpp"
#include "bind.hpp"
#include "formats.hpp"

namespace ti {
namespace {

namespace nb = nanobind;
using Bits = std::uint32_t;

/// Binds `fp_<name>(e, m, a, b)`, an operation on two values.
template <typename Operation>
void bind_binary(nb::module_& module, const char* name, Operation operation) {
  module.def(
      name,
      [operation](int e, int m, Bits a, Bits b) {
        return in_format<FpFormats>(
            e, m, [&]<typename F>() { return operation(F::from_bits(a), F::from_bits(b)); });
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
        return in_format<FpFormats>(
            e, m, [&]<typename F>() { return reciprocal(F::from_bits(a)).bits(); });
      },
      nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("a"));
  module.def(
      "fp_ulps_up",
      [](int e, int m, Bits a, std::uint32_t n) {
        return in_format<FpFormats>(
            e, m, [&]<typename F>() { return F::from_bits(a).ulps_up(n).bits(); });
      },
      nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("a"), nb::arg("n"));
  module.def(
      "fp_ulps_down",
      [](int e, int m, Bits a, std::uint32_t n) {
        return in_format<FpFormats>(
            e, m, [&]<typename F>() { return F::from_bits(a).ulps_down(n).bits(); });
      },
      nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("a"), nb::arg("n"));
  module.def(
      "fp_from_double",
      [](int e, int m, double value) {
        return in_format<FpFormats>(e, m,
                                    [&]<typename F>() { return F::from_double(value).bits(); });
      },
      nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("value"),
      "Bits of the value of the format nearest to a float, ties to even.");
  module.def(
      "fp_to_double", [](int e, int m, Bits a) { return value_of_bits(Format{e, m}, a); },
      nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("a"));
}

}  // namespace ti
