// SPDX-License-Identifier: Apache-2.0
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "base/error.hpp"
#include "import/import.hpp"
#include "import/materials.hpp"

namespace ti {

namespace {

glm::vec3 to_vec3(const aiVector3D& v) { return {v.x, v.y, v.z}; }
glm::vec3 to_vec3(const aiColor3D& c) { return {c.r, c.g, c.b}; }

/// Transform from the space of `node` to that of the scene.
aiMatrix4x4 world_of(const aiNode* node) {
  aiMatrix4x4 world = node->mTransformation;
  for (const aiNode* up = node->mParent; up != nullptr; up = up->mParent) {
    world = up->mTransformation * world;
  }
  return world;
}

/// Transform of the node that carries a camera of this name; the identity when there is none.
aiMatrix4x4 world_of(const aiScene& ai, const aiString& name) {
  const aiNode* node = ai.mRootNode->FindNode(name);
  return node != nullptr ? world_of(node) : aiMatrix4x4();
}

using Triangles = std::vector<std::array<unsigned, 3>>;

/// The corners of the faces of a mesh, one after the other; face f has those from `ends[f - 1]` (0
/// for the first) to `ends[f]`.
struct Faces {
  std::vector<unsigned> corners;
  std::vector<std::size_t> ends;

  [[nodiscard]] std::size_t size() const { return ends.size(); }
  [[nodiscard]] std::span<const unsigned> operator[](std::size_t f) const {
    const std::size_t begin = f == 0 ? 0 : ends[f - 1];
    return std::span(corners).subspan(begin, ends[f] - begin);
  }
};

/// The faces of each mesh as the file has them. Throws when an index is out of range, which
/// post-processing would not notice.
std::vector<Faces> faces_of(const aiScene& ai, const std::string& file) {
  std::vector<Faces> all(ai.mNumMeshes);
  for (unsigned m = 0; m < ai.mNumMeshes; ++m) {
    const aiMesh& mesh = *ai.mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      all[m].corners.insert(all[m].corners.end(), face.mIndices, face.mIndices + face.mNumIndices);
      all[m].ends.push_back(all[m].corners.size());
      for (const unsigned index : all[m][f]) {
        if (index < mesh.mNumVertices) continue;
        throw Error(
            fmt::format("{}: face {} of mesh {} has index {}, and there are {} vertices; "
                        "export the mesh again",
                        file, f, m, static_cast<int>(index), mesh.mNumVertices));
      }
    }
  }
  return all;
}

bool has_polygons(const Faces& faces) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (faces[f].size() > 3) return true;
  }
  return false;
}

/// How many triangles a face makes; points and lines make none.
std::size_t triangles_in(std::span<const unsigned> face) {
  return face.size() < 3 ? 0 : face.size() - 2;
}

/// The triangles of `faces`: a triangle keeps its corners in their order, a polygon is split as in
/// `mesh`, which Assimp has triangulated. Where that left parts out, as it does with polygons that
/// cross themselves, polygons are split into fans.
Triangles split(const Faces& faces, const aiMesh& mesh, bool& fans) {
  std::size_t expected = 0;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    expected += std::max<std::size_t>(triangles_in(faces[f]), 1);
  }
  const bool fan = has_polygons(faces) && expected != mesh.mNumFaces;
  fans |= fan;
  Triangles triangles;
  std::size_t at = 0;  // in the triangulated mesh, where a point or line still is one face
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::span<const unsigned> face = faces[f];
    const std::size_t count = triangles_in(face);
    for (std::size_t k = 0; k < count; ++k) {
      if (count == 1 || fan) {
        triangles.push_back({face[0], face[k + 1], face[k + 2]});
      } else {
        const unsigned* index = mesh.mFaces[at + k].mIndices;
        triangles.push_back({index[0], index[1], index[2]});
      }
    }
    at += std::max<std::size_t>(count, 1);
  }
  return triangles;
}

class Converter {
 public:
  /// `faces` are those before triangulation.
  Converter(const aiScene& ai, const std::vector<Faces>& faces, std::string file)
      : ai_(ai), file_(std::move(file)) {
    bool fans = false;
    for (unsigned m = 0; m < ai.mNumMeshes; ++m) {
      triangles_.push_back(split(faces[m], *ai.mMeshes[m], fans));
      flat_.push_back(0);
      for (std::size_t f = 0; f < faces[m].size(); ++f) {
        flat_.back() += triangles_in(faces[m][f]) == 0 ? 1 : 0;
      }
    }
    if (fans) warn("polygons that cross themselves are split into fans");
  }

  Import convert() {
    add_materials();
    add_node(*ai_.mRootNode, aiMatrix4x4());
    if (skipped_ > 0) {
      warn(fmt::format("{} points or lines are left out", skipped_));
    }
    if (out_.scene.materials.size() <= 1) out_.scene.mesh.material.clear();
    add_camera();
    return std::move(out_);
  }

 private:
  void warn(const std::string& what) {
    out_.scene.warnings.push_back(fmt::format("{}: {}", file_, what));
  }

