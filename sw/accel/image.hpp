// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/config_keys.hpp"
#include "base/format.hpp"

namespace ti {

/// What kind of tree stands in an image.
enum class TreeKind : std::uint8_t { Kd = 1 };

/// Which test its triangle records are for.
enum class TestKind : std::uint8_t { Local = 1, Np = 2, Woop = 3 };

/// The kind that a configuration names, and its name.
[[nodiscard]] constexpr TestKind test_kind(TriangleTest test) {
  return static_cast<TestKind>(static_cast<int>(test) + 1);
}
[[nodiscard]] constexpr const char* test_name(TestKind test) {
  return kTriangleTestNames[static_cast<std::size_t>(test) - 1];
}

/// First 64 bytes of a memory image, little endian; `docs/memory-image.md` has the byte table. The
/// table of sections follows, `section_count` of `ImageSection`.
struct ImageHeader {
  std::array<char, 4> magic{'T', 'I', 'I', 'M'};
  std::uint32_t version = 2;
  std::uint32_t checksum = 0;  ///< CRC-32 (zlib) of the whole image with this word 0
  std::uint32_t size_bytes = 0;
  std::uint8_t exp_bits = 8;
  std::uint8_t frac_bits = 23;
  TreeKind tree = TreeKind::Kd;
  TestKind test = TestKind::Local;
  std::uint32_t root = 0;                 ///< node number of the root
  std::array<std::uint32_t, 3> box_lo{};  ///< scene box, padded outward, bits of the format
  std::array<std::uint32_t, 3> box_hi{};
  std::uint8_t layout = 0;      ///< 0 ODFL, 1 DFL
  std::uint8_t rounding = 0;    ///< of operations: 0 to nearest even, 1 toward zero
  std::uint8_t subnormals = 0;  ///< 0 kept, 1 flushed
  std::uint8_t reciprocal = 0;  ///< 0 division, else bits of the index of a seed + 32 * steps
  std::uint32_t section_count = 0;
  std::int32_t scale = 0;  ///< places stand in the image times 2^scale
  std::uint32_t reserved1 = 0;
};
static_assert(sizeof(ImageHeader) == 64);

/// Largest |scale|: no place of a mesh in binary32 asks for more, in any format.
constexpr int kMostScale = 160;

/// What stands in a section. A reader skips kinds that it does not know.
enum class SectionKind : std::uint32_t { Nodes = 1, List = 2, Planes = 3, Barys = 4, Corners = 5 };

/// An entry of the table of sections. Sections start at multiples of 128 bytes, counted from the
/// first byte of the image.
struct ImageSection {
  SectionKind kind{};
  std::uint32_t offset = 0;
  std::uint32_t bytes = 0;
  std::uint32_t element = 0;  ///< bytes of one element
};
static_assert(sizeof(ImageSection) == 16);

constexpr std::size_t kSectionAlign = 128;
[[nodiscard]] constexpr std::size_t section_end(std::size_t bytes) {
  return (bytes + kSectionAlign - 1) / kSectionAlign * kSectionAlign;
}

/// Where the sections of a kd-tree stand, and their elements. Records of Shevtsov's test have a
/// plane part and a barycentric part each, those of Woop's the three corners.
struct ImageParts {
  std::uint32_t node_offset = 0, node_count = 0;
  std::uint32_t list_offset = 0, list_count = 0;
  std::uint32_t plane_offset = 0, bary_offset = 0, corner_offset = 0;
  std::uint32_t triangle_count = 0;  ///< records

  /// Where records are first read.
  [[nodiscard]] std::uint32_t record_offset() const { return plane_offset + corner_offset; }
};

/// kd-tree node, 8 bytes. Inner: `value` = split (bits of the format), `link` = other child << 3 |
/// reorder flag << 2 | axis. Leaf: `value` = first entry in the list, `link` = count << 3 | 3. The
/// adjacent child is the node after its parent.
struct ImageNode {
  std::uint32_t value;
  std::uint32_t link;

