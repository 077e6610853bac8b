// SPDX-License-Identifier: Apache-2.0
// Scenes come in whole, in the order of their file, or not at all: with a sentence that names the
// file and the place.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <vector>

#include "scene/scene.hpp"
#include "test/scene_files.hpp"
#include "test/support.hpp"

namespace {

using namespace ti;
using namespace ti::test;

bool has_warning(const Scene& scene, const std::string& word) {
  return std::any_of(scene.warnings.begin(), scene.warnings.end(),
                     [&](const auto& w) { return w.find(word) != std::string::npos; });
}

TEST_CASE("the Cornell box has its triangles, materials, camera and light") {
  const Scene s = load_scene(root() / "scenes/cornell.gltf");
  CHECK(s.name == "cornell");
  REQUIRE(s.mesh.triangles.size() == 38);
  REQUIRE(s.mesh.material.size() == 38);
  CHECK(s.warnings.empty());
  CHECK(s.mesh.vertex(0, 0) == glm::vec3(0.5528F, 0, 0));
  CHECK(s.mesh.vertex(0, 2) == glm::vec3(0, 0, 0.5592F));
  CHECK(s.materials[s.mesh.material[0]].name == "white");
  CHECK(s.materials[s.mesh.material[12]].name == "green");
  CHECK(s.materials[s.mesh.material[14]].name == "red");
  const Material& light = s.materials[s.mesh.material[16]];
  CHECK(light.name == "light");
  CHECK(light.emission.x == doctest::Approx(18.0F));
  CHECK(glm::distance(s.camera.eye, glm::vec3(0.278F, 0.273F, -0.8F)) < 1e-6F);
  CHECK(glm::distance(glm::normalize(s.camera.target - s.camera.eye), glm::vec3(0, 0, 1)) < 1e-6F);
  CHECK(s.camera.fov_y_deg == doctest::Approx(39.344F).epsilon(1e-4));
  CHECK(s.lights.empty());  // what emits stays a surface
}

TEST_CASE("one triangle is one triangle, and an empty scene is empty") {
  const Scene one = load_scene(root() / "scenes/one_triangle.obj");
  REQUIRE(one.mesh.triangles.size() == 1);
  CHECK(one.mesh.vertex(0, 0) == glm::vec3(-1, -1, 0));
  CHECK(one.mesh.vertex(0, 1) == glm::vec3(1, -1, 0));
  CHECK(one.mesh.vertex(0, 2) == glm::vec3(0, 1, 0));
  CHECK(one.camera.eye == glm::vec3(0, 0, 4));
  CHECK(one.lights.empty());
  const Scene empty = load_scene(root() / "scenes/empty.ply");
  CHECK(empty.mesh.triangles.empty());
  CHECK(empty.materials.size() == 1);
  CHECK(empty.camera.eye == glm::vec3(0, 0, 4));
}

TEST_CASE("scenes without triangles load in every form") {
  const TempDir dir;
  CHECK(load_scene(dir.file("a.obj", "# nothing\n")).mesh.triangles.empty());
  CHECK(load_scene(dir.file("b.obj", "")).mesh.triangles.empty());
  CHECK(load_scene(dir.file("a.gltf", R"({"asset":{"version":"2.0"}})")).mesh.triangles.empty());
  CHECK(load_scene(dir.file("a.ply", ply(kSquare, {}))).mesh.triangles.empty());
  CHECK(load_scene(dir.file("a.ply.zst", zstd(ply({}, {})))).mesh.triangles.empty());
}

TEST_CASE("a node places its mesh, and the triangles follow the order of the nodes") {
  const TempDir dir;
  (void)dir.file("ab.bin", gltf_data());
  for (const auto& path : {dir.file("a.gltf", gltf()), dir.file("b.glb", glb()),
                           dir.file("c.gltf", gltf(",\"uri\":\"ab.bin\""))}) {
    const Scene s = load_scene(path);
    REQUIRE(s.mesh.triangles.size() == 4);
    CHECK(s.mesh.vertex(0, 2) == glm::vec3(2, 2, 5));
    CHECK(s.mesh.vertex(1, 0) == glm::vec3(0, 0, 5));
    CHECK(s.mesh.vertex(1, 1) == glm::vec3(2, 2, 5));
    CHECK(s.mesh.vertex(2, 2) == glm::vec3(1, 1, 0));
    CHECK(s.mesh.vertex(3, 2) == glm::vec3(0, 1, 0));
    CHECK(s.materials[0].specular == glm::vec3(0.25F, 0.5F, 0.75F));  // metal, unless said
    CHECK(glm::distance(s.camera.eye, glm::vec3(1, 2, 3)) < 1e-6F);
    CHECK(glm::distance(s.camera.target, glm::vec3(1, 2, 4)) < 1e-5F);
    CHECK(s.camera.fov_y_deg == doctest::Approx(0.5 * 180 / 3.14159265).epsilon(1e-5));
  }
}

TEST_CASE("OBJ faces keep their order, their corners, and their materials") {
  const TempDir dir;
  (void)dir.file("m.mtl", "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\nKe 3 2 1\n");
  const Scene s = load_scene(dir.file("x.obj",
                                      "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                                      "usemtl a\nf 3 1 2\nusemtl b\nf 2 2 4\nusemtl a\n"
                                      "f -1 -2 -3\nf 1 2 \\\n3 4\nl 1 2\n"));
  REQUIRE(s.mesh.triangles.size() == 5);
  CHECK(s.mesh.vertex(0, 0) == kSquare[2]);
  CHECK(s.mesh.vertex(0, 1) == kSquare[0]);
  CHECK(s.mesh.vertex(1, 0) == s.mesh.vertex(1, 1));
  CHECK(s.mesh.vertex(2, 0) == kSquare[3]);
  CHECK(s.mesh.vertex(2, 2) == kSquare[1]);
  CHECK(s.materials[s.mesh.material[0]].diffuse == glm::vec3(1, 0, 0));
  CHECK(s.materials[s.mesh.material[1]].diffuse == glm::vec3(0, 1, 0));
  CHECK(s.materials[s.mesh.material[1]].emission == glm::vec3(3, 2, 1));
  CHECK(s.materials[s.mesh.material[2]].diffuse == glm::vec3(1, 0, 0));
  CHECK(has_warning(s, "1 points or lines"));
}

TEST_CASE("triangles without area and vertices that are no numbers keep their place") {
  const TempDir dir;
  const Scene obj = load_scene(
      dir.file("n.obj", "v 0 0 0\nv 1 0 0\nv nan 0 1\nv inf -inf 1\nf 1 2 3\nf 1 1 1\nf 1 2 4\n"));
  REQUIRE(obj.mesh.triangles.size() == 3);
  CHECK(std::isnan(obj.mesh.vertex(0, 2).x));
  CHECK(obj.mesh.vertex(2, 2).x == std::numeric_limits<float>::infinity());
  auto vertices = kSquare;
  vertices[3] = {std::nanf(""), -std::numeric_limits<float>::infinity(), 1};
  const Scene bin = load_scene(dir.file("n.ply", ply(vertices, kFaces)));
  REQUIRE(bin.mesh.triangles.size() == 3);
  CHECK(bin.mesh.triangles == kFaces);
  CHECK(std::isnan(bin.mesh.vertex(2, 2).x));
  CHECK(bin.camera.eye.z < 10.0F);
}

TEST_CASE("a PLY of any form gives the triangles of its faces with their corners in place") {
  const TempDir dir;
  const Scene s = load_scene(dir.file("a.ply", kAscii));
  REQUIRE(s.mesh.triangles.size() == 5);
  CHECK(s.mesh.triangles[0] == Face{0, 1, 2});
  CHECK(s.mesh.triangles[1] == Face{0, 0, 1});
  CHECK(s.mesh.triangles[4] == Face{2, 2, 2});
  const Scene packed = load_scene(dir.file("b.ply.zst", zstd(kAscii)));
  CHECK(packed.name == "b");
  CHECK(packed.mesh.triangles == s.mesh.triangles);
}

TEST_CASE("a packed PLY is the PLY, with the materials of its faces from the JSON beside it") {
  const TempDir dir;
  const std::string bytes = ply(kSquare, kFaces, {1, 0, 1});
  (void)dir.file("a.json", R"({"materials": [{"Kd": [0, 0, 1]}, {"name": "b", "Ke": [1, 2, 3]}],
                               "lights": [[1, 2, 3], [4, 5, 6, 0.5, 0.25, 0]],
                               "camera": {"eye": [0, 0, 9], "target": [0, 0, 0]}})");
  for (const auto& path : {dir.file("a.ply", bytes), dir.file("a.ply.zst", zstd(bytes))}) {
    const Scene s = load_scene(path);
    CHECK(s.name == "a");
    CHECK(s.mesh.vertices == kSquare);
    CHECK(s.mesh.triangles == kFaces);
    CHECK(s.mesh.material == std::vector<std::uint16_t>{1, 0, 1});
    REQUIRE(s.materials.size() == 2);
    CHECK(s.materials[0].diffuse == glm::vec3(0, 0, 1));
    CHECK(s.materials[1].name == "b");
    CHECK(s.materials[1].emission == glm::vec3(1, 2, 3));
    CHECK(s.camera.eye == glm::vec3(0, 0, 9));
    CHECK(s.camera.fov_y_deg == 45.0F);
    REQUIRE(s.lights.size() == 2);
    CHECK(s.lights[1].position == glm::vec3(4, 5, 6));
    CHECK(s.lights[1].intensity.x / s.lights[0].intensity.x == doctest::Approx(0.5F));
    CHECK(s.lights[1].intensity.z == 0.0F);
  }
  const Scene two =
      load_scene(dir.file("two.ply.zst", zstd(bytes.substr(0, 100)) + zstd(bytes.substr(100))));
  CHECK(two.mesh.triangles == kFaces);
  CHECK(two.materials.size() == 2);
  CHECK(has_warning(two, "2 materials are not described"));
}

