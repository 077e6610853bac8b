// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "import/materials.hpp"
#include "scene/scene.hpp"
#include "test/scene_files.hpp"
#include "test/support.hpp"

namespace ti {
namespace {

using namespace test;

TEST_CASE("materials of Wavefront are what illum says") {
  MtlValues values;
  values.kd = glm::vec3(0.2F);
  values.ks = glm::vec3(0.5F);
  values.ns = 98.0F;
  values.ni = 1.3F;
  const auto of = [&values](int illum) {
    values.illum = illum;
    return material_of(values);
  };
  for (const int illum : {0, 1, 2, 3, 5}) CHECK(of(illum).diffuse == values.kd);
  CHECK(of(1).specular == glm::vec3(0.0F));
  CHECK(of(2).is_glossy());
  CHECK(of(2).roughness == doctest::Approx(std::sqrt(0.02)));
  CHECK(of(3).is_mirror());
  CHECK(of(3).schlick == 0.0F);
  CHECK(!of(3).is_glass());
  CHECK(of(5).is_mirror());
  CHECK(of(5).schlick == 1.0F);
  CHECK(of(7).is_glass());
  CHECK(of(7).transmission == glm::vec3(1.0F));
  CHECK(of(7).ior == 1.3F);
  values.tr = 0.25F;
  values.tf = glm::vec3(0.5F, 1.0F, 0.0F);
  CHECK(of(3).transmission == glm::vec3(0.125F, 0.25F, 0.0F));
  CHECK(of(7).transmission == *values.tf);
}

TEST_CASE("materials of glTF mix metal, matt surfaces and glass") {
  GltfValues values;
  values.base = {0.8F, 0.4F, 0.2F};
  values.roughness = 0.5F;
  const Material metal = material_of(values);
  CHECK(metal.specular == values.base);
  CHECK(metal.schlick == 1.0F);
  CHECK(metal.roughness == 0.25F);
  CHECK(!metal.is_diffuse());
  values.metallic = 0.0F;
  const Material plastic = material_of(values);
  CHECK(plastic.specular.x == doctest::Approx(0.04F));
  CHECK(plastic.diffuse.x == doctest::Approx(0.8F * 0.96F));
  values.roughness = 1.0F;
  const Material matt = material_of(values);
  CHECK(matt.diffuse == values.base);
  CHECK(!matt.is_glossy());
  CHECK(!matt.is_mirror());
  values.roughness = 0.0F;
  CHECK(material_of(values).is_mirror());
  values.transmission = 1.0F;
  const Material glass = material_of(values);
  CHECK(glass.transmission == values.base);
  CHECK(!glass.is_diffuse());
  CHECK(!glass.is_mirror());
  for (const float metallic : {0.0F, 0.3F, 1.0F}) {
    for (const float transmission : {0.0F, 0.4F, 1.0F}) {
      values.base = glm::vec3(1.0F);
      values.metallic = metallic;
      values.transmission = transmission;
      Material mixed = material_of(values);
      CHECK(!keep_energy(mixed));
      CHECK(fault_of(mixed).empty());
    }
  }
}

TEST_CASE("a material that reflects more than it gets is scaled, its colours kept") {
  Material m{.diffuse = {0.8F, 0.4F, 0.0F}, .specular = glm::vec3(0.8F)};
  CHECK(keep_energy(m));
  CHECK(m.diffuse.x + m.specular.x == doctest::Approx(1.0F));
  CHECK(m.diffuse.x == doctest::Approx(2.0F * m.diffuse.y));
  CHECK(!keep_energy(m));
}

TEST_CASE("faults of a material name its field") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(fault_of({.diffuse = {0, nan, 0}}).find("Kd") != std::string::npos);
  CHECK(fault_of({.specular = {0, -1, 0}}).find("Ks") != std::string::npos);
  CHECK(fault_of({.roughness = nan}).find("Ns") != std::string::npos);
  CHECK(fault_of({.emission = glm::vec3(INFINITY)}).find("Ke") != std::string::npos);
  CHECK(fault_of({.transmission = glm::vec3(0.5F), .ior = 0.0F}).find("Ni") != std::string::npos);
  CHECK(fault_of({.transmission = glm::vec3(0.5F), .ior = nan}).find("Ni") != std::string::npos);
  CHECK(fault_of({.ior = 0.0F}).empty());  // of no matter without glass
}

TEST_CASE("the JSON beside a scene has lights of each kind, a lens and a sky") {
  const TempDir dir;
  (void)dir.file("a.json", R"({"background": [0.1, 0.2, 0.3],
 "camera": {"eye": [0,0,5], "target": [0,0,0], "aperture": 0.5, "focus_distance": 4},
 "lights": [[1,2,3], [1,2,3, 4,5,6],
  {"kind": "spot", "name": "s", "position": [0,3,0], "direction": [0,-2,0], "intensity": [7,7,7],
   "inner_deg": 0, "outer_deg": 60, "range": 9},
  {"kind": "directional", "direction": [0,0,1]}],
 "materials": [{"Kd": [0.5,0.5,0.5], "d": 0.75, "illum": 3, "Ni": 1.5}]})");
  const Scene s = load_scene(dir.file("a.ply", ply(kSquare, kFaces)));
  CHECK(s.background == glm::vec3(0.1F, 0.2F, 0.3F));
  CHECK(s.camera.aperture == 0.5F);
  CHECK(s.camera.focus_distance == 4.0F);
  REQUIRE(s.lights.size() == 4);
  CHECK(s.lights[0].intensity == glm::vec3(1.0F));
  CHECK(s.lights[1].intensity == glm::vec3(4, 5, 6));
  CHECK(s.lights[2].kind == LightKind::Spot);
  CHECK(s.lights[2].direction == glm::vec3(0, -1, 0));
  CHECK(s.lights[2].cos_inner == 1.0F);
  CHECK(s.lights[2].cos_outer == doctest::Approx(0.5F));
  CHECK(s.lights[2].range == 9.0F);
  CHECK(s.lights[3].kind == LightKind::Directional);
  CHECK(s.materials[0].transmission == glm::vec3(0.25F));
}

