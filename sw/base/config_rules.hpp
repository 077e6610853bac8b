// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace ti {

struct Config;

/// What a value of `config.json` must be, by the type of its key; `allowed` says it in words.
struct IntRule {
  const char* name;
  int Config::* member;
  int low;
  int high;
  bool power;  ///< only powers of two
  const char* allowed;
};

struct BoolRule {
  const char* name;
  bool Config::* member;
  const char* allowed;
};

struct FloatRule {
  const char* name;
  double Config::* member;
  double low;
  double high;
  const char* allowed;
};

/// The value is one of `names`; its place there is the number of the enumerator.
template <typename Enum>
struct EnumRule {
  const char* name;
  Enum Config::* member;
  std::span<const char* const> names;
  const char* allowed;
};

}  // namespace ti
