// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <charconv>
#include <string_view>
#include <system_error>

namespace ti {

/// The next word of `text`, which is shortened, between characters of `blank`; empty at the end.
inline std::string_view next_word(std::string_view& text, std::string_view blank) {
  text.remove_prefix(std::min(text.find_first_not_of(blank), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(blank));
  text.remove_prefix(word.size());
  return word;
}

/// Whether `word` is a number, and which; one that is out of the range of T leaves `value` alone.
template <typename T>
[[nodiscard]] bool parse_number(std::string_view word, T& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, ec] = std::from_chars(word.data(), word.data() + word.size(), value);
  return ec != std::errc::invalid_argument && end == word.data() + word.size();
}

}  // namespace ti
