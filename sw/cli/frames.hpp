// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ti {

/// Frames [first, end) of an animation.
struct FrameRange {
  int first = 0;
  int end = 1;

  [[nodiscard]] int count() const { return end - first; }
};

/// `A:B` as in Python: from A up to but without B, either left out; or the number of one frame.
/// `available` is how many there are. Throws `Error` in one sentence for anything else.
[[nodiscard]] FrameRange parse_frames(const std::string& text, int available);

}  // namespace ti