TEST_CASE("values of lights and materials that cannot be are refused by file, place and field") {
  const auto refused = [](const std::string& json, const std::vector<std::string>& words) {
    CAPTURE(json);
    const TempDir dir;
    (void)dir.file("a.json", json);
    const auto path = dir.file("a.ply", ply(kSquare, kFaces));
    std::vector<std::string> all = words;
    all.emplace_back("a.json");
    check_error([&] { (void)load_scene(path); }, all);
  };
  refused(R"({"lights": [{"kind": "area"}]})", {"lights[0].kind", "spot"});
  refused(R"({"lights": [{"kind": 7}]})", {"lights[0].kind"});
  refused(R"({"lights": [{"kind": "point"}]})", {"lights[0].position"});
  refused(R"({"lights": [{"kind": "directional"}]})", {"lights[0].direction"});
  refused(R"({"lights": [{"position": [0,0,0], "colour": [1,1,1]}]})", {"lights[0].colour"});
  refused(R"({"lights": [{"position": [0,0,0], "intensity": [1,-1,1]}]})", {"lights[0].intensity"});
  refused(R"({"lights": [{"kind": "spot", "position": [0,0,0], "direction": [0,0,1],
              "inner_deg": 50}]})",
          {"lights[0].outer_deg"});
  refused(R"({"camera": {"eye": [0,0,1], "target": [0,0,0], "aperture": -1}})",
          {"camera.aperture"});
  refused(R"({"camera": {"eye": [0,0,1], "target": [0,0,0], "fov": 1}})", {"camera.fov"});
  refused(R"({"background": [0, -1, 0]})", {"background"});
  refused(R"({"materials": [{"name": "m", "Tr": 1.5}]})", {"materials[0] (m).Tr"});
  refused(R"({"materials": [{"name": "m", "Ns": -1}]})", {"materials[0] (m).Ns"});
  refused(R"({"materials": [{"name": "m", "Ni": -1}]})", {"materials[0] (m).Ni"});
  refused(R"({"materials": [{"name": "m", "illum": 2.5}]})", {"materials[0] (m).illum"});
  refused(R"({"materials": [{"name": "m", "Ks": [0, 0, 1e99]}]})", {"materials[0] (m).Ks"});
  const auto named = [](const std::string& json, const std::vector<std::string>& words) {
    const TempDir dir;
    (void)dir.file("a.json", json);
    const auto path = dir.file("a.ply", ply(kSquare, kFaces));
    check_error([&] { (void)load_scene(path); }, words);
  };
  named(R"({"materials": [{"name": "ice", "illum": 7, "Ni": 0}]})",
        {"a.ply", "material 0", "ice", "Ni", "0"});
  named(R"({"lights": [{"kind": "directional", "direction": [0,0,0]}]})",
        {"a.ply", "light 0", "direction"});
  named(R"({"lights": [{"position": [0,0,0], "range": 0}]})", {"a.ply", "light 0", "range"});
}