TEST_CASE("what the file has goes before what the JSON beside it has") {
  const TempDir dir;
  (void)dir.file("a.json", R"({"materials": [{"Kd": [0, 0, 1]}],
                               "camera": {"eye": [0, 0, 9], "target": [0, 0, 0]}})");
  const Scene s = load_scene(dir.file("a.gltf", gltf()));
  CHECK(s.materials[0].specular == glm::vec3(0.25F, 0.5F, 0.75F));  // metal, unless said
  CHECK(glm::distance(s.camera.eye, glm::vec3(1, 2, 3)) < 1e-6F);
}

TEST_CASE("a camera that is not a perspective one is left out") {
  const TempDir dir;
  const std::string text = replaced(
      gltf(), R"("type":"perspective","perspective":{"yfov":0.5,"aspectRatio":2.0,"znear":0.1})",
      R"("type":"orthographic","orthographic":{"xmag":1,"ymag":1,"znear":0.1,"zfar":9})");
  const Scene s = load_scene(dir.file("a.gltf", text));
  CHECK(has_warning(s, "perspective"));
  CHECK(s.camera.fov_y_deg == 45.0F);
}

TEST_CASE("the lights of a glTF stand where their nodes are") {
  const TempDir dir;
  std::string text =
      replaced(gltf(), R"("camera":0,)", R"("extensions":{"KHR_lights_punctual":{"light":0}},)");
  text = replaced(text, R"("asset")", R"("extensionsUsed":["KHR_lights_punctual"],
"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","color":[1,0.5,0.25],"intensity":8}]}},"asset")");
  const Scene s = load_scene(dir.file("a.gltf", text));
  REQUIRE(s.lights.size() == 1);
  CHECK(glm::distance(s.lights[0].position, glm::vec3(1, 2, 3)) < 1e-6F);
  CHECK(s.lights[0].intensity == glm::vec3(8.0F, 4.0F, 2.0F));
}

