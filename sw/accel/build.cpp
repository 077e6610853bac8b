// SPDX-License-Identifier: Apache-2.0
#include "accel/build.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "accel/image_checksum.hpp"
#include "accel/kd_update.hpp"
#include "accel/kdtree.hpp"
#include "accel/prepare.hpp"
#include "base/error.hpp"

namespace ti {
namespace {

/// The scene box stands off the triangles by this share of the diagonal, and by this many units in
/// the last place of the largest coordinate. Cells and dilation keep the latter distances too: see
/// `docs/tree.md`. Where operations are off by more than half a unit all are longer.
constexpr double kBoxPadding = 2e-6;
constexpr double kBoxPaddingUlps = 4.0;
constexpr double kMinCellUlps = 4.0;
constexpr double kDilationUlps =
    0x1p-20;  // far above the rounding of `clipped_bounds`, for every format

/// The rules of the tree of one scene, whose triangles may come to be anywhere in `reach`; throws
/// `Error` when the padded box leaves the range of the format.
KdRules make_rules(const std::vector<Corners>& triangles, const BuildOptions& options,
                   const std::optional<Box>& reach) {
  KdRules rules{FormatGrid(options.format),
                {{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}},
                options.step_cost,
                options.test_cost,
                options.leaf_cost,
                options.empty_bonus,
                options.bad_splits,
                0,
                0.0,
                0.0};
  if (triangles.empty()) return rules;

  const Point first = point_of(triangles[0][0]);
  Box box = reach.value_or(Box{first, first});
  for (const Corners& corners : triangles) {
    for (const glm::vec3& place : corners) {
      const Point corner = point_of(place);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lo[axis] = std::min(box.lo[axis], corner[axis]);
        box.hi[axis] = std::max(box.hi[axis], corner[axis]);
      }
    }
  }
  double largest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    largest = std::max({largest, std::abs(box.lo[axis]), std::abs(box.hi[axis])});
  const double diagonal =
      std::sqrt(std::pow(box.hi[0] - box.lo[0], 2) + std::pow(box.hi[1] - box.lo[1], 2) +
                std::pow(box.hi[2] - box.lo[2], 2));
  const double ulp = rules.grid.spacing(largest);
  // All distances are those of (8, 23) in its default modes, in units of what the t of a plane may
  // be off: a difference, an inverse and a product.
  const double plane_error =
      (2.0 * options.format.rounding_unit() + options.format.reciprocal_unit()) / 3.0;
  const double coarser = plane_error / Format{}.rounding_unit();
  const double error = plane_error * std::exp2(options.format.frac_bits + 1);
  // What the difference of a plane and an origin may lose where subnormals are flushed.
  const double lost = options.format.modes.flush ? 2.0 * options.format.least_normal() : 0.0;
  rules.min_cell =
      std::max(options.min_cell * coarser * diagonal, kMinCellUlps * error * ulp) + lost;
  rules.dilation = std::max(options.dilation * coarser * diagonal, kDilationUlps * ulp) + lost;
  const double padding = std::max(
      {kBoxPadding * coarser * diagonal, kBoxPaddingUlps * error * ulp, 2.0 * rules.dilation});
  rules.box = box.grown(padding);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    rules.box.lo[axis] = rules.grid.at_most(rules.box.lo[axis]);
    rules.box.hi[axis] = rules.grid.at_least(rules.box.hi[axis]);
    if (!std::isfinite(rules.box.lo[axis]) || !std::isfinite(rules.box.hi[axis])) {
      throw Error("mesh: the padded scene box is beyond the largest number of the format " +
                  name_of(options.format) +
                  ": scale the mesh down or choose a format with more exponent bits");
    }
  }
  rules.depth_limit = static_cast<int>(
      std::lround(options.depth_base +
                  options.depth_factor * std::log2(static_cast<double>(triangles.size()))));
  return rules;
}

