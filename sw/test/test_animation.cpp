// SPDX-License-Identifier: Apache-2.0
// Frames of glTF node animations and of sequences are what the keys say, or are refused.

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scene/animation.hpp"
#include "test/scene_files.hpp"
#include "test/support.hpp"

namespace {

using namespace ti;
using namespace ti::test;
using Json = nlohmann::json;

/// The square of `gltf` with one animation: node 1 stands under the root, node 3 under node 0.
class Animated {
 public:
  Animated() : json_(Json::parse(gltf())) {
    json_["animations"] = {{{"channels", Json::array()}, {"samplers", Json::array()}}};
  }

  /// Keys of a property of a node; `values` has all components of all keys.
  Animated& track(int node, const char* path, const std::vector<float>& times,
                  const std::vector<float>& values, const char* between = "LINEAR") {
    Json& animation = json_["animations"][0];
    const int input = accessor(times, 1);
    const int output = accessor(values, std::string(path) == "rotation" ? 4 : 3);
    const std::size_t sampler = animation["samplers"].size();
    animation["samplers"].push_back(
        {{"input", input}, {"output", output}, {"interpolation", between}});
    animation["channels"].push_back(
        {{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
    return *this;
  }

  [[nodiscard]] Json& json() { return json_; }
  [[nodiscard]] std::string text() const { return json_.dump(); }
  [[nodiscard]] AnimatedScene load(double fps = 2.0) const {
    const TempDir dir;
    return load_animated_scene(dir.file("a.gltf", text()), fps);
  }

 private:
  int accessor(std::vector<float> values, std::size_t components) {
    const std::size_t count = values.size() / components;
    const std::size_t bytes = 4 * values.size();
    while (values.size() % 3 != 0) values.push_back(0.0F);
    const std::string data(reinterpret_cast<const char*>(values.data()), 4 * values.size());
    json_["buffers"].push_back({{"byteLength", data.size()},
                                {"uri", "data:application/octet-stream;base64," + base64(data)}});
    json_["bufferViews"].push_back(
        {{"buffer", json_["buffers"].size() - 1}, {"byteLength", bytes}});
    const char* const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    json_["accessors"].push_back({{"bufferView", json_["bufferViews"].size() - 1},
                                  {"componentType", 5126},
                                  {"count", count},
                                  {"type", types[components - 1]}});
    return static_cast<int>(json_["accessors"].size() - 1);
  }

  Json json_;
};

/// Corner 0 of the first triangle of the second node with the mesh (node 3 is met before node 1).
constexpr std::size_t kNode3 = 0;
constexpr std::size_t kNode1 = 2;

glm::vec3 corner(AnimatedScene& scene, std::size_t frame, std::size_t triangle) {
  scene.animation.pose(scene.scene, frame);
  return scene.scene.mesh.vertex(triangle, 0);
}

void near(const glm::vec3& a, const glm::vec3& b) {
  CAPTURE(a.x);
  CAPTURE(a.y);
  CAPTURE(a.z);
  CHECK(glm::distance(a, b) < 1e-5F);
}

TEST_CASE("animation: a node moves by linear keys, and the others stand still") {
  AnimatedScene s =
      Animated().track(1, "translation", {0, 1, 2}, {0, 0, 0, 2, 0, 0, 2, 4, 0}).load();
  REQUIRE(s.animation.frames.size() == 4);  // 2 s, 2 frames a second, the end left out
  CHECK(s.animation.moving.size() == 4);
  near(corner(s, 0, kNode1), {0, 0, 0});
  near(corner(s, 1, kNode1), {1, 0, 0});
  near(corner(s, 2, kNode1), {2, 0, 0});
  near(corner(s, 3, kNode1), {2, 2, 0});
  near(corner(s, 3, kNode3), {0, 0, 5});
  CHECK(s.animation.frames[3].seconds == 1.5);
}

TEST_CASE("animation: what a parent does, its children do") {
  AnimatedScene s = Animated().track(0, "translation", {0, 1}, {0, 0, 5, 1, 0, 5}).load();
  REQUIRE(s.animation.frames.size() == 2);
  near(corner(s, 1, kNode3), {0.5F, 0, 5});
  near(corner(s, 1, kNode1), {0, 0, 0});
}

TEST_CASE("animation: steps hold, splines follow their tangents, before the first key all stand") {
  AnimatedScene step =
      Animated().track(1, "translation", {0.5F, 1, 2}, {3, 0, 0, 4, 0, 0, 5, 0, 0}, "STEP").load();
  near(corner(step, 0, kNode1), {3, 0, 0});
  near(corner(step, 1, kNode1), {3, 0, 0});
  near(corner(step, 3, kNode1), {4, 0, 0});
  // Hermite from 0 with slope 4 to 1 with slope 0 over a second, at a half: 0.5 + 4 / 8.
  AnimatedScene spline =
      Animated()
          .track(1, "translation", {0, 1}, {0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0},
                 "CUBICSPLINE")
          .load();
  near(corner(spline, 1, kNode1), {1.0F, 0, 0});
}

TEST_CASE("animation: rotations go the short way along the sphere, and scales scale") {
  const float h = std::sqrt(0.5F);
  AnimatedScene s = Animated()
                        .track(1, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, -h, -h})  // 90 degrees
                        .track(1, "scale", {0, 1}, {1, 1, 1, 3, 1, 1})
                        .load();
  s.animation.pose(s.scene, 1);
  near(s.scene.mesh.vertex(kNode1, 1), {2.0F * h, 2.0F * h, 0});  // (1, 0, 0) at 45 degrees
}

TEST_CASE("animation: the camera and lights move with their nodes") {
  Animated file;
  file.json()["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  file.json()["scenes"][0]["nodes"].push_back(4);
  file.json()["extensions"] = {{"KHR_lights_punctual", {{"lights", {{{"type", "point"}}}}}}};
  AnimatedScene s = file.track(2, "translation", {0, 1}, {1, 2, 3, 3, 2, 3})
                        .track(4, "translation", {0, 1}, {0, 0, 0, 0, 8, 0})
                        .load();
  s.animation.pose(s.scene, 1);
  near(s.scene.camera.eye, {2, 2, 3});
  near(s.scene.camera.target, {2, 2, 4});  // the node looks along +z, turned about y
  REQUIRE(s.scene.lights.size() == 1);
  near(s.scene.lights[0].position, {0, 4, 0});
  CHECK(s.animation.moving.empty());
}

TEST_CASE("animation: a file without one has one frame, the picture of it") {
  const TempDir dir;
  const auto path = dir.file("still.gltf", gltf());
  const AnimatedScene s = load_animated_scene(path, 24.0);
  CHECK(s.animation.frames.size() == 1);
  CHECK(s.animation.moving.empty());
  CHECK(s.scene.mesh.vertices == load_scene(path).mesh.vertices);
}

TEST_CASE("animation: what cannot be played is refused, or said") {
  const auto refused_animation = [](Animated file, const std::vector<std::string>& words) {
    const TempDir dir;
    const auto path = dir.file("a.gltf", file.text());
    check_error([&] { (void)load_animated_scene(path, 24.0); }, words);
  };
  const std::vector<float> keys{0, 0, 0, 1, 1, 1};
  refused_animation(Animated().track(1, "translation", {0, 1}, {0, 0, 0}),
                    {"a.gltf", "node 1", "keys"});
  refused_animation(Animated().track(1, "translation", {1, 1}, keys),
                    {"a.gltf", "node 1", "times"});
  refused_animation(Animated().track(1, "translation", {0, 1}, keys, "BEZIER"), {"BEZIER"});
  refused_animation(Animated().track(77, "translation", {0, 1}, keys), {"77"});
  refused_animation(Animated().track(1, "translation", {0, NAN}, keys), {"node 1", "times"});
  refused_animation(Animated().track(1, "translation", {0, 1}, {0, 0, 0, INFINITY, 1, 1}),
                    {"finite"});
  refused_animation(Animated().track(1, "translation", {0, 1e6F}, keys), {"frames"});
  Animated matrix = Animated().track(1, "translation", {0, 1}, keys);
  matrix.json()["nodes"][1]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  refused_animation(matrix, {"node 1", "matrix"});
  Animated cut = Animated().track(1, "translation", {0, 1}, keys);
  cut.json()["accessors"].back()["count"] = 1000;
  refused_animation(cut, {"a.gltf", "out of range"});
  Animated two = Animated().track(1, "translation", {0, 1}, keys);
  two.json()["animations"].push_back(two.json()["animations"][0]);
  const AnimatedScene s = two.load();
  REQUIRE(s.scene.warnings.size() == 1);
  CHECK(s.scene.warnings[0].find("first of several") != std::string::npos);
}

/// Frames of the square as float32 positions, each a unit higher.
std::string positions(std::size_t frames) {
  std::vector<glm::vec3> all;
  for (std::size_t f = 0; f < frames; ++f)
    for (const glm::vec3& v : kSquare)
      all.push_back(v + glm::vec3(0, 0, v.x == 0.0F ? 0.0F : static_cast<float>(f)));
  return {reinterpret_cast<const char*>(all.data()), 12 * all.size()};
}

TEST_CASE(
    "sequence: positions of each frame, packed or not; vertices that never move are left out") {
  for (const bool packed : {false, true}) {
    const TempDir dir;
    const std::string name = packed ? "s.f32.zst" : "s.f32";
    const auto path = dir.file("s.ply", ply(kSquare, kFaces));
    (void)dir.file("s.json", R"({"frames_file":")" + name + R"(","times_s":[5,5.5,6]})");
    (void)dir.file(name, packed ? zstd(positions(3)) : positions(3));
    AnimatedScene s = load_animated_scene(path, 24.0);
    REQUIRE(s.animation.frames.size() == 3);
    CHECK(s.animation.frames[1].seconds == 5.5);
    CHECK(s.animation.moving == std::vector<std::uint32_t>{1, 2});
    s.animation.pose(s.scene, 2);
    CHECK(s.scene.mesh.vertices[1] == glm::vec3(1, 0, 2));
    CHECK(s.scene.mesh.vertices[0] == glm::vec3(0, 0, 0));
    const Box reach = s.animation.reach(s.scene);
    CHECK(reach.hi[2] == 2.0);
    CHECK(reach.lo[2] == 0.0);
  }
}

TEST_CASE("sequence: a file that does not fit is refused") {
  const auto refused_sequence = [](const std::string& json, const std::string& bytes,
                                   const std::vector<std::string>& words) {
    const TempDir dir;
    const auto path = dir.file("s.ply", ply(kSquare, kFaces));
    (void)dir.file("s.json", json);
    (void)dir.file("s.f32", bytes);
    check_error([&] { (void)load_animated_scene(path, 24.0); }, words);
  };
  const std::string good = R"({"frames_file":"s.f32","times_s":[0,1]})";
  refused_sequence(good, positions(2).substr(1), {"s.f32", "95", "96"});
  refused_sequence(good, positions(3), {"s.f32", "144"});
  refused_sequence(R"({"frames_file":"no.f32","times_s":[0,1]})", "", {"no.f32"});
  refused_sequence(R"({"frames_file":7,"times_s":[0]})", "", {"s.json", "frames_file"});
  refused_sequence(R"({"frames_file":"s.f32"})", "", {"s.json", "times_s"});
  refused_sequence(R"({"frames_file":"s.f32","times_s":[0,"x"]})", positions(2), {"times_s[1]"});
}

}  // namespace
