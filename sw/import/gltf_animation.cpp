// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "import/gltf_scene.hpp"
#include "import/import.hpp"

namespace ti {

namespace {

using Json = nlohmann::json;

enum class Property { Translation, Rotation, Scale };
enum class Between { Step, Linear, Spline };

/// One property of one node over time.
struct Track {
  std::size_t node = 0;
  Property property = Property::Translation;
  Between between = Between::Linear;
  std::size_t components = 3;
  std::vector<float> times;
  std::vector<float> values;  ///< of a spline: in-tangent, value, out-tangent of each key

  /// The value `part` (of a spline: 0, 1, 2) of a key.
  [[nodiscard]] glm::dvec4 key(std::size_t i, std::size_t part) const {
    const std::size_t at = between == Between::Spline ? 3 * i + part : i;
    glm::dvec4 out(0.0);
    for (std::size_t k = 0; k < components; ++k)
      out[static_cast<int>(k)] = values[at * components + k];
    return out;
  }

  [[nodiscard]] glm::dvec4 at(double time) const;
};

glm::dquat quaternion(const glm::dvec4& v) { return {v.w, v.x, v.y, v.z}; }

glm::dvec4 Track::at(double time) const {
  const auto next = std::upper_bound(times.begin(), times.end(), time,
                                     [](double t, float key) { return t < double{key}; });
  if (next == times.begin()) return key(0, 1);
  const auto i = static_cast<std::size_t>(next - times.begin() - 1);
  if (next == times.end() || between == Between::Step) return key(i, 1);
  const double span = double{times[i + 1]} - double{times[i]};
  const double s = (time - double{times[i]}) / span;
  if (between == Between::Spline) {
    const double s2 = s * s;
    const double s3 = s2 * s;
    return (2 * s3 - 3 * s2 + 1) * key(i, 1) + span * (s3 - 2 * s2 + s) * key(i, 2) +
           (3 * s2 - 2 * s3) * key(i + 1, 1) + span * (s3 - s2) * key(i + 1, 0);
  }
  if (property != Property::Rotation) return (1.0 - s) * key(i, 1) + s * key(i + 1, 1);
  const glm::dquat q = glm::slerp(quaternion(key(i, 1)), quaternion(key(i + 1, 1)), s);
  return {q.x, q.y, q.z, q.w};
}

/// The tracks of the first animation.
class Reader {
 public:
  explicit Reader(GltfFile& gltf) : gltf_(gltf), json_(gltf.json()) {}

  [[nodiscard]] std::vector<Track> tracks(std::vector<std::string>& warnings) {
    std::vector<Track> out;
    if (!json_.contains("animations") || json_["animations"].empty()) return out;
    if (json_["animations"].size() > 1)
      warnings.push_back(gltf_.name() + ": the first of several animations is played");
    const Json& animation = json_["animations"][0];
    bool weights = false;
    for (const Json& channel : animation.at("channels")) {
      const Json& target = channel.at("target");
      if (!target.contains("node")) continue;
      const std::string path = target.at("path");
      weights = weights || path == "weights";
      if (path == "weights") continue;
      out.push_back(track(animation.at("samplers").at(channel.at("sampler").get<std::size_t>()),
                          target["node"], path));
    }
    if (weights)
      warnings.push_back(gltf_.name() + ": morph targets are not read; they stand still");
    return out;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(fmt::format("{}: {}; export it again", gltf_.name(), what));
  }

  Track track(const Json& sampler, std::size_t node, const std::string& path) {
    Track out;
    out.node = node;
    const std::string what = fmt::format("the {} of node {}", path, node);
    if (node >= json_.at("nodes").size()) fail(what + " moves, and there is no such node");
    if (json_["nodes"][node].contains("matrix")) fail(what + " moves, but the node has a matrix");
    if (path == "rotation")
      out.property = Property::Rotation;
    else if (path == "scale")
      out.property = Property::Scale;
    else if (path != "translation")
      fail(what + " moves, and that is none of translation, rotation and scale");
    out.components = out.property == Property::Rotation ? 4 : 3;
    const std::string between = sampler.value("interpolation", std::string("LINEAR"));
    if (between == "STEP")
      out.between = Between::Step;
    else if (between == "CUBICSPLINE")
      out.between = Between::Spline;
    else if (between != "LINEAR")
      fail(fmt::format("{} is interpolated by `{}`", what, between));
    out.times = gltf_.floats(sampler.at("input"), 1, "the times of " + what);
    out.values = gltf_.floats(sampler.at("output"), out.components, "the keys of " + what);
    const std::size_t parts = out.between == Between::Spline ? 3 : 1;
    if (out.values.size() != out.times.size() * out.components * parts)
      fail(fmt::format("{} has {} times, and other many keys", what, out.times.size()));
    for (std::size_t i = 0; i < out.times.size(); ++i) {
      if (!(out.times[i] >= 0.0F) || (i > 0 && !(out.times[i] > out.times[i - 1])))
        fail(fmt::format("the times of {} do not grow from 0 on", what));
    }
    if (std::any_of(out.values.begin(), out.values.end(),
                    [](float x) { return !std::isfinite(x); }))
      fail(fmt::format("the keys of {} are not all finite", what));
    return out;
  }

