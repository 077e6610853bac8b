// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace ti {

/// The JSON of a .gltf or .glb and the data that it names.
class GltfFile {
 public:
  /// Throws `Error` when the file is cut or its JSON is not valid.
  explicit GltfFile(const std::filesystem::path& path);
  GltfFile(const GltfFile&) = delete;
  GltfFile& operator=(const GltfFile&) = delete;

  [[nodiscard]] const nlohmann::json& json() const { return json_; }
  [[nodiscard]] const std::string& name() const { return file_; }

  /// The bytes of a buffer. Throws `Error` when its file is missing.
  [[nodiscard]] std::string_view buffer(std::size_t number);

  /// The float32 numbers of an accessor, `components` of an element, one element after the other.
  /// Throws `Error` when it is of another type or reaches past its buffer; `what` names its user.
  [[nodiscard]] std::vector<float> floats(std::size_t accessor, std::size_t components,
                                          const std::string& what);

 private:
  std::filesystem::path folder_;
  std::string file_;
  std::string bytes_;
  nlohmann::json json_;
  std::string_view glb_data_;
  std::map<std::size_t, std::string> buffers_;
};

}  // namespace ti
