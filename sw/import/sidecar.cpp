// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "import/import.hpp"
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

 private:
  std::string file_;
};

Camera camera_of(const Json& json, const Reader& read) {
  if (!json.is_object()) read.fail("camera", "an object with eye and target");
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
  if (camera.eye == camera.target) read.fail("camera.target", "another point than `camera.eye`");
  return camera;
}

std::vector<PointLight> lights_of(const Json& json, const Reader& read) {
  if (!json.is_array()) read.fail("lights", "an array");
  std::vector<PointLight> lights;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const Json& item = json[i];
    const std::string place = fmt::format("lights[{}]", i);
    if (!item.is_array() || (item.size() != 3 && item.size() != 6)) {
      read.fail(place, "an array of 3 or 6 numbers (x y z, r g b)");
    }
    PointLight light;
    light.position = read.vector(Json(item.begin(), item.begin() + 3), place);
    if (item.size() == 6) light.intensity = read.vector(item, place, 3);
    if (std::min({light.intensity.x, light.intensity.y, light.intensity.z}) < 0.0F) {
      read.fail(place, "a light that is not negative");
    }
    lights.push_back(light);
  }
  return lights;
}

std::vector<Material> materials_of(const Json& json, const Reader& read) {
  if (!json.is_array()) read.fail("materials", "an array");
  std::vector<Material> materials;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const Json& item = json[i];
    const std::string place = fmt::format("materials[{}]", i);
    if (!item.is_object()) read.fail(place, "an object");
    Material material;
    if (item.contains("name")) {
      if (!item["name"].is_string()) read.fail(place + ".name", "a string");
      material.name = item["name"].get<std::string>();
    }
    if (item.contains("Kd")) material.diffuse = read.colour(item["Kd"], place + ".Kd");
    if (item.contains("Ke")) material.emission = read.colour(item["Ke"], place + ".Ke");
    materials.push_back(std::move(material));
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
  if (json.contains("materials")) {
    auto materials = materials_of(json["materials"], read);
    if (!import.has_materials && !materials.empty()) {
      scene.materials = std::move(materials);
      import.has_materials = true;
    }
  }
}

}  // namespace ti