  GltfFile& gltf_;
  const Json& json_;
};

Pose pose_at(const Json& json, const std::vector<Track>& tracks, double time) {
  Pose pose = rest_pose(json);
  std::set<std::size_t> nodes;
  for (const Track& track : tracks) nodes.insert(track.node);
  for (const std::size_t node : nodes) {
    Placement placement = placement_of(json["nodes"][node]);
    for (const Track& track : tracks) {
      if (track.node != node) continue;
      const glm::dvec4 value = track.at(time);
      switch (track.property) {
        case Property::Translation:
          placement.translation = value;
          break;
        case Property::Rotation:
          placement.rotation = glm::normalize(value);
          break;
        case Property::Scale:
          placement.scale = value;
          break;
      }
    }
    pose[node] = transform_of(placement);
  }
  return pose;
}

/// Marks the nodes of the default scene that some track moves, by themselves or by a parent.
std::vector<bool> moving_nodes(const Json& json, const std::vector<Track>& tracks) {
  std::vector<bool> moving(json.at("nodes").size());
  const std::function<void(std::size_t)> mark = [&](std::size_t node) {
    if (moving.at(node)) return;
    moving[node] = true;
    if (!json["nodes"][node].contains("children")) return;
    for (const Json& child : json["nodes"][node]["children"]) mark(child);
  };
  for (const Track& track : tracks) mark(track.node);
  return moving;
}

}  // namespace

Animation gltf_animation(GltfFile& gltf, Import& import, double fps) {
  const Json& json = gltf.json();
  Scene& scene = import.scene;
  const std::vector<Track> tracks = Reader(gltf).tracks(scene.warnings);
  Animation out;
  float end = 0.0F;
  for (const Track& track : tracks) end = std::max(end, track.times.back());
  const double count = std::max(1.0, std::ceil(double{end} * fps - 1e-6));
  check_frames(gltf.name(), count);
  const std::vector<bool> moving =
      tracks.empty() ? std::vector<bool>() : moving_nodes(json, tracks);

  // Nodes with meshes, in the order in which the importer met them.
  std::vector<std::size_t> with_mesh;
  if (!tracks.empty()) {
    visit_nodes(json, rest_pose(json), gltf.name(), [&](std::size_t node, const glm::dmat4&) {
      if (json["nodes"][node].contains("mesh")) with_mesh.push_back(node);
    });
    if (with_mesh.size() != import.nodes.size())
      throw Error(
          fmt::format("{}: {} nodes have meshes, and {} were read, so that what moves is "
                      "not known; leave out empty meshes",
                      gltf.name(), with_mesh.size(), import.nodes.size()));
  }
  for (std::size_t k = 0; k < with_mesh.size(); ++k) {
    if (!moving[with_mesh[k]]) continue;
    for (std::size_t i = 0; i < import.nodes[k].local.size(); ++i)
      out.moving.push_back(static_cast<std::uint32_t>(import.nodes[k].first_vertex + i));
  }

  for (std::size_t f = 0; f < static_cast<std::size_t>(count); ++f) {
    Animation::Frame frame{.seconds = static_cast<double>(f) / fps,
                           .positions = {},
                           .camera = scene.camera,
                           .lights = scene.lights};
    if (!tracks.empty()) {
      const Pose pose = pose_at(json, tracks, frame.seconds);
      std::vector<glm::dmat4> world(pose.size(), glm::dmat4(1.0));
      bool camera = false;
      visit_nodes(json, pose, gltf.name(), [&](std::size_t node, const glm::dmat4& transform) {
        world[node] = transform;
        if (camera || !moving[node] || json["nodes"][node].value("camera", -1) != 0) return;
        camera = true;
        if (!import.has_camera) return;
        frame.camera.eye = glm::vec3(transform[3]);
        frame.camera.target = glm::vec3(transform * glm::dvec4(0.0, 0.0, -1.0, 1.0));
        frame.camera.up = glm::vec3(transform * glm::dvec4(0.0, 1.0, 0.0, 0.0));
      });
      const std::vector<Light> lights = gltf_lights(json, pose, gltf.name());
      if (!lights.empty()) frame.lights = lights;
      for (std::size_t k = 0; k < with_mesh.size(); ++k) {
        if (!moving[with_mesh[k]]) continue;
        for (const glm::vec3& place : import.nodes[k].local)
          frame.positions.emplace_back(world[with_mesh[k]] * glm::dvec4(place, 1.0));
      }
    }
    out.frames.push_back(std::move(frame));
  }
  return out;
}

}  // namespace ti
