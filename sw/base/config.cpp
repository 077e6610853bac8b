// SPDX-License-Identifier: Apache-2.0
#include "base/config.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "io/file.hpp"

namespace ti {

namespace {

using Json = nlohmann::json;

constexpr const char* kCure = "write it again with scripts/configure.py";

/// The whole number under `key`, which must lie in [low, high].
int integer(const Json& json, const std::string& file, const char* key, int low, int high) {
  const auto it = json.find(key);
  if (it == json.end()) {
    throw Error(fmt::format("{}: the key `{}` is missing; {}", file, key, kCure));
  }
  const bool fits = it->is_number_integer() && *it >= low && *it <= high;
  if (!fits) {
    throw Error(fmt::format("{}: `{}` must be a whole number from {} to {}; {}", file, key, low,
                            high, kCure));
  }
  return it->get<int>();
}

}  // namespace

Config load_config(const std::filesystem::path& path) {
  const std::string file = path.string();
  const Json json = Json::parse(read_file(path), nullptr, false);
  if (!json.is_object()) {
    throw Error(fmt::format("{}: this is not a JSON object; {}", file, kCure));
  }
  const auto name = json.find("name");
  if (name == json.end() || !name->is_string()) {
    throw Error(fmt::format("{}: the key `name` is missing or not a string; {}", file, kCure));
  }
  constexpr int kMany = 1 << 20;
  Config c;
  c.name = name->get<std::string>();
  c.json = json.dump();
  c.format.exp_bits = integer(json, file, "exp_bits", 3, 8);
  c.format.frac_bits = integer(json, file, "frac_bits", 2, 23);
  c.num_trv = integer(json, file, "num_trv", 1, kMany);
  c.num_list = integer(json, file, "num_list", 1, kMany);
  c.num_ist1 = integer(json, file, "num_ist1", 1, kMany);
  c.trv_slots = integer(json, file, "trv_slots", 1, kMany);
  c.stack_depth = integer(json, file, "stack_depth", 1, kMany);
  c.line_bytes = integer(json, file, "line_bytes", 1, kMany);
  c.deal_tile = integer(json, file, "deal_tile", 1, kMany);
  c.watchdog_steps = integer(json, file, "watchdog_steps", 1, 65535);
  c.clock_mhz = integer(json, file, "clock_mhz", 1, kMany);
  return c;
}

}  // namespace ti
