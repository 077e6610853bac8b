// SPDX-License-Identifier: Apache-2.0
//
// Assimp 5.2 leaves out triangles whose indices are out of range without a word, and does not know
// KHR_materials_emissive_strength. This looks at the JSON and the index data of the file for both.
// What is malformed in any other way is left to Assimp to refuse.
#include <fmt/format.h>

#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "base/error.hpp"
#include "import/gltf_scene.hpp"
#include "import/import.hpp"
#include "io/file.hpp"

namespace ti {

namespace {

using Json = nlohmann::json;

constexpr double kPi = 3.14159265358979323846;
constexpr int kTriangles = 4;  // the mode of a primitive
constexpr std::size_t kGlbHeader = 12;
constexpr std::size_t kChunkHeader = 8;

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

/// The two chunks of a .glb: JSON and data.
struct Glb {
  std::string_view json;
  std::string_view data;
};

Glb split_glb(std::string_view bytes, const std::string& file) {
  if (bytes.size() < kGlbHeader + kChunkHeader || !bytes.starts_with("glTF")) {
    throw Error(file + ": this is not a .glb file or it is cut; export it again");
  }
  const std::size_t length = word_at(bytes, 8);
  if (bytes.size() < length) {
    throw Error(
        fmt::format("{}: the file is cut: its header promises {} bytes, and it has {}; copy or "
                    "export it again",
                    file, length, bytes.size()));
  }
  Glb glb;
  for (std::size_t at = kGlbHeader; at + kChunkHeader <= bytes.size();) {
    const std::size_t size = word_at(bytes, at);
    const std::string_view type = bytes.substr(at + 4, 4);
    at += kChunkHeader;
    if (size > bytes.size() - at) {
      throw Error(fmt::format("{}: a chunk of {} bytes does not fit in the file; export it again",
                              file, size));
    }
    if (type == "JSON") glb.json = bytes.substr(at, size);
    if (type == std::string_view("BIN\0", 4)) glb.data = bytes.substr(at, size);
    at += size;
  }
  return glb;
}

std::string decode_base64(std::string_view text) {
  std::string bytes;
  std::uint32_t bits = 0;
  int have = 0;
  for (const char c : text) {
    std::uint32_t v = 0;
    if (c >= 'A' && c <= 'Z') {
      v = static_cast<std::uint32_t>(c - 'A');
    } else if (c >= 'a' && c <= 'z') {
      v = static_cast<std::uint32_t>(c - 'a' + 26);
    } else if (c >= '0' && c <= '9') {
      v = static_cast<std::uint32_t>(c - '0' + 52);
    } else if (c == '+' || c == '/') {
      v = c == '+' ? 62 : 63;
    } else {
      break;
    }
    bits = bits << 6 | v;
    have += 6;
    if (have >= 8) {
      have -= 8;
      bytes.push_back(static_cast<char>(bits >> have & 0xFF));
    }
  }
  return bytes;
}

class GltfChecker {
 public:
  GltfChecker(const std::filesystem::path& path, const Json& json, std::string_view glb_data)
      : folder_(path.parent_path()), file_(path.string()), json_(json), glb_data_(glb_data) {}

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
    summary.lights = gltf_lights(json_, file_);
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
    const std::string_view data = buffer(view.at("buffer"));
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

  std::string_view buffer(std::size_t number) {
    const Json& entry = json_.at("buffers").at(number);
    if (!entry.contains("uri")) return glb_data_;
    const auto found = buffers_.find(number);
    if (found != buffers_.end()) return found->second;
    const auto uri = entry["uri"].get<std::string>();
    const auto comma = uri.find(',');
    if (uri.starts_with("data:") && comma != std::string::npos) {
      return buffers_[number] = decode_base64(std::string_view(uri).substr(comma + 1));
    }
    std::error_code ec;
    const std::filesystem::path path = folder_ / uri;
    if (!std::filesystem::is_regular_file(path, ec)) {
      throw Error(
          fmt::format("{}: its buffer `{}` is missing; put a file of that very name beside it",
                      file_, uri.substr(0, 80)));
    }
    return buffers_[number] = read_file(path);
  }

  std::filesystem::path folder_;
  std::string file_;
  const Json& json_;
  std::string_view glb_data_;
  std::map<std::size_t, std::string> buffers_;
};

}  // namespace

GltfSummary check_gltf(const std::filesystem::path& path) {
  const std::string file = path.string();
  const std::string bytes = read_file(path);
  const bool binary = bytes.starts_with("glTF") || path.extension() == ".glb";
  Glb glb;
  if (binary) glb = split_glb(bytes, file);
  const Json json = Json::parse(binary ? glb.json : std::string_view(bytes), nullptr, false);
  if (!json.is_object()) {
    throw Error(file + ": its JSON is not valid; the file is cut or damaged, export it again");
  }
  try {
    return GltfChecker(path, json, glb.data).run();
  } catch (const Json::exception& e) {
    throw Error(fmt::format(
        "{}: the glTF lacks something or has a wrong type ({}); export it again", file, e.what()));
  }
}

}  // namespace ti
