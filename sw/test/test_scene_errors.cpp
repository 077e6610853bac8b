// SPDX-License-Identifier: Apache-2.0
// A scene that is missing, cut, corrupt or ill described is refused with a sentence that names the
// file and the place.
#include <filesystem>
#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "test/scene_files.hpp"
#include "test/support.hpp"

namespace {

using namespace ti;
using namespace ti::test;

TEST_CASE("files that are missing, cut or corrupt are refused by name and place") {
  const TempDir dir;
  const std::string good = ply(kSquare, kFaces);
  const std::string ascii = kAscii;
  const std::string packed = zstd(good);
  std::string flipped = packed;
  flipped[packed.size() / 2] = static_cast<char>(flipped[packed.size() / 2] ^ 0x55);
  const std::string whole = glb();
  struct Case {
    std::string name;
    std::string bytes;
    std::vector<std::string> words;
  };
  const std::vector<Case> cases{
      {"a.stl", "solid", {"extension", ".ply.zst"}},
      {"a.zst", packed, {"extension"}},
      {"a.glb", whole.substr(0, whole.size() / 2), {"is cut"}},
      {"b.glb", whole.substr(0, 10), {"is cut"}},
      {"c.glb", "", {"is cut"}},
      {"a.gltf", gltf().substr(0, 300), {"JSON"}},
      {"b.gltf", "[1]", {"JSON"}},
      {"c.gltf",
       replaced(gltf(), "\"count\":4", "\"count\":3"),
       {"face 1", "mesh 0", "index 3", "3 vertices"}},
      {"d.gltf", replaced(gltf(), "\"count\":6", "\"count\":9"), {"mesh 0", "past the end"}},
      {"s.gltf",
       replaced(gltf(), "\"byteOffset\":48,", "\"byteStride\":0,\"byteOffset\":48,"),
       {"mesh 0, primitive 0", "byteStride of 0"}},
      {"e.gltf", replaced(gltf(), "\"count\":6", "\"count\":5"), {"multiple of 3"}},
      {"f.gltf", gltf(",\"uri\":\"none.bin\""), {"`none.bin`", "missing"}},
      {"k.gltf", replaced(gltf(), "\"scale\":[2,2,2]", "\"children\":[0]"), {"k.gltf"}},
      {"l.gltf", replaced(gltf(), "\"yfov\":0.5", "\"yfov\":3.2"), {"camera", "degrees"}},
      {"m.gltf", replaced(gltf(), "\"yfov\":0.5", "\"yfov\":\"x\""), {"m.gltf"}},
      {"g.gltf", replaced(gltf(), "\"indices\":1", "\"indices\":7"), {"7"}},
      {"h.gltf", replaced(gltf(), "\"indices\":1", "\"indices\":\"x\""), {"glTF"}},
      {"i.gltf", replaced(gltf(), "[1,2,3]", "[1e39,2,3]"), {"i.gltf"}},
      {"j.gltf", replaced(gltf(), "[0.25,", "[-0.25,"), {"material 0", "baseColorFactor"}},
      {"a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nf 1 2 4\n", {"line 5", "index 4", "3 vert"}},
      {"b.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 0\n", {"line 4", "index 0"}},
      {"c.obj", "v 0 0 0\nv 1 0 0\nf -1 -2 -3\nv 1 1 0\n", {"line 3", "index -3"}},
      {"d.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 x\n", {"line 4", "`x`"}},
      {"e.obj", "v 0 0 0\nv 1 0\nv 1 1 0\nf 1 2 3\n", {"line 2", "3 numbers"}},
      {"f.obj", "v 0 0 0\nv 1 0 zero\nv 1 1 0\nf 1 2 3\n", {"line 2", "`zero`"}},
      {"g.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 99999999999999999999\n", {"line 4"}},
      {"a.ply", "", {"not a PLY"}},
      {"b.ply", "plyformat", {"end_header"}},
      {"c.ply", good.substr(0, 60), {"end_header"}},
      {"d.ply", good.substr(0, good.size() - 1), {"is cut", "3 faces"}},
      {"e.ply", good + "x", {"1 bytes follow"}},
      {"f.ply", replaced(good, "vertex 4", "vertex x"), {"line 3", "`x`"}},
      {"g.ply", replaced(good, "vertex 4", "vertex -4"), {"line 3", "`-4`"}},
      {"h.ply", replaced(good, "vertex 4", "vertex 4000000000"), {"line 3", "4000000000"}},
      {"i.ply", replaced(good, "element", "elephant"), {"line 3", "elephant"}},
      {"j.ply", replaced(good, "float x", "flat x"), {"line 4", "`flat`"}},
      {"k.ply", replaced(good, "binary_little_endian", "binary_middle_endian"), {"line 2"}},
      {"l.ply", replaced(good, "property float x", "property"), {"line 4", "property"}},
      {"m.ply", ply(kSquare, {{0, 1, 2}, {0, 4, 1}}), {"face 1", "index 4", "4 vertices"}},
      {"n.ply", ply(kSquare, {{0, 1, 0xFFFFFFFFU}}), {"face 0", "index -1"}},
      {"o.ply", ascii.substr(0, ascii.size() - 4), {"cut in face 3"}},
      {"p.ply", ascii.substr(0, ascii.find("1 1 0")), {"cut in vertex 2"}},
      {"q.ply", ascii + "7", {"1 bytes follow"}},
      {"r.ply", replaced(ascii, "3 0 0 1", "3 0 4 1"), {"face 1", "index 4"}},
      {"s.ply", replaced(ascii, "3 0 0 1", "3 0 -1 1"), {"face 1", "index -1"}},
      {"t.ply", replaced(ascii, "1 1 0", "1 one 0"), {"vertex 2", "`one`"}},
      {"u.ply", replaced(ascii, "face 4", "face 40"), {"cut in face 4"}},
      {"a.ply.zst", packed.substr(0, packed.size() / 2), {"Zstandard"}},
      {"b.ply.zst", flipped, {"b.ply.zst"}},
      {"c.ply.zst", "", {"Zstandard", "cut"}},
      {"d.ply.zst", good, {"Zstandard", "corrupt"}},
      {"e.ply.zst", packed + "garbage", {"Zstandard"}},
      {"f.ply.zst", zstd(good.substr(0, good.size() - 5)), {"is cut"}},
  };
  for (const Case& c : cases) {
    CAPTURE(c.name);
    auto words = c.words;
    words.push_back(c.name);
    const auto path = dir.file(c.name, c.bytes);
    check_error([&] { (void)load_scene(path); }, words);
  }
  check_error([&] { (void)load_scene(dir / "none.gltf"); }, {"none.gltf", "no such file"});
  check_error([&] { (void)load_scene(dir / ""); }, {"folder"});
  std::filesystem::create_directory(dir / "sub.obj");
  check_error([&] { (void)load_scene(dir / "sub.obj"); }, {"sub.obj", "folder"});
}

TEST_CASE("a description beside the scene that is wrong is refused by key") {
  const TempDir dir;
  const auto path = dir.file("a.ply", ply(kSquare, kFaces, {0, 0, 1}));
  struct Case {
    std::string json;
    std::string word;
  };
  const std::vector<Case> cases{
      {"", "line 1"},
      {"{\n\"camera\":\n {,}}", "line 3"},
      {"[]", "JSON object"},
      {R"({"camera": 1})", "`camera`"},
      {R"({"camera": {"eye": [0, 0, 1]}})", "`camera.target`"},
      {R"({"camera": {"eye": [0, 0], "target": [0, 0, 0]}})", "`camera.eye`"},
      {R"({"camera": {"eye": [0, 0, "1"], "target": [0, 0, 0]}})", "`camera.eye[2]`"},
      {R"({"camera": {"eye": [0, 0, 1e39], "target": [0, 0, 0]}})", "`camera.eye[2]`"},
      {R"({"camera": {"eye": [0, 0, 1e999], "target": [0, 0, 0]}})", "too large"},
      {R"({"camera": {"eye": [0, 0, NaN], "target": [0, 0, 0]}})", "line 1"},
      {R"({"camera": {"eye": [0, 0, 1], "target": [0, 0, 1]}})", "`camera.target`"},
      {R"({"camera": {"eye": [0, 0, 1], "target": [0, 0, 0], "fov_y_deg": 180}})", "fov_y_deg"},
      {R"({"camera": {"eye": [0, 0, 1], "target": [0, 0, 0], "fov_y_deg": null}})", "fov_y_deg"},
      {R"({"camera": {"eye": [0, 0, 1], "target": [0, 0, 0], "up": {}}})", "`camera.up`"},
      {R"({"lights": {}})", "`lights`"},
      {R"({"lights": [[1, 2]]})", "`lights[0]`"},
      {R"({"lights": [[1, 2, 3], [1, 2, 3, 4, 5, -6]]})", "`lights[1]`"},
      {R"({"lights": [[1, 2, "3"]]})", "`lights[0][2]`"},
      {R"({"materials": {}})", "`materials`"},
      {R"({"materials": [7]})", "`materials[0]`"},
      {R"({"materials": [{}, {"name": 7}]})", "`materials[1].name`"},
      {R"({"materials": [{}, {"Kd": [1, 2]}]})", "`materials[1].Kd`"},
      {R"({"materials": [{}, {"Kd": [1, -2, 1]}]})", "`materials[1].Kd`"},
      {R"({"materials": [{"Ke": [1, 2, true]}, {}]})", "`materials[0].Ke[2]`"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.json);
    (void)dir.file("a.json", c.json);
    check_error([&] { (void)load_scene(path); }, {"a.json", c.word});
  }
  (void)dir.file("a.json", R"({"materials": [{}]})");
  check_error([&] { (void)load_scene(path); }, {"a.ply", "face 2", "material 1", "1 are"});
}

}  // namespace
