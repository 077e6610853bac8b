// SPDX-License-Identifier: Apache-2.0
#include "engine/stored_image.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "accel/prepare.hpp"
#include "base/error.hpp"

namespace ti {
namespace {

template <typename T>
bool same_bytes(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

/// Number of the first record that `prepared` does not give; the count of records when all are
/// there.
std::size_t first_foreign(const Image& image, const PreparedTriangles& prepared) {
  const auto planes = image.planes();
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const auto found = std::lower_bound(
        prepared.planes.begin(), prepared.planes.end(), planes[i].prim,
        [](const ImagePlane& plane, std::uint32_t prim) { return plane.prim < prim; });
    const auto place = static_cast<std::size_t>(found - prepared.planes.begin());
    if (found == prepared.planes.end() || !same_bytes(*found, planes[i]) ||
        !same_bytes(prepared.barys[place], image.barys()[i])) {
      return i;
    }
  }
  return planes.size();
}

void describe_tree(const Image& image, BuildStats& stats) {
  const auto nodes = image.nodes();
  std::vector<int> depth(nodes.size(), 0);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ImageNode& node = nodes[i];
    stats.depth = std::max(stats.depth, depth[i]);
    if (node.is_leaf()) {
      ++stats.leaves;
      stats.empty_leaves += node.count() == 0 ? 1 : 0;
      stats.largest_leaf = std::max(stats.largest_leaf, node.count());
    } else {  // children stand after their parent
      depth[i + 1] = depth[node.other()] = depth[i] + 1;
    }
  }
  stats.nodes = image.parts().node_count;
  stats.references = image.parts().list_count;
}

}  // namespace

Image load_image_of(const std::filesystem::path& path, const Mesh& mesh, const Config& config,
                    const std::filesystem::path& scene, BuildStats& stats) {
  Image image = Image::load(path);
  const Format format = config.format;
  if (!(image.format() == format)) {
    throw Error(
        fmt::format("{}: the image has the number format {}, the configuration has {}; make it "
                    "again by `make image`",
                    path.string(), name_of(image.format()), name_of(format)));
  }
  const auto layout = static_cast<std::uint8_t>(config.layout);
  if (image.header().layout != layout) {
    throw Error(fmt::format(
        "{}: the image has the layout {}, the configuration has {}; make it again by `make image`",
        path.string(), kLayoutNames[image.header().layout], kLayoutNames[layout]));
  }
  const PreparedTriangles prepared = prepare_triangles(mesh, format);
  const std::size_t foreign = first_foreign(image, prepared);
  if (foreign < image.planes().size() || image.planes().size() != prepared.planes.size()) {
    throw Error(
        fmt::format("{}: its triangles are not those of {} (record {}); the image was made from "
                    "another scene, make it "
                    "again by `make image`",
                    path.string(), scene.string(), foreign));
  }
  stats = {};
  stats.triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  stats.dropped_nonfinite = prepared.dropped_nonfinite;
  stats.dropped_zero_area = prepared.dropped_zero_area;
  describe_tree(image, stats);
  return image;
}

}  // namespace ti
