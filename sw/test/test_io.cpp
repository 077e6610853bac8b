// SPDX-License-Identifier: Apache-2.0
// Arrays survive a round trip bit for bit, every malformed one is refused by name, and pictures and
// configurations are whole.
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "base/config.hpp"
#include "base/limits.hpp"
#include "io/file.hpp"
#include "io/npy.hpp"
#include "io/png.hpp"
#include "test/support.hpp"

namespace {

using namespace ti;
using namespace ti::test;

/// A .npy of format `major`.0 with this header and this many bytes of data.
std::string npy(const std::string& dict, std::size_t data, int major = 1) {
  std::string bytes("\x93NUMPY", 6);
  bytes.push_back(static_cast<char>(major));
  bytes.push_back(0);
  for (int i = 0; i < (major == 1 ? 2 : 4); ++i) {
    bytes.push_back(static_cast<char>(dict.size() >> (8 * i) & 0xFF));
  }
  return bytes + dict + std::string(data, '\0');
}

std::string header(const std::string& descr, const std::string& shape,
                   const std::string& fortran = "False") {
  return "{'descr': '" + descr + "', 'fortran_order': " + fortran + ", 'shape': " + shape + ", }\n";
}

TEST_CASE("rays survive a round trip bit for bit") {
  const TempDir dir;
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Ray> rays{
      {.o = {1.0F, -0.0F, 1e-42F}, .tmin = 0.5F, .d = {nan, inf, -inf}, .tmax = 3e38F}, {}};
  write_file(dir / "a/b/rays.npy", rays_npy(rays));
  const auto back = load_rays(dir / "a/b/rays.npy");
  REQUIRE(back.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    for (int k = 0; k < 3; ++k) {
      CHECK(std::bit_cast<std::uint32_t>(back[i].o[k]) ==
            std::bit_cast<std::uint32_t>(rays[i].o[k]));
      CHECK(std::bit_cast<std::uint32_t>(back[i].d[k]) ==
            std::bit_cast<std::uint32_t>(rays[i].d[k]));
    }
    CHECK(back[i].tmin == rays[i].tmin);
    CHECK(back[i].tmax == rays[i].tmax);
    CHECK_FALSE(back[i].any);
  }
}

TEST_CASE("an array of no rays is written and read") {
  const TempDir dir;
  write_file(dir / "rays.npy", rays_npy({}));
  CHECK(load_rays(dir / "rays.npy").empty());
}

TEST_CASE("arrays have the header and the data that NumPy writes") {
  const TempDir dir;
  const std::vector<Hit> hits{{.t = 1.0F, .u = 0.25F, .v = 0.5F, .prim = 7}, {}};
  write_file(dir / "prims.npy", prims_npy(hits));
  const std::string prims = bytes_of(dir / "prims.npy");
  const std::string dict = "{'descr': '<i4', 'fortran_order': False, 'shape': (2,), }";
  const std::string head = std::string("\x93NUMPY\x01\x00\x76\x00", 10) + dict;
  CHECK(prims == head + std::string(127 - head.size(), ' ') + "\n" +
                     std::string("\x07\x00\x00\x00\xFF\xFF\xFF\xFF", 8));
  write_file(dir / "hits.npy", hits_npy(hits));
  const std::string out = bytes_of(dir / "hits.npy");
  CHECK(out.find("'<f4'") != std::string::npos);
  CHECK(out.find("(2, 3)") != std::string::npos);
  CHECK(out.size() == 128 + 24);
  CHECK(out.substr(128, 4) == std::string("\x00\x00\x80\x3F", 4));
  CHECK(out.substr(140, 4) == std::string("\x00\x00\x80\x7F", 4));
}

TEST_CASE("format 2.0 and other spellings of the header are read") {
  const TempDir dir;
  CHECK(load_rays(dir.file("v2.npy", npy(header("<f4", "(3, 8)"), 96, 2))).size() == 3);
  const std::string odd = R"({"shape":(3,8,),"fortran_order":False,"descr":"<f4"})";
  CHECK(load_rays(dir.file("odd.npy", npy(odd, 96))).size() == 3);
}

TEST_CASE("each malformed array is refused by what is wrong with it") {
  const TempDir dir;
  struct Case {
    std::string bytes;
    std::string word;
  };
  const std::string good = npy(header("<f4", "(3, 8)"), 96);
  const std::vector<Case> cases{
      {"", "not a .npy"},
      {"not numpy at all", "not a .npy"},
      {good.substr(0, 9), "not a .npy"},
      {npy(header("<f4", "(3, 8)"), 96, 3), "3.0"},
      {good.substr(0, 30), "cut in its header"},
      {npy("{'descr': '<f4', 'shape': (3, 8)}", 96), "malformed"},
      {npy("{'descr': '<f4', 'fortran_order': False, 'shape': (3, 8), } x", 96), "malformed"},
      {npy("{'descr': '<f4', 'fortran_order': False, 'shape': (-3, 8), }", 96), "malformed"},
      {npy("{'descr': '<f4', 'fortran_order': 0, 'shape': (3, 8), }", 96), "malformed"},
      {npy("{'descr': '<f4", 96), "malformed"},
      {npy(header("<f4", "(99999999999999999999999, 8)"), 96), "malformed"},
      {npy(header("<f8", "(3, 8)"), 192), "'<f8'"},
      {npy(header(">f4", "(3, 8)"), 96), "'>f4'"},
      {npy(header("<i4", "(3, 8)"), 96), "'<i4'"},
      {npy(header("<f4", "(24,)"), 96), "(24)"},
      {npy(header("<f4", "(8, 3)"), 96), "(8, 3)"},
      {npy(header("<f4", "()"), 96), "(N, 8)"},
      {npy(header("<f4", "(1, 3, 8)"), 96), "(1, 3, 8)"},
      {npy(header("<f4", "(3, 8)", "True"), 96), "Fortran"},
      {npy(header("<f4", "(3, 8)"), 95), "is cut"},
      {npy(header("<f4", "(1152921504606846977, 8)"), 32), "is cut"},
      {npy(header("<f4", "(3, 8)"), 97), "1 bytes follow"},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    CAPTURE(i);
    const auto path = dir.file("bad.npy", cases[i].bytes);
    check_error([&] { (void)load_rays(path); }, {"bad.npy", cases[i].word});
  }
  check_error([&] { (void)load_rays(dir / "none.npy"); }, {"none.npy", "no such file"});
  check_error([&] { (void)load_rays(dir / ""); }, {"folder"});
}

TEST_CASE("an array of more rays than a run holds is refused before it is read") {
  const TempDir dir;
  write_file(dir / "a.npy", rays_npy(std::vector<Ray>(1)));
  std::filesystem::resize_file(dir / "a.npy", (kMaxRays + 5) * 32);  // a hole, which takes no room
  check_error([&] { (void)load_rays(dir / "a.npy"); }, {"a.npy", "2^26"});
}

TEST_CASE("a file is replaced whole and nothing is left beside it") {
  const TempDir dir;
  write_file(dir / "x", "long old text");
  write_file(dir / "x", "new");
  CHECK(read_file(dir / "x") == "new");
  CHECK(dir.count() == 1);
  check_error([&] { write_file(dir / "", "a"); }, {"folder"});
  check_error([&] { write_file(dir / "x/y", "a"); }, {"x", "cannot be made"});
  std::filesystem::create_directory(dir / "sub");
  check_error([&] { write_file(dir / "sub", "a"); }, {"sub", "folder"});
  CHECK(dir.count() == 2);
}

TEST_CASE("a picture has its size and is refused when its colours do not fill it") {
  const TempDir dir;
  std::vector<glm::vec3> colours(6, glm::vec3(0.5F, -1.0F, std::nanf("")));
  colours[5] = glm::vec3(std::numeric_limits<float>::infinity());
  write_file(dir / "p/image.png", png_of(colours, 3, 2));
  const std::string png = bytes_of(dir / "p/image.png");
  REQUIRE(png.size() > 33);
  CHECK(png.substr(0, 8) == "\x89PNG\r\n\x1a\n");
  CHECK(png.substr(16, 10) == std::string("\0\0\0\3\0\0\0\2\x08\x02", 10));
  check_error([&] { (void)png_of(colours, 2, 2); }, {"2x2"});
  check_error([&] { (void)png_of(std::span<const glm::vec3>{}, 0, 2); }, {"0x2"});
  check_error([&] { (void)png_of(std::span<const glm::vec3>{}, 1, 100000); }, {"100000"});
  check_error([&] { (void)png_of(std::span<const glm::vec3>{}, 16384, 8192); }, {"2^26"});
}

/// The value of a key as a configuration file has it: a number, a truth, or the name of a choice.
template <class Rule>
nlohmann::json value_in_file(const Rule& rule, const Config& config) {
  if constexpr (requires { rule.names; }) {
    return rule.names[static_cast<std::size_t>(config.*rule.member)];
  } else {
    return config.*rule.member;
  }
}

/// A configuration with all keys at their defaults, but for those of `changes`.
nlohmann::json config_json(const nlohmann::json& changes = nlohmann::json::object()) {
  nlohmann::json json{{"name", "odd"}};
  const Config defaults;
  each_config_rule([&](const auto& rule) { json[rule.name] = value_in_file(rule, defaults); });
  json.update(changes);
  return json;
}

TEST_CASE("a configuration is read key by key") {
  const TempDir dir;
  const nlohmann::json changes{{"exp_bits", 7},    {"frac_bits", 16},  {"num_trv", 3},
                               {"trv_slots", 8},   {"stack_depth", 5}, {"watchdog_steps", 999},
                               {"clock_mhz", 250}, {"counters", false}};
  const nlohmann::json json = config_json(changes);
  const Config c = load_config(dir.file("config.json", json.dump()));
  CHECK(c.name == "odd");
  CHECK(nlohmann::json::parse(c.json) == json);
  CHECK(c.format == Format{7, 16});
  CHECK(c.num_trv == 3);
  CHECK_FALSE(c.counters);
  each_config_rule([&](const auto& rule) {
    const std::string key = rule.name;
    INFO(key);
    CHECK(json.at(key) == value_in_file(rule, c));
  });
}

TEST_CASE("a configuration with a missing, wrong or unknown key is refused by its name") {
  const TempDir dir;
  const nlohmann::json good = config_json();
  const auto refused = [&](const nlohmann::json& json, const std::vector<std::string>& words) {
    const auto path = dir.file("config.json", json.dump());
    check_error([&] { (void)load_config(path); }, words);
  };
  for (const auto& [key, value] : good.items()) {
    nlohmann::json json = good;
    json.erase(key);
    refused(json, {"config.json", "`" + key + "`", "missing"});
    json = good;
    json[key] = nullptr;
    refused(json, {"config.json", "`" + key + "`", "must be"});
  }
  refused(config_json({{"stack_deep", 1}}), {"config.json", "unknown key `stack_deep`"});
  for (const nlohmann::json& value : nlohmann::json{2, 9, 7.5, "7", true, 1e99, -1}) {
    refused(config_json({{"exp_bits", value}}), {"`exp_bits`", "from 3 to 8"});
  }
  refused(config_json({{"trv_slots", 24}}), {"`trv_slots`", "a power of two from 2 to 256"});
  refused(config_json({{"ist1_choice", "random"}}), {"`ist1_choice`", "one of hash, slot, spill"});
  refused(config_json({{"counters", 1}}), {"`counters`", "true or false"});
  check_error([&] { (void)load_config(dir.file("c.json", "{\"name\": ")); }, {"not a JSON"});
  check_error([&] { (void)load_config(dir.file("c.json", "[]")); }, {"not a JSON"});
  check_error([&] { (void)load_config(dir / "none.json"); }, {"no such file"});
}

}  // namespace
