// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <system_error>

#include "base/error.hpp"
#include "base/vec.hpp"
#include "import/import.hpp"
#include "import/materials.hpp"
#include "io/file.hpp"
#include "scene/scene.hpp"

namespace ti {

namespace {

namespace fs = std::filesystem;

enum class Form { Gltf, Obj, Ply, PlyZst };

Form form_of(const fs::path& path) {
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  if (name.ends_with(".ply.zst")) return Form::PlyZst;
  if (name.ends_with(".ply")) return Form::Ply;
  if (name.ends_with(".obj")) return Form::Obj;
  if (name.ends_with(".gltf") || name.ends_with(".glb")) return Form::Gltf;
  throw Error(
      fmt::format("{}: the extension is none of .gltf .glb .obj .ply .ply.zst; convert the "
                  "scene to one of these",
                  path.string()));
}

Import import_ply(const fs::path& path, std::string_view bytes) {
  const std::string file = path.string();
  const PlyHeader header = read_ply_header(bytes, file);
  if (header.faces == 0 && !header.has_strips) {
    (void)check_ply_body(bytes, header, file);
    return {};
  }
  if (header.plain) {
    if (auto mesh = read_plain_ply(bytes, header, file)) {
      Import import;
      import.scene.mesh = std::move(*mesh);
      return import;
    }
  }
  const std::size_t expected = check_ply_body(bytes, header, file);
  Import import = import_assimp(path, bytes);
  import.has_materials = false;
  import.scene.materials.clear();
  import.scene.mesh.material.clear();
  if (import.scene.mesh.triangles.size() != expected && !header.has_strips) {
    throw Error(
        fmt::format("{}: {} triangles came out of faces that make {}; split the faces into "
                    "triangles and export it again",
                    file, import.scene.mesh.triangles.size(), expected));
  }
  if (header.has_material) {
    import.scene.warnings.push_back(
        file + ": the material of the faces is read from binary little-endian files only");
  }
  return import;
}

Import import_obj(const fs::path& path) {
  const std::string file = path.string();
  const ObjSummary summary = check_obj(path);
  Import import;
  if (summary.triangles > 0) {
    import = import_assimp(path);
    const std::size_t got = import.scene.mesh.triangles.size();
    if (got != summary.triangles) {
      import.scene.warnings.push_back(fmt::format(
          "{}: {} triangles came out of polygons that make {}", file, got, summary.triangles));
    }
  }
  for (const std::string& library : summary.missing_libraries) {
    import.scene.warnings.push_back(
        fmt::format("{}: the material file `{}` is missing; its surfaces are grey", file, library));
  }
  return import;
}

/// What the file says of a material of Assimp, which has an order of its own: by name and, where
/// several share it, by colour.
const GltfValues* values_of(const Material& material, const std::vector<GltfValues>& all) {
  const GltfValues* found = nullptr;
  for (const GltfValues& values : all) {
    if (values.name != material.name) continue;
    if (values.base == material.diffuse) return &values;
    if (found == nullptr) found = &values;
  }
  return found;
}

Import import_gltf(const fs::path& path) {
  GltfFile gltf(path);
  const GltfSummary summary = check_gltf(gltf);
  if (!summary.has_triangles) return {};
  Import import = import_assimp(path);
  import.has_materials = !summary.materials.empty();
  import.scene.lights = summary.lights;
  if (import.has_camera && summary.fov_y_deg) {
    import.scene.camera.fov_y_deg = *summary.fov_y_deg;
  } else if (import.has_camera) {
    import.has_camera = false;
    import.scene.warnings.push_back(path.string() +
                                    ": the camera is not a perspective one; it is left out");
  }
  // Behind those of the file Assimp has one for meshes without any.
  auto& materials = import.scene.materials;
  for (std::size_t i = 0; i < std::min(materials.size(), summary.materials.size()); ++i) {
    if (const GltfValues* values = values_of(materials[i], summary.materials))
      materials[i] = material_of(*values);
  }
  return import;
}

Import import_file(const fs::path& path) {
  const Form form = form_of(path);
  switch (form) {
    case Form::Gltf:
      return import_gltf(path);
    case Form::Obj:
      return import_obj(path);
    case Form::Ply:
      return import_ply(path, read_file(path));
    case Form::PlyZst:
      return import_ply(path, unpack_zstd(read_file(path), path.string()));
  }
  return {};
}

fs::path sidecar_of(const fs::path& path) {
  fs::path json = path;
  if (form_of(path) == Form::PlyZst) json.replace_extension();
  return json.replace_extension(".json");
}

void check_materials(Scene& scene, const std::string& file) {
  std::size_t scaled = 0;
  std::string first;
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    Material& m = scene.materials[i];
    if (const std::string fault = fault_of(m); !fault.empty())
      throw Error(
          fmt::format("{}: material {} (`{}`) cannot be: {}; correct it", file, i, m.name, fault));
    if (!keep_energy(m)) continue;
    if (scaled++ == 0) first = m.name;
  }
  if (scaled != 0)
    scene.warnings.push_back(
        fmt::format("{}: {} of its materials (first `{}`) reflect more light than they get; their "
                    "colours are scaled",
                    file, scaled, first));
  auto& ids = scene.mesh.material;
  const auto top = std::max_element(ids.begin(), ids.end());
  if (scene.materials.empty()) {
    const std::size_t count = top != ids.end() ? 1U + *top : 1U;
    if (count > 1) {
      scene.warnings.push_back(fmt::format(
          "{}: {} materials are not described beside it; all surfaces are grey", file, count));
    }
    scene.materials.resize(count);
  }
  if (top != ids.end() && *top >= scene.materials.size()) {
    throw Error(fmt::format("{}: face {} has material {}, and {} are described; add it to the list",
                            file, top - ids.begin(), *top, scene.materials.size()));
  }
}

void check_camera(const Camera& c, const std::string& file) {
  const bool good = finite(c.eye) && finite(c.target) && finite(c.up) && c.eye != c.target &&
                    c.fov_y_deg > 0.0F && c.fov_y_deg < 180.0F;
  if (!good) {
    throw Error(fmt::format(
        "{}: the camera (eye {} {} {}, target {} {} {}, {} degrees) is not usable; "
        "give it finite points and an angle inside 0 to 180",
        file, c.eye.x, c.eye.y, c.eye.z, c.target.x, c.target.y, c.target.z, c.fov_y_deg));
  }
}

void check_lights(std::vector<Light>& lights, const std::string& file) {
  for (std::size_t i = 0; i < lights.size(); ++i) {
    Light& light = lights[i];
    const auto fail = [&](const char* field, const char* must) {
      throw Error(fmt::format("{}: light {} (`{}`): its {} must be {}; correct it", file, i,
                              light.name, field, must));
    };
    const glm::vec3& c = light.intensity;
    if (!finite(light.position)) fail("position", "finite");
    if (!finite(c) || std::min({c.x, c.y, c.z}) < 0.0F)
      fail("intensity", "finite and not negative");
    if (!(light.range > 0.0F)) fail("range", "above 0");
    const float length = glm::length(light.direction);
    if (!(length > 0.0F) || !std::isfinite(length)) fail("direction", "finite and not 0");
    light.direction /= length;
  }
}

/// A scene with all that is beside it, checked.
Import import_scene(const fs::path& path) {
  const std::string file = path.string();
  std::error_code ec;
  if (fs::is_directory(path, ec)) {
    throw Error(file + ": this is a folder; name a scene file in it");
  }
  if (!fs::exists(path, ec)) {
    throw Error(file + ": there is no such file; check the path");
  }
  const Form form = form_of(path);
  Import import = import_file(path);
  Scene& scene = import.scene;
  scene.name = path.stem().string();
  if (form == Form::PlyZst) scene.name = fs::path(scene.name).stem().string();
  const fs::path json = sidecar_of(path);
  if (fs::exists(json, ec)) apply_sidecar(import, json);

  check_materials(scene, file);
  check_lights(scene.lights, file);
  if (!import.has_camera) scene.camera = default_camera(scene.mesh);
  check_camera(scene.camera, file);
  return import;
}

}  // namespace

