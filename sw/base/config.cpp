// SPDX-License-Identifier: Apache-2.0
#include "base/config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "io/file.hpp"

namespace ti {

namespace {

using Json = nlohmann::json;

constexpr const char* kCure = "write it again with scripts/configure.py";

/// Each `take` sets the member of a rule; false for a value that the rule does not allow.
bool take(const IntRule& rule, const Json& value, Config& config) {
  if (!value.is_number_integer() || value < rule.low || value > rule.high) return false;
  config.*rule.member = value.get<int>();
  return !rule.power || std::has_single_bit(value.get<unsigned>());
}

bool take(const BoolRule& rule, const Json& value, Config& config) {
  if (!value.is_boolean()) return false;
  config.*rule.member = value.get<bool>();
  return true;
}

[[maybe_unused]] bool take(const FloatRule& rule, const Json& value, Config& config) {
  if (!value.is_number()) return false;
  config.*rule.member = value.get<double>();
  return config.*rule.member >= rule.low && config.*rule.member <= rule.high;
}

template <typename Enum>
bool take(const EnumRule<Enum>& rule, const Json& value, Config& config) {
  if (!value.is_string()) return false;
  const auto it = std::find(rule.names.begin(), rule.names.end(), value.get<std::string>());
  config.*rule.member = static_cast<Enum>(it - rule.names.begin());
  return it != rule.names.end();
}

/// Reads an object, and remembers which of its keys were read.
class Reader {
 public:
  Reader(const Json& json, std::string file) : rest_(json), file_(std::move(file)) {}

  std::string text(const char* key) {
    const Json value = find(key);
    if (!value.is_string()) {
      throw Error(fmt::format("{}: `{}` must be a string; {}", file_, key, kCure));
    }
    return value.get<std::string>();
  }

  template <typename Rule>
  void read(const Rule& rule, Config& config) {
    if (take(rule, find(rule.name), config)) return;
    throw Error(fmt::format("{}: `{}` must be {}; {}", file_, rule.name, rule.allowed, kCure));
  }

  void end() const {
    if (rest_.empty()) return;
    throw Error(fmt::format("{}: unknown key `{}`; {}", file_, rest_.begin().key(), kCure));
  }

 private:
  Json find(const char* key) {
    const auto it = rest_.find(key);
    if (it == rest_.end()) {
      throw Error(fmt::format("{}: the key `{}` is missing; {}", file_, key, kCure));
    }
    Json value = *it;
    rest_.erase(it);
    return value;
  }

  Json rest_;
  std::string file_;
};

}  // namespace

Config load_config(const std::filesystem::path& path) {
  const Json json = Json::parse(read_file(path), nullptr, false);
  if (!json.is_object()) {
    throw Error(fmt::format("{}: this is not a JSON object; {}", path.string(), kCure));
  }
  Reader reader(json, path.string());
  Config config;
  config.name = reader.text("name");
  config.json = json.dump();
  each_config_rule([&](const auto& rule) { reader.read(rule, config); });
  reader.end();
  const bool newton = config.reciprocal == Reciprocal::kNewton;
  config.format = {config.exp_bits,
                   config.frac_bits,
                   {.toward_zero = config.rounding == Rounding::kZero,
                    .flush = config.subnormals == Subnormals::kFlush,
                    .rcp_table_bits = newton ? config.rcp_table_bits : 0,
                    .rcp_newton_steps = newton ? config.rcp_newton_steps : 0}};
  return config;
}

}  // namespace ti
