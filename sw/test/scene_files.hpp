// SPDX-License-Identifier: Apache-2.0
// Small scene files of each form, made in memory.
#pragma once

#include <doctest/doctest.h>
#include <zstd.h>

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace ti::test {

using Face = std::array<std::uint32_t, 3>;

/// A binary PLY of the form of the benchmark scenes; materials only when there are some.
inline std::string ply(const std::vector<glm::vec3>& vertices, const std::vector<Face>& faces,
                       const std::vector<std::uint16_t>& materials = {}) {
  std::string s = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                  std::to_string(vertices.size()) +
                  "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                  std::to_string(faces.size()) + "\nproperty list uchar int vertex_indices\n" +
                  (materials.empty() ? "" : "property ushort material\n") + "end_header\n";
  s.append(reinterpret_cast<const char*>(vertices.data()), 12 * vertices.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    s.push_back(3);
    s.append(reinterpret_cast<const char*>(faces[i].data()), 12);
    if (!materials.empty()) s.append(reinterpret_cast<const char*>(&materials[i]), 2);
  }
  return s;
}

inline std::string zstd(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
  return out;
}

inline const std::vector<glm::vec3> kSquare{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
inline const std::vector<Face> kFaces{{0, 1, 2}, {0, 0, 1}, {0, 2, 3}};

inline constexpr const char* kAscii =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 0 1\n4 0 1 2 3\n3 2 2 2\n";

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

/// The buffer of `gltf`: the vertices of the square, then triangles 0 1 2 and 0 2 3.
inline std::string gltf_data() {
  const std::array<std::uint16_t, 6> indices{0, 1, 2, 0, 2, 3};
  std::string data(reinterpret_cast<const char*>(kSquare.data()), 12 * kSquare.size());
  return data.append(reinterpret_cast<const char*>(indices.data()), sizeof indices);
}

inline std::string base64(const std::string& data) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  REQUIRE(data.size() % 3 == 0);
  std::string text;
  for (std::size_t i = 0; i < data.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | static_cast<unsigned char>(data[i + k]);
    for (int k = 18; k >= 0; k -= 6) text.push_back(digits[bits >> k & 63]);
  }
  return text;
}

/// A glTF with a square, seen through two nodes, one under another, and a camera. `uri` is the
/// member of the buffer that says where its data are.
inline std::string gltf(const std::string& uri) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1,2]}],
"nodes":[{"children":[3],"translation":[0,0,5]},{"mesh":0},
 {"camera":0,"translation":[1,2,3],"rotation":[0,1,0,0]},
 {"mesh":0,"scale":[2,2,2]}],
"cameras":[{"type":"perspective","perspective":{"yfov":0.5,"aspectRatio":2.0,"znear":0.1}}],
"materials":[{"name":"m","pbrMetallicRoughness":{"baseColorFactor":[0.25,0.5,0.75,1]}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
 {"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],
"buffers":[{"byteLength":60)" +
         uri + "}]}";
}

inline std::string gltf() {
  return gltf(",\"uri\":\"data:application/octet-stream;base64," + base64(gltf_data()) + "\"");
}

/// The same as a .glb, with the data in its second chunk.
inline std::string glb() {
  const auto word = [](std::size_t value) {
    const auto v = static_cast<std::uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&v), 4);
  };
  std::string json = gltf("");
  json.append((4 - json.size() % 4) % 4, ' ');
  const std::string data = gltf_data();
  return "glTF" + word(2) + word(28 + json.size() + data.size()) + word(json.size()) + "JSON" +
         json + word(data.size()) + std::string("BIN\0", 4) + data;
}

}  // namespace ti::test
