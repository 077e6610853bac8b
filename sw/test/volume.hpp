// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace ti::test {

/// Rays of a test in volume: a tenth of `rays` where sanitizers make each ten times as long.
constexpr std::size_t volume(std::size_t rays) {
#ifdef TI_SANITIZE
  return rays / 10;
#else
  return rays;
#endif
}

}  // namespace ti::test