Scene load_scene(const fs::path& path) { return import_scene(path).scene; }

AnimatedScene load_animated_scene(const fs::path& path, double fps) {
  Import import = import_scene(path);
  AnimatedScene out;
  std::error_code ec;
  const fs::path json = sidecar_of(path);
  std::optional<Animation> sequence;
  if (fs::exists(json, ec)) sequence = read_sequence(json, import.scene);
  if (sequence) {
    out.animation = std::move(*sequence);
  } else if (form_of(path) == Form::Gltf) {
    GltfFile gltf(path);
    try {
      out.animation = gltf_animation(gltf, import, fps);
    } catch (const nlohmann::json::exception& e) {
      throw Error(
          fmt::format("{}: its animation lacks something or has a wrong type ({}); export "
                      "it again",
                      path.string(), e.what()));
    }
  } else {
    out.animation.frames.push_back({.seconds = 0.0,
                                    .positions = {},
                                    .camera = import.scene.camera,
                                    .lights = import.scene.lights});
  }
  out.scene = std::move(import.scene);
  for (Animation::Frame& frame : out.animation.frames) {
    check_camera(frame.camera, path.string());
    check_lights(frame.lights, path.string());
  }
  out.animation.pose(out.scene, 0);
  return out;
}

}  // namespace ti
