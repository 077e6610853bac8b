// SPDX-License-Identifier: Apache-2.0

#include <cstdint>

#include "base/format.hpp"
#include "bind.hpp"
#include "formats.hpp"

namespace ti {
namespace {

namespace nb = nanobind;
using Bits = std::uint32_t;

/// Binds `fp_<name>(format, a, b)`, an operation on two values.
template <typename Operation>
void bind_binary(nb::module_& module, const char* name, Operation operation) {
  module.def(
      name,
      [operation](const Format& format, Bits a, Bits b) {
        return in_format<FpFormats>(
            format, [&]<typename F>() { return operation(F::from_bits(a), F::from_bits(b)); });
      },
      nb::arg("format"), nb::arg("a"), nb::arg("b"));
}

}  // namespace

void bind_fp(nb::module_& module) {
  nb::class_<Format>(module, "Format", "A number format with its modes.")
      .def(
          "__init__",
          [](Format* self, int e, int m, bool toward_zero, bool flush, int table_bits, int steps) {
            if (e < 3 || e > 8 || m < 2 || m > 23) throw nb::value_error("from (3, 2) to (8, 23)");
            new (self) Format{e, m, {toward_zero, flush, table_bits, table_bits > 0 ? steps : 0}};
          },
          nb::arg("exp_bits"), nb::arg("frac_bits"), nb::arg("toward_zero") = false,
          nb::arg("flush") = false, nb::arg("table_bits") = 0, nb::arg("newton_steps") = 0)
      .def_prop_ro("reciprocal_half_ulps", &Format::reciprocal_half_ulps)
      .def("__repr__", &name_of);
  bind_binary(module, "fp_add", [](auto a, auto b) { return (a + b).bits(); });
  bind_binary(module, "fp_sub", [](auto a, auto b) { return (a - b).bits(); });
  bind_binary(module, "fp_mul", [](auto a, auto b) { return (a * b).bits(); });
  bind_binary(module, "fp_lt", [](auto a, auto b) { return a < b; });
  bind_binary(module, "fp_le", [](auto a, auto b) { return a <= b; });
  bind_binary(module, "fp_eq", [](auto a, auto b) { return a == b; });
  module.def(
      "fp_rcp",
      [](const Format& format, Bits a) {
        return in_format<FpFormats>(
            format, [&]<typename F>() { return reciprocal(F::from_bits(a)).bits(); });
      },
      nb::arg("format"), nb::arg("a"));
  module.def(
      "fp_ulps_up",
      [](const Format& format, Bits a, std::uint32_t n) {
        return in_format<FpFormats>(
            format, [&]<typename F>() { return F::from_bits(a).ulps_up(n).bits(); });
      },
      nb::arg("format"), nb::arg("a"), nb::arg("n"));
  module.def(
      "fp_ulps_down",
      [](const Format& format, Bits a, std::uint32_t n) {
        return in_format<FpFormats>(
            format, [&]<typename F>() { return F::from_bits(a).ulps_down(n).bits(); });
      },
      nb::arg("format"), nb::arg("a"), nb::arg("n"));
  module.def(
      "fp_from_double",
      [](const Format& format, double value) {
        return in_format<FpFormats>(format,
                                    [&]<typename F>() { return F::from_double(value).bits(); });
      },
      nb::arg("format"), nb::arg("value"),
      "Bits of the value of the format nearest to a float, ties to even.");
  module.def(
      "fp_to_double", [](const Format& format, Bits a) { return value_of_bits(format, a); },
      nb::arg("format"), nb::arg("a"));
}

}  // namespace ti
