// SPDX-License-Identifier: Apache-2.0
#include "cli/frames.hpp"

#include <fmt/core.h>

#include <charconv>
#include <string_view>

#include "base/error.hpp"

namespace ti {

FrameRange parse_frames(const std::string& text, int available) {
  const auto number = [&text](std::string_view word, int otherwise) {
    if (word.empty()) return otherwise;
    int value = 0;
    const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (status != std::errc() || end != word.data() + word.size() || value < 0)
      throw Error(
          fmt::format("FRAMES={}: give A:B, from frame A up to but without B, or a number", text));
    return value;
  };
  const std::string_view all(text);
  const std::size_t colon = all.find(':');
  FrameRange range;
  range.first = number(all.substr(0, colon), 0);
  range.end =
      colon == std::string_view::npos ? range.first + 1 : number(all.substr(colon + 1), available);
  if (range.first >= range.end || range.end > available)
    throw Error(fmt::format("FRAMES={}: the scene has {}", text,
                            available == 1
                                ? std::string("one frame, 0")
                                : fmt::format("{} frames, 0 to {}", available, available - 1)));
  return range;
}

}  // namespace ti