  void add_materials() {
    bool textured = false;
    for (unsigned i = 0; i < ai_.mNumMaterials; ++i) {
      const aiMaterial& from = *ai_.mMaterials[i];
      MtlValues values;
      aiString name;
      if (from.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS) values.name = name.C_Str();
      const auto colour = [&from](const char* key, unsigned type, unsigned index,
                                  glm::vec3& target) {
        aiColor3D c;
        if (from.Get(key, type, index, c) == aiReturn_SUCCESS) target = to_vec3(c);
      };
      const auto number = [&from](const char* key, unsigned type, unsigned index) {
        ai_real x = 0;
        return from.Get(key, type, index, x) == aiReturn_SUCCESS ? std::optional<float>(x)
                                                                 : std::nullopt;
      };
      colour(AI_MATKEY_COLOR_DIFFUSE, values.kd);
      aiColor4D base;  // of glTF
      if (from.Get(AI_MATKEY_BASE_COLOR, base) == aiReturn_SUCCESS)
        values.kd = {base.r, base.g, base.b};
      colour(AI_MATKEY_COLOR_SPECULAR, values.ks);
      colour(AI_MATKEY_COLOR_EMISSIVE, values.ke);
      glm::vec3 tint(1.0F);
      colour(AI_MATKEY_COLOR_TRANSPARENT, tint);
      values.tf = tint;
      values.ns = number(AI_MATKEY_SHININESS);
      values.ni = number(AI_MATKEY_REFRACTI);
      if (const auto opacity = number(AI_MATKEY_OPACITY)) values.tr = 1.0F - *opacity;
      int illum = 0;
      if (from.Get("$mat.illum", 0, 0, illum) == aiReturn_SUCCESS) values.illum = illum;
      const Material material = material_of(values);
      textured |= from.GetTextureCount(aiTextureType_DIFFUSE) > 0 ||
                  from.GetTextureCount(aiTextureType_BASE_COLOR) > 0;
      out_.has_materials |= material.name != AI_DEFAULT_MATERIAL_NAME && !material.name.empty();
      out_.scene.materials.push_back(material);
    }
    if (textured) warn("textures are not read; surfaces show the colour of their material");
  }

  void add_node(const aiNode& node, const aiMatrix4x4& parent) {
    const aiMatrix4x4 world = parent * node.mTransformation;
    if (node.mNumMeshes > 0)
      out_.nodes.push_back({.first_vertex = out_.scene.mesh.vertices.size(), .local = {}});
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      add_mesh(node.mMeshes[i], world);
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) {
      add_node(*node.mChildren[i], world);
    }
  }

  void add_mesh(unsigned number, const aiMatrix4x4& world) {
    const aiMesh& from = *ai_.mMeshes[number];
    const Triangles& triangles = triangles_[number];
    skipped_ += flat_[number];
    Mesh& mesh = out_.scene.mesh;
    const std::size_t base = mesh.vertices.size();
    constexpr auto kMax = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
    if (base + from.mNumVertices > kMax || mesh.triangles.size() + triangles.size() > kMax) {
      throw Error(file_ +
                  ": the scene has more than 2^31 vertices or triangles; use a smaller one");
    }
    if (from.mMaterialIndex > std::numeric_limits<std::uint16_t>::max()) {
      throw Error(file_ + ": the scene has more than 65536 materials; merge some");
    }
    // Without a transform the coordinates stay bit for bit, infinities included.
    const bool identity = world.IsIdentity();
    for (unsigned i = 0; i < from.mNumVertices; ++i) {
      const aiVector3D& v = from.mVertices[i];
      mesh.vertices.push_back(to_vec3(identity ? v : world * v));
      out_.nodes.back().local.push_back(to_vec3(v));
    }
    const auto b = static_cast<std::uint32_t>(base);
    for (const auto& t : triangles) {
      mesh.triangles.push_back({b + t[0], b + t[1], b + t[2]});
      mesh.material.push_back(static_cast<std::uint16_t>(from.mMaterialIndex));
    }
  }

  void add_camera() {
    if (ai_.mNumCameras == 0) return;
    const aiCamera& from = *ai_.mCameras[0];
    if (ai_.mNumCameras > 1) warn("the first of several cameras is used");
    const aiMatrix4x4 world = world_of(ai_, from.mName);
    const aiMatrix3x3 turn(world);
    Camera& camera = out_.scene.camera;
    // Of the three formats only glTF has cameras. There they stand at the origin of their node and
    // look along its -z; Assimp's mPosition repeats the node's translation in some versions.
    camera.eye = to_vec3(world * aiVector3D());
    camera.target = camera.eye + to_vec3(turn * aiVector3D(0, 0, -1));
    camera.up = to_vec3(turn * aiVector3D(0, 1, 0));
    out_.has_camera = true;
  }

  const aiScene& ai_;
  std::string file_;
  std::vector<Triangles> triangles_;  ///< of each mesh
  std::vector<std::size_t> flat_;     ///< points and lines of each mesh
  Import out_;
  std::size_t skipped_ = 0;
};

}  // namespace

Import import_assimp(const std::filesystem::path& path, std::string_view bytes) {
  const std::string file = path.string();
  try {
    Assimp::Importer importer;
    const aiScene* ai = bytes.empty()
                            ? importer.ReadFile(file, 0)
                            : importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, "ply");
    std::vector<Faces> faces;
    if (ai != nullptr && ai->mRootNode != nullptr) {
      faces = faces_of(*ai, file);
      if (std::any_of(faces.begin(), faces.end(), has_polygons)) {
        ai = importer.ApplyPostProcessing(aiProcess_Triangulate);
      }
    }
    if (ai == nullptr || ai->mRootNode == nullptr) {
      throw Error(fmt::format("{}: the file cannot be read ({}); export it again", file,
                              importer.GetErrorString()));
    }
    return Converter(*ai, faces, file).convert();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw Error(fmt::format("{}: the file cannot be read ({}); export it again", file, e.what()));
  }
}

}  // namespace ti
