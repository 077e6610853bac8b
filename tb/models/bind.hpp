// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

namespace ti {

/// Operators of `model/fp.hpp`: `fp_add(exp_bits, frac_bits, a, b)` and so on.
void bind_fp(nanobind::module_& module);

}  // namespace ti