  [[nodiscard]] bool is_leaf() const { return (link & 3U) == 3U; }
  [[nodiscard]] std::uint32_t axis() const { return link & 3U; }
  [[nodiscard]] bool reorder() const { return ((link >> 2U) & 1U) != 0U; }
  [[nodiscard]] std::uint32_t other() const { return link >> 3U; }
  [[nodiscard]] std::uint32_t count() const { return link >> 3U; }
};
static_assert(sizeof(ImageNode) == 8);

/// Largest triangle count of one leaf.
constexpr std::uint32_t kMaxLeafCount = (1U << 16U) - 1U;

/// Plane part of a triangle record, 32 bytes; what pass (a) of the test reads. All values are bits
/// of the format.
struct ImagePlane {
  std::uint32_t nu, nv;  ///< n_u / n_w, n_v / n_w
  std::uint32_t pu, pv;  ///< first vertex, axes in the order u, v, w
  std::uint32_t pw;      ///< the same; of the test `np` n.p / n_w
  std::uint32_t axis;    ///< w = 0, 1, 2: the axis of the largest |n|, the lowest at a tie
  std::uint32_t prim;    ///< triangle number in the mesh file
  std::uint32_t reserved;
};
static_assert(sizeof(ImagePlane) == 32);

/// Barycentric part, 16 bytes; what pass (b) reads: edge vectors from the first vertex, divided by
/// n_w.
struct ImageBary {
  std::uint32_t e0u, e0v;  ///< to the second vertex
  std::uint32_t e1u, e1v;  ///< to the third vertex
};
static_assert(sizeof(ImageBary) == 16);

/// Record of Woop's test: nine coordinates in the bits of the format, corner by corner, then the
/// triangle number in 32 bits, packed from the lowest bit of the first byte on.
struct ImageCorners {
  std::array<std::array<std::uint32_t, 3>, 3> p;
  std::uint32_t prim;
};

/// Bytes of a packed record: 32 where it fits, else 64.
[[nodiscard]] constexpr std::uint32_t corner_bytes(Format format) {
  return 9 * format.width() + 32 <= 256 ? 32 : 64;
}
/// The record packed into `corner_bytes(format)` bytes.
[[nodiscard]] std::vector<std::uint8_t> pack(const ImageCorners& corners, Format format);

/// What of an image is checked: everything, or what says where its sections are and nothing in
/// them.
enum class ImageCheck : std::uint8_t { All, Places };

/// A memory image: the same bytes for the model, the RTL and a host.
class Image {
 public:
  /// Takes the bytes and checks them: magic, version, sizes, kinds, sections, checksum, every
  /// index. Throws `Error` with a sentence that starts with `origin`.
  Image(std::vector<std::uint8_t> bytes, const std::string& origin,
        ImageCheck check = ImageCheck::All);

  [[nodiscard]] static Image load(const std::filesystem::path& path);

  [[nodiscard]] const ImageHeader& header() const;
  [[nodiscard]] const ImageParts& parts() const { return parts_; }
  [[nodiscard]] Format format() const;
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return bytes_; }
  [[nodiscard]] std::span<const ImageNode> nodes() const;
  /// What a node number reaches: the nodes and all that stands behind them.
  [[nodiscard]] std::span<const ImageNode> reach_of_nodes() const;
  [[nodiscard]] std::span<const std::uint32_t> list() const;
  [[nodiscard]] std::span<const ImagePlane> planes() const;
  [[nodiscard]] std::span<const ImageBary> barys() const;
  /// Record `index` of an image for Woop's test.
  [[nodiscard]] ImageCorners corners(std::uint32_t index) const;
  /// Number in the mesh of the triangle of record `index`.
  [[nodiscard]] std::uint32_t prim(std::uint32_t index) const;

 private:
  std::vector<std::uint8_t> bytes_;  // aligned to 8 by the allocator
  ImageParts parts_;
};

}  // namespace ti