/// Writes the nodes, the list and the records in the order of the image.
class Emitter {
 public:
  Emitter(const KdTree& tree, const KdRules& rules, const BuildOptions& options,
          const PreparedTriangles& prepared, BuildStats& stats)
      : tree_(tree), rules_(rules), options_(options), prepared_(prepared), stats_(stats) {
    record_of_.assign(prepared.prims.size(), kUnplaced);
    nodes.reserve(tree.nodes.size());
    list.reserve(tree.references.size());
    place(0, rules.box, 0);
    stats_.sah_cost /= rules.box.half_area();
  }

  std::vector<ImageNode> nodes;
  std::vector<std::uint32_t> list;
  std::vector<ImagePlane> planes;
  std::vector<ImageBary> barys;
  std::vector<std::uint8_t> corners;  ///< packed records of Woop's test

 private:
  static constexpr std::uint32_t kUnplaced = 0xFFFFFFFFU;

  void place(std::uint32_t index, const Box& box, int depth);
  void place_leaf(const KdNode& leaf);
  void place_record(std::uint32_t triangle);

  const KdTree& tree_;
  const KdRules& rules_;
  const BuildOptions& options_;
  const PreparedTriangles& prepared_;
  BuildStats& stats_;
  std::vector<std::uint32_t> record_of_;
  std::uint32_t records_ = 0;
};

void Emitter::place_record(std::uint32_t triangle) {
  record_of_[triangle] = records_++;
  if (options_.test != TestKind::Woop) {
    planes.push_back(prepared_.planes[triangle]);
    barys.push_back(prepared_.barys[triangle]);
    return;
  }
  ImageCorners record{};
  record.prim = prepared_.prims[triangle];
  for (std::size_t corner = 0; corner < 3; ++corner) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float x = prepared_.corners[triangle][corner][static_cast<glm::length_t>(axis)];
      record.p[corner][axis] = round_to_bits(options_.format, double{x});
    }
  }
  const std::vector<std::uint8_t> bytes = pack(record, options_.format);
  corners.insert(corners.end(), bytes.begin(), bytes.end());
}

void Emitter::place_leaf(const KdNode& leaf) {
  ++stats_.leaves;
  if (leaf.second == 0) ++stats_.empty_leaves;
  stats_.largest_leaf = std::max(stats_.largest_leaf, leaf.second);
  nodes.push_back({static_cast<std::uint32_t>(list.size()), leaf.second << 3U | 3U});
  for (std::uint32_t i = 0; i < leaf.second; ++i) {
    const std::uint32_t triangle = tree_.references[leaf.first + i];
    if (record_of_[triangle] == kUnplaced) place_record(triangle);
    list.push_back(record_of_[triangle]);
  }
}

void Emitter::place(std::uint32_t index, const Box& box, int depth) {
  const KdNode& node = tree_.nodes[index];
  stats_.depth = std::max(stats_.depth, depth);
  stats_.sah_cost += box.half_area() * rules_.step_cost;
  if (node.is_leaf()) {
    stats_.sah_cost += box.half_area() * rules_.test_cost * node.second;
    place_leaf(node);
    return;
  }
  Box below = box;
  Box above = box;
  below.hi[node.axis] = above.lo[node.axis] = static_cast<double>(node.split);
  const bool reorder = options_.layout == Layout::kOdfl && above.half_area() > below.half_area();
  const std::size_t here = nodes.size();
  nodes.push_back({round_to_bits(options_.format, static_cast<double>(node.split)), node.axis});
  if (reorder) {
    place(node.second, above, depth + 1);
  } else {
    place(node.first, below, depth + 1);
  }
  nodes[here].link |= static_cast<std::uint32_t>(nodes.size()) << 3U | (reorder ? 4U : 0U);
  if (reorder) {
    place(node.first, below, depth + 1);
  } else {
    place(node.second, above, depth + 1);
  }
}

