// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/error.hpp"
#include "import/import.hpp"
#include "import/materials.hpp"
#include "io/file.hpp"

namespace ti {

namespace {

using Json = nlohmann::json;

/// Reads values by the name of their place, so that each complaint can say where.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  [[noreturn]] void fail(const std::string& place, const std::string& what) const {
    throw Error(fmt::format("{}: `{}` must be {}; correct it", file_, place, what));
  }

  [[nodiscard]] float number(const Json& json, const std::string& place) const {
    if (!json.is_number()) fail(place, "a number");
    const float value = json.get<float>();
    if (!std::isfinite(value)) fail(place, "a number in the range of float32");
    return value;
  }

  /// Three numbers from position `first` of an array.
  [[nodiscard]] glm::vec3 vector(const Json& json, const std::string& place,
                                 std::size_t first = 0) const {
    if (!json.is_array() || json.size() < first + 3 || (first == 0 && json.size() != 3)) {
      fail(place, "an array of 3 numbers");
    }
    glm::vec3 v;
    for (std::size_t i = 0; i < 3; ++i) {
      v[static_cast<int>(i)] = number(json[first + i], fmt::format("{}[{}]", place, first + i));
    }
    return v;
  }

  [[nodiscard]] glm::vec3 colour(const Json& json, const std::string& place) const {
    const glm::vec3 c = vector(json, place);
    if (std::min({c.x, c.y, c.z}) < 0.0F) fail(place, "3 numbers that are not negative");
    return c;
  }

  /// Refuses a key that is none of these.
  void only(const Json& json, const std::string& place,
            std::initializer_list<std::string_view> keys) const {
    for (const auto& [key, value] : json.items()) {
      if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
      throw Error(fmt::format("{}: `{}.{}` is not known; there are {}", file_, place, key,
                              fmt::join(keys, ", ")));
    }
  }

 private:
  std::string file_;
};

Camera camera_of(const Json& json, const Reader& read) {
  if (!json.is_object()) read.fail("camera", "an object with eye and target");
  read.only(json, "camera", {"eye", "target", "up", "fov_y_deg", "aperture", "focus_distance"});
  Camera camera;
  for (const char* key : {"eye", "target"}) {
    if (!json.contains(key)) read.fail(fmt::format("camera.{}", key), "there, as 3 numbers");
  }
  camera.eye = read.vector(json["eye"], "camera.eye");
  camera.target = read.vector(json["target"], "camera.target");
  if (json.contains("up")) camera.up = read.vector(json["up"], "camera.up");
  if (json.contains("fov_y_deg")) {
    camera.fov_y_deg = read.number(json["fov_y_deg"], "camera.fov_y_deg");
    if (!(camera.fov_y_deg > 0.0F && camera.fov_y_deg < 180.0F)) {
      read.fail("camera.fov_y_deg", "above 0 and below 180 degrees");
    }
  }
  for (const auto& [key, target] :
       {std::pair{"aperture", &camera.aperture}, {"focus_distance", &camera.focus_distance}}) {
    if (!json.contains(key)) continue;
    const std::string place = fmt::format("camera.{}", key);
    *target = read.number(json[key], place);
    if (*target < 0.0F) read.fail(place, "a number that is not negative");
  }
  if (camera.eye == camera.target) read.fail("camera.target", "another point than `camera.eye`");
  return camera;
}

/// [x, y, z] or [x, y, z, r, g, b]: a point light.
Light point_of(const Json& json, const std::string& place, const Reader& read) {
  if (json.size() != 3 && json.size() != 6)
    read.fail(place, "an array of 3 or 6 numbers (x y z, r g b)");
  Light light;
  light.position = read.vector(Json(json.begin(), json.begin() + 3), place);
  if (json.size() == 6) light.intensity = read.vector(json, place, 3);
  if (std::min({light.intensity.x, light.intensity.y, light.intensity.z}) < 0.0F)
    read.fail(place, "a light that is not negative");
  return light;
}

