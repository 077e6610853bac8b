// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

namespace ti {

/// An animated PNG of pictures of one size and kind, played for ever: the third edition of the PNG
/// specification, with the pictures' compressed data as they are. `seconds` is how long each
/// stands, to the millisecond. Throws `std::invalid_argument` when there is none or one is no PNG.
[[nodiscard]] std::string apng_of(std::span<const std::string> pngs, double seconds);

}  // namespace ti