/// A section to be written.
struct Section {
  template <typename T>
  Section(SectionKind what, const std::vector<T>& elements, std::size_t element_bytes = sizeof(T))
      : kind(what),
        data(elements.data()),
        bytes(elements.size() * sizeof(T)),
        element(element_bytes) {}

  SectionKind kind;
  const void* data;
  std::size_t bytes;
  std::size_t element;
};

Image assemble(const Emitter& parts, const KdRules& rules, const BuildOptions& options) {
  std::vector sections{Section(SectionKind::Nodes, parts.nodes),
                       Section(SectionKind::List, parts.list)};
  if (options.test == TestKind::Woop) {
    sections.emplace_back(SectionKind::Corners, parts.corners, corner_bytes(options.format));
  } else {
    sections.emplace_back(SectionKind::Planes, parts.planes);
    sections.emplace_back(SectionKind::Barys, parts.barys);
  }
  const std::size_t first =
      section_end(sizeof(ImageHeader) + sections.size() * sizeof(ImageSection));
  std::size_t size = first;
  for (const Section& section : sections) size += section_end(section.bytes);
  if (size > std::numeric_limits<std::uint32_t>::max() || parts.nodes.size() >> 29U != 0) {
    throw Error(
        "mesh: the memory image would have " + std::to_string(size) + " bytes and " +
        std::to_string(parts.nodes.size()) +
        " nodes, the limits are 4 GiB and 2^29: simplify the mesh or lower the depth limit");
  }

  ImageHeader header;
  header.size_bytes = static_cast<std::uint32_t>(size);
  header.exp_bits = static_cast<std::uint8_t>(options.format.exp_bits);
  header.frac_bits = static_cast<std::uint8_t>(options.format.frac_bits);
  header.test = options.test;
  header.layout = options.layout == Layout::kOdfl ? 0 : 1;
  header.rounding = options.format.modes.toward_zero ? 1 : 0;
  header.subnormals = options.format.modes.flush ? 1 : 0;
  header.reciprocal = static_cast<std::uint8_t>(options.format.modes.rcp_table_bits +
                                                32 * options.format.modes.rcp_newton_steps);
  header.scale = options.scale;
  header.section_count = static_cast<std::uint32_t>(sections.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.box_lo[axis] = round_to_bits(options.format, rules.box.lo[axis]);
    header.box_hi[axis] = round_to_bits(options.format, rules.box.hi[axis]);
  }

  std::vector<std::uint8_t> bytes(size);
  const auto put = [&bytes](std::size_t offset, const void* data, std::size_t count) {
    if (count > 0) std::memcpy(bytes.data() + offset, data, count);
  };
  put(0, &header, sizeof(header));
  std::size_t entry = sizeof(ImageHeader);
  std::size_t offset = first;
  for (const Section& section : sections) {
    const ImageSection line{section.kind, static_cast<std::uint32_t>(offset),
                            static_cast<std::uint32_t>(section.bytes),
                            static_cast<std::uint32_t>(section.element)};
    put(entry, &line, sizeof(line));
    put(offset, section.data, section.bytes);
    entry += sizeof(line);
    offset += section_end(section.bytes);
  }
  header.checksum = image_checksum(bytes);
  put(0, &header, sizeof(header));
  return Image(std::move(bytes), "built image");
}

