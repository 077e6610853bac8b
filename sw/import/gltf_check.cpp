// SPDX-License-Identifier: Apache-2.0
//
// Assimp 5.2 leaves out triangles whose indices are out of range without a word, and does not know
// KHR_materials_emissive_strength. This looks at the JSON and the index data of the file for both.
// What is malformed in any other way is left to Assimp to refuse.
#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/error.hpp"
#include "import/gltf_file.hpp"
#include "import/gltf_scene.hpp"
#include "import/import.hpp"

namespace ti {

namespace {

using Json = nlohmann::json;

constexpr double kPi = 3.14159265358979323846;
constexpr int kTriangles = 4;  // the mode of a primitive
class GltfChecker {
 public:
  explicit GltfChecker(GltfFile& gltf) : gltf_(gltf), file_(gltf.name()), json_(gltf.json()) {}

  GltfSummary run() {
    GltfSummary summary;
    const Json none = Json::array();
    const Json& meshes = json_.contains("meshes") ? json_["meshes"] : none;
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      const Json& primitives = meshes.at(m).at("primitives");
      for (std::size_t p = 0; p < primitives.size(); ++p) {
        const int mode = primitives.at(p).value("mode", kTriangles);
        summary.has_triangles |= mode >= kTriangles;
        if (mode == kTriangles) check(primitives.at(p), m, p);
      }
    }
    summary.materials = gltf_materials(json_, file_);
    summary.lights = gltf_lights(json_, rest_pose(json_), file_);
    const Json::json_pointer yfov("/cameras/0/perspective/yfov");
    if (json_.contains(yfov)) {
      summary.fov_y_deg = static_cast<float>(json_[yfov].get<double>() * 180.0 / kPi);
    }
    return summary;
  }

 private:
  void check(const Json& primitive, std::size_t mesh, std::size_t number) {
    const Json& accessors = json_.at("accessors");
    const std::size_t vertices =
        accessors.at(primitive.at("attributes").at("POSITION").get<std::size_t>()).at("count");
    const auto place = fmt::format("mesh {}, primitive {}", mesh, number);
    const bool indexed = primitive.contains("indices");
    const Json* accessor =
        indexed ? &accessors.at(primitive["indices"].get<std::size_t>()) : nullptr;
    const std::size_t count = indexed ? accessor->at("count").get<std::size_t>() : vertices;
    if (count % 3 != 0) {
      throw Error(
          fmt::format("{}: {} has {} corners, which is not a multiple of 3; export it again", file_,
                      place, count));
    }
    if (!indexed || !accessor->contains("bufferView")) return;
    const int type = accessor->at("componentType");
    const std::size_t size = type == 5121 ? 1 : type == 5123 ? 2 : 4;
    const Json& view = json_.at("bufferViews").at(accessor->at("bufferView").get<std::size_t>());
    const std::size_t start =
        view.value("byteOffset", std::size_t{0}) + accessor->value("byteOffset", std::size_t{0});
    const std::size_t stride = view.value("byteStride", size);
    const std::string_view data = gltf_.buffer(view.at("buffer"));
    if (stride < size) {
      throw Error(fmt::format(
          "{}: the indices of {} have a byteStride of {}, and one takes {} bytes; export it again",
          file_, place, stride, size));
    }
    if (count == 0) return;
    if (start > data.size() || size > data.size() - start ||
        (count - 1) > (data.size() - start - size) / stride) {
      throw Error(
          fmt::format("{}: the indices of {} reach past the end of their buffer of {} bytes; the "
                      "file or its .bin is cut, export it again",
                      file_, place, data.size()));
    }
    for (std::size_t i = 0; i < count; ++i) {
      std::uint32_t index = 0;
      std::memcpy(&index, data.data() + start + i * stride, size);
      if (index < vertices) continue;
      throw Error(
          fmt::format("{}: face {} of {} has index {}, and there are {} vertices; export the mesh "
                      "again",
                      file_, i / 3, place, index, vertices));
    }
  }

  GltfFile& gltf_;
  const std::string& file_;
  const Json& json_;
};

}  // namespace

GltfSummary check_gltf(GltfFile& gltf) {
  try {
    return GltfChecker(gltf).run();
  } catch (const Json::exception& e) {
    throw Error(
        fmt::format("{}: the glTF lacks something or has a wrong type ({}); export it again",
                    gltf.name(), e.what()));
  }
}

}  // namespace ti
