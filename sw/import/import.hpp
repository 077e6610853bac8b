// SPDX-License-Identifier: Apache-2.0
//
// The parts of `load_scene`. Each throws `Error` in one sentence that names the file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "import/gltf_file.hpp"
#include "import/materials.hpp"
#include "scene/animation.hpp"
#include "scene/scene.hpp"

namespace ti {

/// A scene on its way in: what the file had, and marks for what it did not have.
struct Import {
  /// A node with meshes, in the order of the file's tree: its vertices stand together.
  struct Node {
    std::size_t first_vertex = 0;
    std::vector<glm::vec3> local;  ///< the vertices in the space of the node
  };

  Scene scene;
  std::vector<Node> nodes;  ///< of a glTF file
  bool has_camera = false;
  bool has_materials = false;  ///< false: any in `scene` are an importer's placeholders
};

/// What the header of a PLY file says.
struct PlyHeader {
  struct Property {
    std::string name;
    std::size_t bytes = 0;        ///< of one value
    std::size_t count_bytes = 0;  ///< of a list's count; 0 when it is not a list
  };
  struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
  };
  std::string format;  ///< ascii, binary_little_endian or binary_big_endian
  std::vector<Element> elements;
  std::size_t vertices = 0;
  std::size_t faces = 0;
  std::size_t body = 0;       ///< where the data begin, in bytes
  bool plain = false;         ///< exactly the binary form that `read_plain_ply` reads
  bool has_material = false;  ///< a face property `material`
  bool has_strips = false;    ///< triangle strips in place of faces
};
[[nodiscard]] PlyHeader read_ply_header(std::string_view bytes, const std::string& file);

/// How many triangles the faces make. Throws when the body is shorter or longer than its header
/// says, or holds a word that is no number.
[[nodiscard]] std::size_t check_ply_body(std::string_view bytes, const PlyHeader& header,
                                         const std::string& file);

/// Triangles of the binary little-endian form with float x, y, z, a uchar-int list and an optional
/// ushort `material`, which Assimp drops. Nothing when a face is not a triangle and has no
/// material, so that Assimp can split it.
[[nodiscard]] std::optional<Mesh> read_plain_ply(std::string_view bytes, const PlyHeader& header,
                                                 const std::string& file);

/// The content of a Zstandard file, all frames of it.
[[nodiscard]] std::string unpack_zstd(std::string_view packed, const std::string& file);

/// What an OBJ file promises, so that nothing that Assimp drops goes unnoticed.
struct ObjSummary {
  std::size_t triangles = 0;  ///< of the polygons, split; points and lines are not counted
  std::vector<std::string> missing_libraries;
};
/// Throws when a face is malformed or refers to a vertex that the file does not have.
[[nodiscard]] ObjSummary check_obj(const std::filesystem::path& path);

/// Facts of a glTF file that Assimp 5.2 drops or takes unchecked.
struct GltfSummary {
  bool has_triangles = false;
  std::optional<float> fov_y_deg;  ///< of the first camera, when it is a perspective one
  std::vector<GltfValues> materials;
  std::vector<Light> lights;
};
/// Throws when an index of a triangle is out of range.
[[nodiscard]] GltfSummary check_gltf(GltfFile& gltf);

/// The frames of the node animation of a file, `fps` a second: translation, rotation and scale by
/// linear, spherical linear, step or cubic spline keys, of meshes, the camera and lights. One frame
/// when there is none. Frame i is at i / fps seconds; the last is before the last key.
[[nodiscard]] Animation gltf_animation(GltfFile& gltf, Import& import, double fps);

/// The frames of a sequence of vertex positions that the file beside the scene names
/// (`frames_file`: float32 [frames][vertices][3], little-endian, may be .zst; `times_s`). Nothing
/// when it names none.
[[nodiscard]] std::optional<Animation> read_sequence(const std::filesystem::path& json,
                                                     const Scene& scene);

/// Reads through Assimp: from `bytes` when they are given (a PLY), else from `path`.
[[nodiscard]] Import import_assimp(const std::filesystem::path& path, std::string_view bytes = {});

/// Adds what `json` (the file beside the scene) has and the scene has not.
void apply_sidecar(Import& import, const std::filesystem::path& json);

/// A camera that sees the whole mesh.
[[nodiscard]] Camera default_camera(const Mesh& mesh);

}  // namespace ti