TEST_CASE("a camera that is chosen sees the whole mesh") {
  const TempDir dir;
  std::vector<glm::vec3> vertices{{-700, 3, 1}, {20, 90, 5}, {3, -40, 800}, {-1, 1, -1}};
  const Camera c = load_scene(dir.file("a.ply", ply(vertices, {{0, 1, 2}, {1, 2, 3}}))).camera;
  const glm::vec3 forward = glm::normalize(c.target - c.eye);
  for (const glm::vec3& v : vertices) {
    const float angle = std::acos(glm::dot(glm::normalize(v - c.eye), forward));
    CHECK(angle * 180 / 3.14159265F < c.fov_y_deg / 2);
  }
  const Scene huge = load_scene(
      dir.file("h.ply", ply({{-3e38F, 0, 0}, {3e38F, 0, 0}, {0, 1e38F, 0}}, {{0, 1, 2}})));
  CHECK(std::isfinite(huge.camera.eye.z));
}

TEST_CASE("the benchmark scenes have the triangles that their descriptions promise") {
  const auto folder = root() / "../shared/scenes";
  if (!std::filesystem::exists(folder)) {
    MESSAGE("skipped: there is no folder " << folder.lexically_normal().string());
    return;
  }
  const std::vector<std::pair<std::string, std::size_t>> scenes{
      {"conference", 278509},     {"sibenik", 75284},         {"bart_kitchen", 110561},
      {"crytek_sponza", 262267},  {"dabrovic_sponza", 66454}, {"bart_robots", 71708},
      {"bart_museum", 11820},     {"stanford_bunny", 69451},  {"stanford_dragon", 100000},
      {"utah_teapot", 6320},      {"utah_hand", 15855},       {"cornell_box", 36},
      {"cornell_box_water", 7088}};
  for (const auto& [name, triangles] : scenes) {
    CAPTURE(name);
    const Scene s = load_scene(folder / (name + ".ply.zst"));
    const auto json = nlohmann::json::parse(bytes_of(folder / (name + ".json")));
    CHECK(s.mesh.triangles.size() == triangles);
    CHECK(s.mesh.triangles.size() == json["triangles"].get<std::size_t>());
    CHECK(s.mesh.vertices.size() == json["vertices"].get<std::size_t>());
    CHECK(s.materials.size() == json["materials"].size());
    CHECK(s.camera.eye.x == json["camera"]["eye"][0].get<float>());
    CHECK(s.camera.fov_y_deg == json["camera"]["fov_y_deg"].get<float>());
    for (const std::string& warning : s.warnings)
      CHECK(warning.find("reflect more light than they get") != std::string::npos);
  }
}

}  // namespace