/// {"kind": "point" | "spot" | "directional", ...}.
Light light_of(const Json& json, const std::string& place, const Reader& read) {
  read.only(
      json, place,
      {"kind", "name", "position", "direction", "intensity", "range", "inner_deg", "outer_deg"});
  Light light;
  const std::string kind = json.value("kind", Json("point")).is_string()
                               ? json.value("kind", std::string("point"))
                               : std::string();
  const std::map<std::string, LightKind> kinds{{"point", LightKind::Point},
                                               {"spot", LightKind::Spot},
                                               {"directional", LightKind::Directional}};
  const auto found = kinds.find(kind);
  if (found == kinds.end()) read.fail(place + ".kind", "point, spot or directional");
  light.kind = found->second;
  if (json.contains("name") && json["name"].is_string()) light.name = json["name"];
  const auto need = [&](const char* key) {
    if (!json.contains(key)) read.fail(fmt::format("{}.{}", place, key), "there, as 3 numbers");
    return read.vector(json[key], fmt::format("{}.{}", place, key));
  };
  if (light.kind != LightKind::Directional) light.position = need("position");
  if (light.kind != LightKind::Point) light.direction = need("direction");
  if (json.contains("intensity"))
    light.intensity = read.colour(json["intensity"], place + ".intensity");
  if (json.contains("range")) light.range = read.number(json["range"], place + ".range");
  constexpr double kRadian = 3.14159265358979323846 / 180.0;
  double inner = 0.0;
  double outer = 45.0;
  if (json.contains("inner_deg")) inner = read.number(json["inner_deg"], place + ".inner_deg");
  if (json.contains("outer_deg")) outer = read.number(json["outer_deg"], place + ".outer_deg");
  if (!(inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= 90.0))
    read.fail(place + ".outer_deg", "above 0, up to 90, and not below `inner_deg`");
  light.cos_inner = static_cast<float>(std::cos(inner * kRadian));
  light.cos_outer = static_cast<float>(std::cos(outer * kRadian));
  return light;
}

std::vector<Light> lights_of(const Json& json, const Reader& read) {
  if (!json.is_array()) read.fail("lights", "an array");
  std::vector<Light> lights;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string place = fmt::format("lights[{}]", i);
    if (json[i].is_array())
      lights.push_back(point_of(json[i], place, read));
    else if (json[i].is_object())
      lights.push_back(light_of(json[i], place, read));
    else
      read.fail(place, "an array of numbers or an object with `kind`");
  }
  return lights;
}

std::vector<Material> materials_of(const Json& json, const Reader& read) {
  if (!json.is_array()) read.fail("materials", "an array");
  std::vector<Material> materials;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const Json& item = json[i];
    std::string place = fmt::format("materials[{}]", i);
    if (!item.is_object()) read.fail(place, "an object");
    MtlValues values;
    if (item.contains("name")) {
      if (!item["name"].is_string()) read.fail(place + ".name", "a string");
      values.name = item["name"].get<std::string>();
      place += fmt::format(" ({})", values.name);
    }
    const auto colour = [&](const char* key, auto& target) {
      if (item.contains(key)) target = read.colour(item[key], fmt::format("{}.{}", place, key));
    };
    const auto number = [&](const char* key, std::optional<float>& target, float most) {
      if (!item.contains(key)) return;
      const std::string where = fmt::format("{}.{}", place, key);
      target = read.number(item[key], where);
      if (*target < 0.0F || *target > most)
        read.fail(where, most < 2.0F ? "a number from 0 to 1" : "a number that is not negative");
    };
    colour("Kd", values.kd);
    colour("Ks", values.ks);
    colour("Ke", values.ke);
    colour("Tf", values.tf);
    constexpr float kAny = std::numeric_limits<float>::max();
    number("Ns", values.ns, kAny);
    number("Ni", values.ni, kAny);
    number("Tr", values.tr, 1.0F);
    std::optional<float> opacity;
    number("d", opacity, 1.0F);
    if (opacity && !values.tr) values.tr = 1.0F - *opacity;
    if (item.contains("illum")) {
      const Json& illum = item["illum"];
      if (!illum.is_number_integer() || illum < 0 || illum > 10)
        read.fail(place + ".illum", "a whole number from 0 to 10");
      values.illum = illum.get<int>();
    }
    materials.push_back(material_of(values));
  }
  return materials;
}

Json parse(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& e) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(e.byte, text.size()));
    throw Error(fmt::format("{}: line {} is not valid JSON; correct it", path.string(),
                            1 + std::count(text.begin(), end, '\n')));
  } catch (const Json::exception&) {
    throw Error(path.string() + ": a number is too large for JSON; correct it");
  }
}

}  // namespace

void apply_sidecar(Import& import, const std::filesystem::path& path) {
  const Json json = parse(path);
  const Reader read(path.string());
  if (!json.is_object()) {
    throw Error(path.string() + ": a scene description must be a JSON object; correct it");
  }
  Scene& scene = import.scene;
  if (json.contains("camera")) {
    const Camera camera = camera_of(json["camera"], read);
    if (!import.has_camera) scene.camera = camera;
    import.has_camera = true;
  }
  if (json.contains("lights")) {
    const auto lights = lights_of(json["lights"], read);
    if (scene.lights.empty()) scene.lights = lights;
  }
  if (json.contains("background")) scene.background = read.colour(json["background"], "background");
  if (json.contains("materials")) {
    auto materials = materials_of(json["materials"], read);
    if (!import.has_materials && !materials.empty()) {
      scene.materials = std::move(materials);
      import.has_materials = true;
    }
  }
}

}  // namespace ti
