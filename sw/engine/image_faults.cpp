// SPDX-License-Identifier: Apache-2.0
#include "engine/image_faults.hpp"

#include <algorithm>
#include <cstring>
#include <random>
#include <span>

#include "accel/image_checksum.hpp"

namespace ti {
namespace {

/// Draws and writes. The generators of <random> are the same everywhere, its distributions are not.
class Damage {
 public:
  Damage(const Image& image, std::uint64_t seed)
      : image_(image), bytes_(image.bytes().begin(), image.bytes().end()), random_(seed) {}

  [[nodiscard]] std::vector<std::uint8_t> take() { return std::move(bytes_); }

  /// A number below `count`, which is not 0.
  [[nodiscard]] std::uint64_t below(std::uint64_t count) { return random_() % count; }
  [[nodiscard]] std::uint32_t word() { return static_cast<std::uint32_t>(random_() >> 32U); }

  /// One below `count`, sooner a small one: what stands first is what most rays read.
  [[nodiscard]] std::uint64_t early(std::uint64_t count) { return below(1 + below(count)); }

  void flip(std::size_t first, std::size_t count) {
    bytes_[first + early(count)] ^= static_cast<std::uint8_t>(1U << below(8));
  }
  void put(std::size_t at, std::uint32_t value) { std::memcpy(&bytes_[at], &value, sizeof value); }
  void put_any_word(std::size_t first, std::size_t count) {
    put(first + sizeof(std::uint32_t) * early(count / sizeof(std::uint32_t)), word());
  }
  void put_any_bytes(std::size_t first, std::size_t count) {
    const std::size_t end = std::min(first + count, bytes_.size());
    for (std::size_t i = first; i < end; ++i) bytes_[i] = static_cast<std::uint8_t>(random_());
  }

  /// Replaces the link of a node, whose lowest bits stay.
  void link(std::size_t node, std::uint32_t number) {
    put(place(node) + sizeof(std::uint32_t), number << 3U | (image_.nodes()[node].link & 7U));
  }
  [[nodiscard]] std::size_t place(std::size_t node) const {
    return image_.parts().node_offset + node * sizeof(ImageNode);
  }
  /// An inner node, or any where there is none.
  [[nodiscard]] std::size_t inner() {
    const auto nodes = image_.nodes();
    const std::size_t first = early(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const std::size_t node = (first + i) % nodes.size();
      if (!nodes[node].is_leaf()) return node;
    }
    return first;
  }

  void put_checksum() {
    const std::uint32_t sum = image_checksum(bytes_);
    put(offsetof(ImageHeader, checksum), sum);
  }

 private:
  const Image& image_;
  std::vector<std::uint8_t> bytes_;
  std::mt19937_64 random_;
};

/// Where the bytes of a section's elements stand.
struct Bytes {
  std::size_t first, count;
};

Bytes triangles(const Image& image, std::uint64_t draw) {
  const ImageParts& parts = image.parts();
  if (image.header().test == TestKind::Woop)
    return {parts.corner_offset, std::size_t{parts.triangle_count} * corner_bytes(image.format())};
  if (draw % 2 == 0) return {parts.plane_offset, parts.triangle_count * sizeof(ImagePlane)};
  return {parts.bary_offset, parts.triangle_count * sizeof(ImageBary)};
}

/// A far number of each size: just behind `count`, or any.
std::uint32_t far(Damage& damage, std::uint64_t count) {
  if (damage.below(2) == 0) return static_cast<std::uint32_t>(count + damage.below(3));
  return damage.word() >> damage.below(32);
}

}  // namespace

std::vector<std::uint8_t> damaged(const Image& image, ImageFault fault, std::uint64_t seed) {
  Damage damage(image, seed);
  const ImageParts& parts = image.parts();
  const Bytes nodes{parts.node_offset, parts.node_count * sizeof(ImageNode)};
  const Bytes list{parts.list_offset, parts.list_count * sizeof(std::uint32_t)};
  const Bytes records = triangles(image, damage.below(2));
  const std::size_t head =
      sizeof(ImageHeader) + image.header().section_count * sizeof(ImageSection);
  switch (fault) {
    case ImageFault::NodeBit:
      damage.flip(nodes.first, nodes.count);
      break;
    case ImageFault::NodeWord:
      damage.put_any_word(nodes.first, nodes.count);
      break;
    case ImageFault::Loop: {
      const std::size_t node = damage.inner();
      damage.link(node, static_cast<std::uint32_t>(damage.below(node + 1)));
      break;
    }
    case ImageFault::Beyond: {
      const std::size_t node = damage.early(parts.node_count);
      if (!image.nodes()[node].is_leaf() || damage.below(2) == 0) {
        damage.link(node, far(damage, parts.node_count));
      } else {
        damage.put(damage.place(node), far(damage, parts.list_count));
      }
      break;
    }
    case ImageFault::ListBit:
      damage.flip(list.first, list.count);
      break;
    case ImageFault::ListWord:
      damage.put_any_word(list.first, list.count);
      break;
    case ImageFault::TriangleBit:
      damage.flip(records.first, records.count);
      break;
    case ImageFault::TriangleWord:
      damage.put_any_word(records.first, records.count);
      break;
    case ImageFault::Line: {
      constexpr std::size_t kLine = 64;
      const std::size_t lines = (image.bytes().size() - head) / kLine;
      damage.put_any_bytes((head + kLine - 1) / kLine * kLine + kLine * damage.early(lines), kLine);
      break;
    }
    case ImageFault::Header:
      damage.flip(0, head);
      break;
  }
  damage.put_checksum();
  return damage.take();
}

std::set<std::uint32_t> unsound_leaves(const Image& image) {
  constexpr std::uint64_t kMostTriangles = 65535;
  const auto nodes = image.nodes();
  const auto list = image.list();
  std::set<std::uint32_t> unsound;
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].link % 4 != 3) continue;
    const std::uint64_t count = nodes[i].link / 8;
    const std::uint64_t end = nodes[i].value + count;
    bool bad = count > kMostTriangles || (count != 0 && end > list.size());
    for (std::uint64_t k = nodes[i].value; !bad && k < end; ++k)
      bad = list[k] >= image.parts().triangle_count;
    if (bad) unsound.insert(i);
  }
  return unsound;
}

}  // namespace ti
