// SPDX-License-Identifier: Apache-2.0

#include <nanobind/nanobind.h>

#include "bind.hpp"

/// Python module `ti_model`: the C++ model of `sw/model`, in process with the cocotb tests.
NB_MODULE(ti_model, module) {
  module.doc() = "Bit-exact model of the engine; numbers are bit patterns in unsigned integers.";
  ti::bind_fp(module);
  ti::bind_units(module);
  ti::bind_scene(module);
  ti::bind_bounds(module);
}
