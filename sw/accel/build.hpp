// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "accel/image.hpp"
#include "accel/range_audit.hpp"
#include "base/config_keys.hpp"
#include "base/vec.hpp"
#include "scene/mesh.hpp"

namespace ti {

/// Costs and limits of the surface area heuristic.
struct BuildOptions {
  Format format;
  Layout layout = Layout::kOdfl;
  TestKind test = TestKind::Local;
  int scale = 0;  ///< places stand in the image times 2^scale (`scene_scale`)
  double step_cost = 1.0;
  double test_cost = 1.5;
  double leaf_cost = 1.0;  ///< of a visit to a leaf, where a subtree is compared with one
  int bad_splits = 1;      ///< splits on the way to a cell that may cost more than testing all
  double empty_bonus =
      0.2;  ///< share by which the tests after a split that cuts off empty space cost less
  double depth_base = 16.0;  ///< depth limit = depth_base + depth_factor * log2(n)
  double depth_factor = 1.3;
  double min_cell = 5e-6;  ///< thinnest cell, in diagonals of the scene (scaled by 2^(23 - M) for
                           ///< smaller formats)
  double dilation =
      2e-6;  ///< a triangle is in every cell this near to it, in diagonals (scaled likewise)
};

/// What the build did and what the tree looks like.
struct BuildStats {
  std::uint32_t triangles = 0;  ///< in the mesh
  std::uint32_t dropped_nonfinite =
      0;  ///< a vertex is NaN or infinite, or a constant does not fit the format
  std::uint32_t dropped_zero_area = 0;
  RangeAudit range;  ///< what the format does not hold
  std::uint32_t nodes = 0, leaves = 0, empty_leaves = 0;
  std::uint32_t references = 0;  ///< list entries
  std::uint32_t largest_leaf = 0;
  int depth = 0;
  double sah_cost = 0.0;  ///< expected cost of a ray through the scene box: nodes visited, leaves
                          ///< included, and tests
  double seconds = 0.0;
  std::uint32_t new_cells = 0;       ///< of an update: cells that were built anew,
  std::uint32_t new_references = 0;  ///< and the references in them; of a build: all
};

/// Builds the tree and the image of `mesh`. A mesh without a usable triangle gives an image whose
/// root is an empty leaf (callers that need a triangle say so themselves). Throws `Error` when the
/// scene cannot be expressed in the format.
[[nodiscard]] Image build_image(const Mesh& mesh, const BuildOptions& options, BuildStats& stats);

/// The same for each of `tests` in place of that of the options, each with its stats. The tree is
/// built once for those that keep the same triangles.
struct BuiltImage {
  Image image;
  BuildStats stats;
};
[[nodiscard]] std::vector<BuiltImage> build_images(const Mesh& mesh, BuildOptions options,
                                                   std::span<const TestKind> tests);

/// The tree of a mesh whose vertices move from frame to frame (`update_kd_tree`).
class MovingTree {
 public:
  /// `reach` holds the usable vertices of all frames, in scene units.
  MovingTree(const BuildOptions& options, const Box& reach);
  ~MovingTree();
  MovingTree(const MovingTree&) = delete;
  MovingTree& operator=(const MovingTree&) = delete;

  /// The image of the mesh as it is now: only cells where a triangle moved since the last call are
  /// built anew, all of them with `anew`, the first time, and when other triangles are dropped.
  [[nodiscard]] Image next(const Mesh& mesh, bool anew, BuildStats& stats);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// One sentence for a warning when triangles were dropped; empty when none were.
[[nodiscard]] std::string dropped_warning(const BuildStats& stats);

}  // namespace ti
