// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "import/import.hpp"
#include "io/file.hpp"

namespace ti {

std::optional<Animation> read_sequence(const std::filesystem::path& path, const Scene& scene) {
  using Json = nlohmann::json;
  const Json json = Json::parse(read_file(path));
  if (!json.contains("frames_file")) return std::nullopt;
  const auto fail = [&path](const std::string& key, const std::string& must) {
    return Error(fmt::format("{}: `{}` must be {}; correct it", path.string(), key, must));
  };
  if (!json["frames_file"].is_string()) throw fail("frames_file", "the name of a file");
  const Json times = json.value("times_s", Json());
  if (!times.is_array() || times.empty()) throw fail("times_s", "an array of seconds");
  check_frames(path.string(), static_cast<double>(times.size()));

  const std::filesystem::path file = path.parent_path() / json["frames_file"].get<std::string>();
  std::string bytes = read_file(file);
  if (file.extension() == ".zst") bytes = unpack_zstd(bytes, file.string());
  const std::size_t count = scene.mesh.vertices.size();
  const std::size_t frame_bytes = count * sizeof(glm::vec3);
  if (bytes.size() != times.size() * frame_bytes)
    throw Error(
        fmt::format("{}: it has {} bytes, and {} frames of {} vertices take {}; copy or "
                    "export it again",
                    file.string(), bytes.size(), times.size(), count, times.size() * frame_bytes));
  const auto place = [&bytes, frame_bytes](std::size_t frame, std::size_t vertex) {
    glm::vec3 out;
    std::memcpy(&out, bytes.data() + frame * frame_bytes + vertex * sizeof out, sizeof out);
    return out;
  };

  Animation out;
  for (std::size_t v = 0; v < count; ++v) {
    bool moves = false;
    for (std::size_t f = 0; f < times.size() && !moves; ++f)
      moves = place(f, v) != scene.mesh.vertices[v];
    if (moves) out.moving.push_back(static_cast<std::uint32_t>(v));
  }
  for (std::size_t f = 0; f < times.size(); ++f) {
    if (!times[f].is_number()) throw fail(fmt::format("times_s[{}]", f), "a number");
    Animation::Frame frame{.seconds = times[f].get<double>(),
                           .positions = {},
                           .camera = scene.camera,
                           .lights = scene.lights};
    for (const std::uint32_t v : out.moving) frame.positions.push_back(place(f, v));
    out.frames.push_back(std::move(frame));
  }
  return out;
}

}  // namespace ti
