// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

namespace ti::model {

/// Three values of a format, [0] = x.
template <class F>
using Vec = std::array<F, 3>;

}  // namespace ti::model
