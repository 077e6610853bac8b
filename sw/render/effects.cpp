// SPDX-License-Identifier: Apache-2.0
#include "render/effects.hpp"

#include <fmt/format.h>

#include <optional>

#include "base/error.hpp"

namespace ti {

namespace {

constexpr std::array<std::string_view, kEffects> kNames{
    "shadows",  "soft-shadows", "interreflection", "glossy",   "mirror", "glass", "lens",
    "roulette", "ao",           "motion",          "dim-paths"};

std::optional<std::size_t> find(std::string_view name) {
  for (std::size_t i = 0; i < kEffects; ++i)
    if (kNames[i] == name) return i;
  return std::nullopt;
}

}  // namespace

std::string_view name_of(Effect effect) { return kNames[static_cast<std::size_t>(effect)]; }

EffectRequest EffectRequest::of(const std::string& text) {
  const auto fail = [&text](std::string_view word) {
    std::string names;
    for (const std::string_view name : kNames) names += fmt::format(" {}", name);
    return Error(fmt::format(
        "EFFECTS={}: `{}` is no effect; give auto, all or none, then effects with + or -, as in "
        "auto-glossy; there are{}",
        text, word, names));
  };
  EffectRequest request;
  // A name may hold a minus, so the longest name behind a sign is the word.
  std::size_t at = 0;
  const auto word_at = [&text](std::size_t begin) {
    std::size_t end = text.find_first_of("+-", begin);
    while (end != std::string::npos && !find(text.substr(begin, end - begin))) {
      const std::size_t longer = text.find_first_of("+-", end + 1);
      if (!find(text.substr(begin, longer == std::string::npos ? longer : longer - begin))) break;
      end = longer;
    }
    return text.substr(begin, end == std::string::npos ? end : end - begin);
  };
  const std::string first = word_at(0);
  if (first == "all")
    request.base = Base::All;
  else if (first == "none")
    request.base = Base::None;
  else if (const auto effect = find(first)) {
    request.base = Base::None;
    request.added.set(*effect);
  } else if (first != "auto") {
    throw fail(first);
  }
  for (at = first.size(); at < text.size();) {
    const bool add = text[at] == '+';
    const std::string word = word_at(at + 1);
    const auto effect = find(word);
    if (!effect) throw fail(word);
    request.added.set(*effect, add);
    request.removed.set(*effect, !add);
    at += 1 + word.size();
  }
  return request;
}

}  // namespace ti