/// The image of a tree, and what is to be said of it.
Image image_of(const Mesh& mesh, const KdTree& tree, const KdRules& rules,
               const BuildOptions& options, const PreparedTriangles& prepared, BuildStats& stats) {
  const Emitter parts(tree, rules, options, prepared, stats);
  stats.triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  stats.dropped_nonfinite = prepared.dropped_nonfinite;
  stats.dropped_zero_area = prepared.dropped_zero_area;
  stats.range = prepared.range;
  stats.nodes = static_cast<std::uint32_t>(parts.nodes.size());
  stats.references = static_cast<std::uint32_t>(parts.list.size());
  return assemble(parts, rules, options);
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

Image build_image(const Mesh& mesh, const BuildOptions& options, BuildStats& stats) {
  BuiltImage built = std::move(build_images(mesh, options, {&options.test, 1}).front());
  stats = built.stats;
  return std::move(built.image);
}

std::vector<BuiltImage> build_images(const Mesh& mesh, BuildOptions options,
                                     std::span<const TestKind> tests) {
  std::vector<BuiltImage> images;
  std::vector<std::uint32_t> prims;  // of the tree
  std::optional<KdRules> rules;
  KdTree tree;
  for (const TestKind test : tests) {
    const auto begin = std::chrono::steady_clock::now();
    options.test = test;
    const PreparedTriangles prepared =
        prepare_triangles(mesh, {options.format, options.scale}, test);
    if (!rules || prims != prepared.prims) {
      rules = make_rules(prepared.corners, options, std::nullopt);
      tree = build_kd_tree(prepared.corners, *rules);
      prims = prepared.prims;
    }
    BuildStats stats;
    Image image = image_of(mesh, tree, *rules, options, prepared, stats);
    stats.new_cells = 1;
    stats.new_references = stats.references;
    stats.seconds = seconds_since(begin);
    images.push_back({std::move(image), stats});
  }
  return images;
}

struct MovingTree::State {
  BuildOptions options;
  Box reach;
  PreparedTriangles prepared{};
  std::optional<KdRules> rules{};
  KdTree tree{};
};

MovingTree::MovingTree(const BuildOptions& options, const Box& reach)
    : state_(std::make_unique<State>(State{.options = options, .reach = reach})) {
  for (Point* corner : {&state_->reach.lo, &state_->reach.hi}) {
    for (double& x : *corner) x = std::ldexp(x, options.scale);
  }
}

MovingTree::~MovingTree() = default;

Image MovingTree::next(const Mesh& mesh, bool anew, BuildStats& stats) {
  const auto begin = std::chrono::steady_clock::now();
  stats = {};
  const BuildOptions& options = state_->options;
  PreparedTriangles prepared =
      prepare_triangles(mesh, {options.format, options.scale}, options.test);
  const PreparedTriangles& last = state_->prepared;
  const bool same = state_->rules && last.prims == prepared.prims;
  if (anew || !same) {
    state_->rules = make_rules(prepared.corners, options, state_->reach);
    state_->tree = build_kd_tree(prepared.corners, *state_->rules);
    stats.new_cells = 1;
    stats.new_references = static_cast<std::uint32_t>(state_->tree.references.size());
  } else {
    std::vector<std::uint8_t> moved(prepared.corners.size());
    for (std::size_t i = 0; i < moved.size(); ++i)
      moved[i] = prepared.corners[i] == last.corners[i] ? 0 : 1;
    KdUpdate update;
    state_->tree = update_kd_tree(state_->tree, prepared.corners, moved, *state_->rules, update);
    stats.new_cells = update.cells;
    stats.new_references = update.references;
  }
  state_->prepared = std::move(prepared);
  Image image = image_of(mesh, state_->tree, *state_->rules, options, state_->prepared, stats);
  stats.seconds = seconds_since(begin);
  return image;
}

std::string dropped_warning(const BuildStats& stats) {
  const std::uint32_t overflow = stats.range.dropped_overflow;
  const std::uint32_t rounded = stats.range.dropped_rounded;
  std::string text;
  const auto add = [&text](std::uint32_t count, const char* why) {
    if (count == 0) return;
    text += (text.empty() ? "dropped " : " and ") + std::to_string(count) + why;
  };
  add(stats.dropped_nonfinite - overflow, " with a vertex that is not finite");
  add(overflow, " with a vertex or constant beyond the format");
  add(stats.dropped_zero_area - rounded, " of zero area");
  add(rounded, " of zero area in the format");
  if (text.empty()) return {};
  return text + " out of " + std::to_string(stats.triangles) + " triangles";
}

}  // namespace ti
