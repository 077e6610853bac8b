// SPDX-License-Identifier: Apache-2.0
#include "import/gltf_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "import/materials.hpp"

namespace ti {

namespace {

using Json = nlohmann::json;

constexpr double kPi = 3.14159265358979323846;

/// Reads the fields of one object and says which of them is wrong.
class Fields {
 public:
  Fields(const Json& json, std::string what) : json_(json), what_(std::move(what)) {}

  [[noreturn]] void fail(const std::string& field, const std::string& must) const {
    throw Error(fmt::format("{}: its {} must be {}; correct it", what_, field, must));
  }

  [[nodiscard]] double number(const char* path, double otherwise, double least, double most) const {
    const Json::json_pointer pointer(path);
    if (!json_.contains(pointer)) return otherwise;
    const Json& value = json_[pointer];
    const double x = value.is_number() ? value.get<double>() : std::nan("");
    if (!(x >= least && x <= most))
      fail(name(path), most < 1e30 ? fmt::format("a number from {} to {}", least, most)
                                   : fmt::format("a number not below {}", least));
    return x;
  }

  [[nodiscard]] glm::vec3 colour(const char* path, const glm::vec3& otherwise, double most) const {
    const Json::json_pointer pointer(path);
    if (!json_.contains(pointer)) return otherwise;
    const Json& value = json_[pointer];
    glm::vec3 out(0.0F);
    for (int i = 0; i < 3; ++i) {
      const bool is_number =
          value.is_array() && value.size() >= 3 && value[static_cast<std::size_t>(i)].is_number();
      const double x = is_number ? value[static_cast<std::size_t>(i)].get<double>() : std::nan("");
      if (!(x >= 0.0 && x <= most))
        fail(name(path), most < 2.0 ? "3 numbers from 0 to 1" : "3 numbers that are not negative");
      out[i] = static_cast<float>(x);
    }
    return out;
  }

 private:
  static std::string name(const std::string& path) { return path.substr(path.rfind('/') + 1); }

