// SPDX-License-Identifier: Apache-2.0
#include "import/gltf_file.hpp"

#include <fmt/format.h>

#include <cstring>
#include <system_error>

#include "base/error.hpp"
#include "io/file.hpp"

namespace ti {

namespace {

using Json = nlohmann::json;

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

}  // namespace

GltfFile::GltfFile(const std::filesystem::path& path)
    : folder_(path.parent_path()), file_(path.string()), bytes_(read_file(path)) {
  const bool binary = bytes_.starts_with("glTF") || path.extension() == ".glb";
  Glb glb;
  if (binary) glb = split_glb(bytes_, file_);
  json_ = Json::parse(binary ? glb.json : std::string_view(bytes_), nullptr, false);
  glb_data_ = glb.data;
  if (!json_.is_object())
    throw Error(file_ + ": its JSON is not valid; the file is cut or damaged, export it again");
}

std::string_view GltfFile::buffer(std::size_t number) {
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
        fmt::format("{}: its buffer `{}` is missing; put a file of that very name beside it", file_,
                    uri.substr(0, 80)));
  }
  return buffers_[number] = read_file(path);
}

std::vector<float> GltfFile::floats(std::size_t number, std::size_t components,
                                    const std::string& what) {
  const Json& accessor = json_.at("accessors").at(number);
  const std::size_t count = accessor.at("count");
  constexpr int kFloat = 5126;
  const char* const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  if (accessor.at("componentType") != kFloat || accessor.at("type") != types[components - 1] ||
      accessor.contains("sparse"))
    throw Error(fmt::format("{}: {} must have {} float32 an element; export it again", file_, what,
                            components));
  const Json& view = json_.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
  const std::size_t start =
      view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0});
  const std::size_t size = components * sizeof(float);
  const std::size_t stride = view.value("byteStride", size);
  const std::string_view data = buffer(view.at("buffer"));
  if (count == 0 || stride < size || start > data.size() || size > data.size() - start ||
      (count - 1) > (data.size() - start - size) / stride)
    throw Error(fmt::format(
        "{}: {} is empty or reaches past the end of its buffer; export it again", file_, what));
  std::vector<float> out(count * components);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(out.data() + i * components, data.data() + start + i * stride, size);
  return out;
}

}  // namespace ti
