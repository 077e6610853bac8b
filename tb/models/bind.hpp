// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

namespace ti {

/// Operators of `model/fp.hpp`: `fp_add(format, a, b)` and so on, and the class `Format`.
void bind_fp(nanobind::module_& module);

/// The units' arithmetic: `clip`, `split_distance`, `choose`, `ordered`, `pass_a`, `pass_b`,
/// `pass_c`.
void bind_units(nanobind::module_& module);

/// The builder and the tracer: classes `Image` and `Tracer`.
void bind_scene(nanobind::module_& module);

/// `bounds_used(format)`: the error bounds that model, truth and scene lean on.
void bind_bounds(nanobind::module_& module);

}  // namespace ti