  const Json& json_;
  std::string what_;
};

constexpr double kMost = 3.4e38;  ///< about the largest float32

glm::dmat4 transform_of(const Json& node) {
  if (node.contains("matrix")) {
    const auto values = node["matrix"].get<std::vector<double>>();
    if (values.size() == 16) return glm::make_mat4(values.data());
  }
  return transform_of(placement_of(node));
}

Light light_of(const Json& json, std::size_t number, const std::string& file) {
  Light light;
  light.name = json.value("name", std::string());
  const Fields fields(json, fmt::format("{}: light {} (`{}`)", file, number, light.name));
  const std::string type = json.value("type", std::string());
  if (type == "directional")
    light.kind = LightKind::Directional;
  else if (type == "spot")
    light.kind = LightKind::Spot;
  else if (type != "point")
    fields.fail("type", "point, spot or directional");
  const double intensity = fields.number("/intensity", 1.0, 0.0, kMost);
  light.intensity = fields.colour("/color", glm::vec3(1.0F), kMost) * static_cast<float>(intensity);
  if (json.contains("range"))
    light.range = static_cast<float>(fields.number("/range", 0.0, 1e-30, kMost));
  const double outer = fields.number("/spot/outerConeAngle", kPi / 4, 1e-6, kPi / 2 + 1e-6);
  const double inner = fields.number("/spot/innerConeAngle", 0.0, 0.0, outer);
  light.cos_inner = static_cast<float>(std::cos(inner));
  light.cos_outer = static_cast<float>(std::cos(outer));
  return light;
}

void visit_node(const Json& json, std::size_t number, const Pose& pose, const glm::dmat4& parent,
                int depth, const std::string& file,
                const std::function<void(std::size_t, const glm::dmat4&)>& at) {
  constexpr int kDeepest = 1000;
  const Json& node = json.at("nodes").at(number);
  if (depth > kDeepest) throw Error(file + ": its nodes form a circle; export it again");
  const glm::dmat4 world = parent * pose.at(number);
  at(number, world);
  if (!node.contains("children")) return;
  for (const Json& child : node["children"])
    visit_node(json, child, pose, world, depth + 1, file, at);
}

}  // namespace

std::vector<GltfValues> gltf_materials(const Json& json, const std::string& file) {
  std::vector<GltfValues> out;
  if (!json.contains("materials")) return out;
  for (const Json& item : json["materials"]) {
    GltfValues values;
    values.name = item.value("name", values.name);
    const Fields fields(item, fmt::format("{}: material {} (`{}`)", file, out.size(), values.name));
    values.base = fields.colour("/pbrMetallicRoughness/baseColorFactor", glm::vec3(1.0F), 1.0);
    const auto share = [&fields](const char* path, double otherwise) {
      return static_cast<float>(fields.number(path, otherwise, 0.0, 1.0));
    };
    values.metallic = share("/pbrMetallicRoughness/metallicFactor", 1.0);
    values.roughness = share("/pbrMetallicRoughness/roughnessFactor", 1.0);
    values.transmission = share("/extensions/KHR_materials_transmission/transmissionFactor", 0.0);
    values.ior =
        static_cast<float>(fields.number("/extensions/KHR_materials_ior/ior", 1.5, 1.0, 100.0));
    const double strength = fields.number(
        "/extensions/KHR_materials_emissive_strength/emissiveStrength", 1.0, 0.0, kMost);
    values.emission =
        fields.colour("/emissiveFactor", glm::vec3(0.0F), 1.0) * static_cast<float>(strength);
    out.push_back(std::move(values));
  }
  return out;
}

Placement placement_of(const Json& node) {
  Placement out;
  const auto read = [&node](const char* key, std::size_t count, glm::dvec4& target) {
    const auto values = node.value(key, std::vector<double>());
    if (values.size() != count) return;
    for (std::size_t i = 0; i < count; ++i) target[static_cast<int>(i)] = values[i];
  };
  read("translation", 3, out.translation);
  read("rotation", 4, out.rotation);
  read("scale", 3, out.scale);
  return out;
}

glm::dmat4 transform_of(const Placement& placement) {
  const glm::dvec4& r = placement.rotation;
  glm::dmat4 out = glm::mat4_cast(glm::dquat(r.w, r.x, r.y, r.z));
  for (int axis = 0; axis < 3; ++axis) out[axis] *= placement.scale[axis];
  out[3] = glm::dvec4(glm::dvec3(placement.translation), 1.0);
  return out;
}

Pose rest_pose(const Json& json) {
  Pose pose;
  if (!json.contains("nodes")) return pose;
  for (const Json& node : json["nodes"]) pose.push_back(transform_of(node));
  return pose;
}

void visit_nodes(const Json& json, const Pose& pose, const std::string& file,
                 const std::function<void(std::size_t, const glm::dmat4&)>& at) {
  if (!json.contains("scenes")) return;
  const Json& scene = json["scenes"].at(json.value("scene", std::size_t{0}));
  if (!scene.contains("nodes")) return;
  for (const Json& node : scene["nodes"])
    visit_node(json, node, pose, glm::dmat4(1.0), 0, file, at);
}

std::vector<Light> gltf_lights(const Json& json, const Pose& pose, const std::string& file) {
  std::vector<Light> out;
  visit_nodes(json, pose, file, [&](std::size_t number, const glm::dmat4& world) {
    const Json& node = json["nodes"][number];
    const Json::json_pointer pointer("/extensions/KHR_lights_punctual/light");
    if (!node.contains(pointer)) return;
    const std::size_t at = node[pointer];
    const Json::json_pointer all("/extensions/KHR_lights_punctual/lights");
    Light light = light_of(json.at(all).at(at), at, file);
    light.position = glm::vec3(world[3]);
    const glm::dvec3 along = -glm::dvec3(world[2]);
    if (!(glm::length(along) > 0.0))
      throw Error(
          fmt::format("{}: light {} (`{}`) has no direction, as its node is scaled to nothing; "
                      "correct it",
                      file, at, light.name));
    light.direction = glm::vec3(glm::normalize(along));
    out.push_back(std::move(light));
  });
  return out;
}

}  // namespace ti