TEST_CASE("a glTF has lights of each kind, and its faults name material, light and field") {
  const auto with = [](const std::string& light) {
    std::string text =
        replaced(gltf(), R"("camera":0,)", R"("extensions":{"KHR_lights_punctual":{"light":0}},)");
    return replaced(
        text, R"("asset")",
        R"("extensions":{"KHR_lights_punctual":{"lights":[)" + light + R"(]}},"asset")");
  };
  const TempDir dir;
  const Scene spot = load_scene(dir.file(
      "s.gltf", with(R"({"type":"spot","intensity":2,"range":7,"spot":{"outerConeAngle":1}})")));
  REQUIRE(spot.lights.size() == 1);
  CHECK(spot.lights[0].kind == LightKind::Spot);
  CHECK(spot.lights[0].position == glm::vec3(1, 2, 3));
  CHECK(spot.lights[0].direction.z == doctest::Approx(1.0F));  // its node turns -z around
  CHECK(spot.lights[0].cos_outer == doctest::Approx(std::cos(1.0)));
  CHECK(spot.lights[0].range == 7.0F);
  const Scene sun =
      load_scene(dir.file("d.gltf", with(R"({"type":"directional","color":[1,0,0]})")));
  CHECK(sun.lights[0].kind == LightKind::Directional);
  CHECK(sun.lights[0].intensity == glm::vec3(1, 0, 0));
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    CAPTURE(words[0]);
    const auto path = dir.file("x.gltf", text);
    check_error([&] { (void)load_scene(path); }, words);
  };
  refused(with(R"({"type":"area","name":"lamp"})"), {"x.gltf", "light 0", "lamp", "type"});
  refused(with(R"({"type":"point","intensity":-1})"), {"light 0", "intensity"});
  refused(with(R"({"type":"spot","spot":{"innerConeAngle":1,"outerConeAngle":0.5}})"),
          {"light 0", "innerConeAngle"});
  const std::string factor = R"("baseColorFactor":[0.25,0.5,0.75,1])";
  refused(replaced(gltf(), factor, factor + R"(,"roughnessFactor":2)"),
          {"x.gltf", "material 0", "m", "roughnessFactor"});
  refused(replaced(gltf(), factor, factor + R"(},"extensions":{"KHR_materials_ior":{"ior":0.5})"),
          {"material 0", "ior"});
}

TEST_CASE("the materials of a glTF keep their faces, also when they share a name") {
  const TempDir dir;
  const auto file = [&dir](const char* first, const char* second) {
    std::string text = replaced(
        gltf(), R"("materials":[{"name":"m",)",
        std::string(R"("materials":[{)") + first +
            R"("pbrMetallicRoughness":{"baseColorFactor":[0.1,0.1,0.1,1],"metallicFactor":0}},{)" +
            second);
    text = replaced(text, R"("mesh":0,"scale")", R"("mesh":1,"scale")");
    return dir.file("a.gltf", replaced(text, R"("material":0}]}])",
                                       R"("material":1}]},
{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}])"));
  };
  for (const auto& [first, second] : {std::pair{R"("name":"a",)", R"("name":"b",)"},
                                      {R"("name":"m",)", R"("name":"m",)"},
                                      {"", ""}}) {
    const Scene s = load_scene(file(first, second));
    // The node with mesh 1 comes first.
    CHECK(s.material_of(0).diffuse == glm::vec3(0.1F));
    CHECK(s.material_of(2).specular == glm::vec3(0.25F, 0.5F, 0.75F));
  }
}

TEST_CASE("the benchmark scenes have the mirrors, the glass and the lights of their descriptions") {
  const auto folder = root() / "../shared/scenes";
  if (!std::filesystem::exists(folder / "cornell_box_mirror.ply.zst")) {
    MESSAGE("skipped: ../shared/scenes is missing");
    return;
  }
  const auto count = [&](const char* name, auto has) {
    const Scene s = load_scene(folder / (std::string(name) + ".ply.zst"));
    return std::count_if(s.materials.begin(), s.materials.end(), has);
  };
  const auto mirror = [](const Material& m) { return m.is_mirror(); };
  const auto glass = [](const Material& m) { return m.is_glass(); };
  const auto lamp = [](const Material& m) { return m.is_emissive(); };
  CHECK(count("cornell_box", mirror) == 0);
  CHECK(count("cornell_box", lamp) == 1);
  CHECK(count("cornell_box_mirror", mirror) == 1);
  CHECK(count("cornell_box_sphere", glass) == 1);
  CHECK(count("cornell_box_water", glass) == 2);
  CHECK(count("bart_kitchen", mirror) == 21);
  CHECK(count("bart_kitchen", glass) == 2);
  CHECK(load_scene(folder / "bart_kitchen.ply.zst").lights.size() == 6);
}

}  // namespace
}  // namespace ti
