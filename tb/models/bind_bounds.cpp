// SPDX-License-Identifier: Apache-2.0

#include <cmath>

#include "base/format.hpp"
#include "bind.hpp"
#include "formats.hpp"
#include "model/ist1.hpp"
#include "model/rd.hpp"
#include "scene/geometry.hpp"
#include "truth/bounds.hpp"

namespace ti {
namespace {

namespace nb = nanobind;

nb::dict bounds_used(const Format& format) {
  nb::dict all;
  all["half_ulps"] = format.reciprocal_half_ulps();
  all["rounding_unit"] = format.rounding_unit();
  all["underflow_unit"] = format.underflow_unit();
  all["reciprocal_unit"] = format.reciprocal_unit();
  in_format<UnitFormats>(format, [&]<typename F>() {
    const auto places = static_cast<int>(model::thickness_places<F>());
    all["thickness"] = std::ldexp(1.0, format.frac_bits + 1 - places);
    all["outward_ulps"] = model::outward_ulps<F>();
    all["cull_ulps"] = model::cull_ulps<F>();
    return 0;
  });
  all["static_det"] = kStaticBounds.det;
  all["static_dett"] = kStaticBounds.dett;
  all["static_inside"] = kStaticBounds.inside;
  all["static_sum"] = kStaticBounds.sum;
  all["static_sum_det"] = kStaticBounds.sum_det;
  const BoundedOps ops(format);
  all["static_corner"] = static_corner(ops) / ops.u();
  all["static_weight"] = kStaticBounds.weight;
  all["stand_off_test"] = kStandOffTest;
  all["stand_off_point"] = kStandOffPoint;
  return all;
}

}  // namespace

void bind_bounds(nb::module_& module) {
  module.def(
      "bounds_used", &bounds_used, nb::arg("format"),
      "The bounds that the code leans on, by name; `scripts/certify.py` says in what units.");
}

}  // namespace ti
