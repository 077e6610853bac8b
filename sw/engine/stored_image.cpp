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
std::uint32_t first_foreign(const Image& image, const PreparedTriangles& prepared) {
  const auto same = [&](std::uint32_t record, std::size_t place) {
    if (image.header().test != TestKind::Woop) {
      return same_bytes(prepared.planes[place], image.planes()[record]) &&
             same_bytes(prepared.barys[place], image.barys()[record]);
    }
    const ImageCorners corners = image.corners(record);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      for (int axis = 0; axis < 3; ++axis) {
        const double x = prepared.corners[place][corner][axis];
        if (corners.p[corner][static_cast<std::size_t>(axis)] != round_to_bits(image.format(), x))
          return false;
      }
    }
    return true;
  };
  const std::uint32_t count = image.parts().triangle_count;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto found =
        std::lower_bound(prepared.prims.begin(), prepared.prims.end(), image.prim(i));
    if (found == prepared.prims.end() || *found != image.prim(i) ||
        !same(i, static_cast<std::size_t>(found - prepared.prims.begin()))) {
      return i;
    }
  }
  return count;
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
  const TestKind test = test_kind(config.triangle_test);
  if (image.header().test != test) {
    throw Error(fmt::format(
        "{}: the image is for the triangle test {}, the configuration has {}; make it again by "
        "`make image`",
        path.string(), test_name(image.header().test), test_name(test)));
  }
  const PreparedTriangles prepared = prepare_triangles(mesh, {format, image.header().scale}, test);
  const std::uint32_t foreign = first_foreign(image, prepared);
  if (foreign < image.parts().triangle_count ||
      image.parts().triangle_count != prepared.prims.size()) {
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
  stats.range = prepared.range;
  describe_tree(image, stats);
  return image;
}

}  // namespace ti
