// SPDX-License-Identifier: Apache-2.0
#include "cli/hardcase_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <utility>

#include "base/error.hpp"

namespace ti {
namespace {

using nlohmann::json;

constexpr std::array<std::pair<std::string_view, CaseRule>, 6> kRules{{
    {"exact", CaseRule::Exact},
    {"watertight", CaseRule::Watertight},
    {"nohit", CaseRule::NoHit},
    {"tie", CaseRule::Tie},
    {"policy", CaseRule::Policy},
    {"self", CaseRule::Self},
}};

/// Where in which file, for the sentence of an error.
struct Place {
  const std::filesystem::path& path;
  std::size_t line;

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(fmt::format("{}, line {}: {}.", path.string(), line, what));
  }
};

const json& field(const json& object, const char* key, const Place& place) {
  const auto found = object.find(key);
  if (found == object.end()) {
    place.fail(fmt::format("the field \"{}\" is missing", key));
  }
  return *found;
}

std::string text_field(const json& object, const char* key, const Place& place) {
  const json& value = field(object, key, place);
  if (!value.is_string()) {
    place.fail(fmt::format("the field \"{}\" must be a string", key));
  }
  return value.get<std::string>();
}

float word(const json& value, const char* key, const Place& place) {
  const auto text = value.is_string() ? value.get<std::string>() : std::string();
  const bool good =
      text.size() == 8 && text.find_first_not_of("0123456789abcdefABCDEF") == text.npos;
  if (!good) {
    place.fail(
        fmt::format("\"{}\" must hold binary32 words of 8 hex digits, not {}", key, value.dump()));
  }
  return std::bit_cast<float>(static_cast<std::uint32_t>(std::stoul(text, nullptr, 16)));
}

glm::vec3 vector(const json& value, const char* key, const Place& place) {
  if (!value.is_array() || value.size() != 3) {
    place.fail(fmt::format("\"{}\" must hold three words for each point or direction", key));
  }
  return {word(value[0], key, place), word(value[1], key, place), word(value[2], key, place)};
}

Mesh mesh(const json& triangles, const Place& place) {
  if (!triangles.is_array()) {
    place.fail("\"tris\" must be a list of triangles");
  }
  Mesh result;
  for (const json& triangle : triangles) {
    if (!triangle.is_array() || triangle.size() != 3) {
      place.fail("\"tris\" must hold triangles of three corners");
    }
    const auto first = static_cast<std::uint32_t>(result.vertices.size());
    for (const json& corner : triangle) {
      result.vertices.push_back(vector(corner, "tris", place));
    }
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

CaseRule rule(const std::string& text, const Place& place) {
  const auto* found = std::find_if(kRules.begin(), kRules.end(),
                                   [&text](const auto& entry) { return entry.first == text; });
  if (found == kRules.end()) {
    place.fail(fmt::format(
        "the rule \"{}\" is not one of exact, watertight, nohit, tie, policy, self", text));
  }
  return found->second;
}

void read_exact(const json& object, HardCase& c, const Place& place) {
  const json& hit = field(object, "exact_hit", place);
  const json& ids = field(object, "exact_ids", place);
  if (!hit.is_boolean()) {
    place.fail("the field \"exact_hit\" must be true or false");
  }
  c.exact_hit = hit.get<bool>();
  if (!ids.is_array() || ids.empty() == c.exact_hit) {
    place.fail("\"exact_ids\" must be a list, empty exactly when \"exact_hit\" is false");
  }
  for (const json& id : ids) {
    if (!id.is_number_unsigned() || id.get<std::uint64_t>() >= c.mesh.triangles.size()) {
      place.fail(
          fmt::format("\"exact_ids\" names {}, which is not a triangle of \"tris\"", id.dump()));
    }
    c.exact_ids.push_back(id.get<std::int32_t>());
  }
  if (c.exact_hit) {
    c.exact_t = text_field(object, "exact_t", place);
    if (!parse_rational(c.exact_t)) {
      place.fail(fmt::format("\"exact_t\" must be an integer, a fraction or a decimal, not \"{}\"",
                             c.exact_t));
    }
  }
}

HardCase parse(const json& object, const Place& place) {
  if (!object.is_object()) {
    place.fail("a case must be a JSON object");
  }
  HardCase c;
  const json& n = field(object, "n", place);
  if (!n.is_number_integer()) {
    place.fail("the field \"n\" must be an integer");
  }
  c.n = n.get<int>();
  c.name = text_field(object, "name", place);
  c.rule = rule(text_field(object, "rule", place), place);
  c.ray.o = vector(field(object, "o", place), "o", place);
  c.ray.d = vector(field(object, "d", place), "d", place);
  c.ray.tmin = word(field(object, "tmin", place), "tmin", place);
  c.ray.tmax = word(field(object, "tmax", place), "tmax", place);
  c.mesh = mesh(field(object, "tris", place), place);
  read_exact(object, c, place);
  return c;
}

}  // namespace

std::optional<mpq_class> parse_rational(const std::string& text) {
  static const std::regex form(R"(([+-]?)(\d+)(?:/(\d+)|\.(\d+))?)");
  std::smatch parts;
  if (text.size() > 1000 || !std::regex_match(text, parts, form)) {
    return std::nullopt;
  }
  mpz_class num(parts[2].str() + parts[4].str(), 10);
  mpz_class den(parts[3].matched ? parts[3].str() : "1" + std::string(parts[4].str().size(), '0'),
                10);
  if (den == 0) {
    return std::nullopt;
  }
  mpq_class value(parts[1].str() == "-" ? mpz_class(-num) : num, den);
  value.canonicalize();
  return value;
}

std::string_view rule_name(CaseRule rule) {
  return std::find_if(kRules.begin(), kRules.end(),
                      [rule](const auto& entry) { return entry.second == rule; })
      ->first;
}

std::vector<HardCase> load_hardcases(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path)) {
    throw Error(
        fmt::format("{}: the file of hard cases cannot be read; check the name.", path.string()));
  }
  std::vector<HardCase> cases;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) {
      continue;
    }
    const Place place{path, number};
    const json object = json::parse(line, nullptr, false);
    if (object.is_discarded()) {
      place.fail("this is not JSON");
    }
    cases.push_back(parse(object, place));
  }
  if (cases.empty()) {
    throw Error(
        fmt::format("{}: the file holds no case; write one JSON object a line.", path.string()));
  }
  return cases;
}

}  // namespace ti
