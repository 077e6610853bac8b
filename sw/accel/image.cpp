// SPDX-License-Identifier: Apache-2.0
#include "accel/image.hpp"

#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "accel/image_checksum.hpp"
#include "base/error.hpp"
#include "io/file.hpp"

namespace ti {
namespace {

static_assert(std::endian::native == std::endian::little,
              "an image is used as it stands in memory");

constexpr std::uint32_t kVersion = ImageHeader{}.version;

std::string hex(std::uint32_t word) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text(8, '0');
  for (std::size_t i = 0; i < 8; ++i) text[i] = kDigits[(word >> (28U - 4U * i)) & 15U];
  return text;
}

template <typename T>
std::span<const T> elements(std::span<const std::uint8_t> bytes, std::uint32_t offset,
                            std::uint32_t count) {
  return {reinterpret_cast<const T*>(bytes.data() + offset), count};
}

/// Checks one image; each failure is an `Error` that starts with the origin.
class ImageChecker {
 public:
  ImageChecker(const Image& image, const std::string& origin) : image_(image), origin_(origin) {}

  /// Everything that must hold before a span of a section may be made, and where they stand.
  [[nodiscard]] ImageParts find_parts() const;
  void check_contents() const;

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(origin_ + ": " + what + ": the image is damaged, build it again");
  }
  void check_header() const;
  void check_kinds() const;
  void check_place(std::size_t number, const ImageSection& section) const;
  void check_nodes() const;
  void check_finite(const char* name, std::size_t index, std::uint32_t bits) const;

  const Image& image_;
  const std::string& origin_;
};

void ImageChecker::check_header() const {
  const std::size_t size = image_.bytes().size();
  if (size < sizeof(ImageHeader)) {
    fail("has " + std::to_string(size) + " bytes, a header has " +
         std::to_string(sizeof(ImageHeader)));
  }
  const ImageHeader& header = image_.header();
  if (header.magic != ImageHeader{}.magic) {
    throw Error(origin_ + ": the first four bytes are not TIIM: give a memory image of this tool");
  }
  if (header.version != kVersion) {
    throw Error(origin_ + ": version " + std::to_string(header.version) +
                " at byte 4, this tool reads " + std::to_string(kVersion) +
                ": build the image again by `make image`");
  }
  if (header.size_bytes != size) {
    fail("has " + std::to_string(size) + " bytes, its header says " +
         std::to_string(header.size_bytes));
  }
  const std::uint32_t sum = image_checksum(image_.bytes());
  if (sum != header.checksum) {
    fail("checksum " + hex(header.checksum) + " does not match the bytes (" + hex(sum) + ")");
  }
  if (header.exp_bits < 3 || header.exp_bits > 8 || header.frac_bits < 2 || header.frac_bits > 23) {
    fail("number format (" + std::to_string(header.exp_bits) + ", " +
         std::to_string(header.frac_bits) + ") at byte 16 is not between (3, 2) and (8, 23)");
  }
  check_kinds();
  const auto check_bit = [this](const char* what, int value, int byte) {
    if (value > 1)
      fail(what + (" " + std::to_string(value)) + " at byte " + std::to_string(byte) +
           " is not 0 or 1");
  };
  check_bit("layout", header.layout, 48);
  check_bit("rounding", header.rounding, 49);
  check_bit("subnormals", header.subnormals, 50);
  const Modes modes = image_.format().modes;
  if (modes.rcp_table_bits > header.frac_bits || modes.rcp_newton_steps > 2 ||
      (modes.rcp_table_bits == 0 && modes.rcp_newton_steps > 0)) {
    fail("reciprocal " + std::to_string(header.reciprocal) + " at byte 51 is none of the format");
  }
  if (header.scale < -kMostScale || header.scale > kMostScale) {
    fail("scale " + std::to_string(header.scale) + " at byte 56 is not from -" +
         std::to_string(kMostScale) + " to " + std::to_string(kMostScale));
  }
}

void ImageChecker::check_kinds() const {
  const auto refuse = [this](const char* what, int kind, const char* known) {
    throw Error(origin_ + ": its " + what + " is of kind " + std::to_string(kind) +
                ", this tool reads " + known + ": build the image again by `make image`");
  };
  const ImageHeader& header = image_.header();
  if (header.tree != TreeKind::Kd) refuse("tree", static_cast<int>(header.tree), "1 (kd)");
  if (header.test < TestKind::Local || header.test > TestKind::Woop)
    refuse("triangle test", static_cast<int>(header.test), "1 (local), 2 (np) and 3 (woop)");
}

void ImageChecker::check_place(std::size_t number, const ImageSection& section) const {
  const std::size_t first =
      sizeof(ImageHeader) + std::size_t{image_.header().section_count} * sizeof(ImageSection);
  const std::uint64_t end = std::uint64_t{section.offset} + section.bytes;
  if (section.offset < first || section.offset % kSectionAlign != 0 ||
      end > image_.bytes().size()) {
    fail("section " + std::to_string(number) + " at byte " + std::to_string(section.offset) +
         " with " + std::to_string(section.bytes) + " bytes does not fit in " +
         std::to_string(image_.bytes().size()) + " bytes");
  }
}

ImageParts ImageChecker::find_parts() const {
  check_header();
  const std::size_t room = (image_.bytes().size() - sizeof(ImageHeader)) / sizeof(ImageSection);
  const std::uint32_t count = image_.header().section_count;
  if (count > room) {
    fail("a table of " + std::to_string(count) + " sections at byte 52 does not fit in " +
         std::to_string(image_.bytes().size()) + " bytes");
  }
  ImageParts parts;
  std::uint32_t bary_count = 0;
  struct Known {
    SectionKind kind;
    const char* name;
    std::size_t element;
    std::uint32_t& offset;
    std::uint32_t& count;
    bool found = false;
  };
  const bool woop = image_.header().test == TestKind::Woop;
  std::vector known{
      Known{SectionKind::Nodes, "nodes", sizeof(ImageNode), parts.node_offset, parts.node_count},
      Known{SectionKind::List, "list", sizeof(std::uint32_t), parts.list_offset, parts.list_count}};
  if (woop) {
    known.push_back({SectionKind::Corners, "corners", corner_bytes(image_.format()),
                     parts.corner_offset, parts.triangle_count});
  } else {
    known.push_back({SectionKind::Planes, "plane parts", sizeof(ImagePlane), parts.plane_offset,
                     parts.triangle_count});
    known.push_back({SectionKind::Barys, "barycentric parts", sizeof(ImageBary), parts.bary_offset,
                     bary_count});
  }
  const auto table = elements<ImageSection>(image_.bytes(), sizeof(ImageHeader), count);
  for (std::size_t i = 0; i < table.size(); ++i) {
    const ImageSection& section = table[i];
    check_place(i, section);
    for (Known& part : known) {
      if (part.kind != section.kind) continue;
      if (part.found) fail(std::string("two sections have its ") + part.name);
      if (section.element != part.element || section.bytes % part.element != 0) {
        fail("section " + std::to_string(i) + " (" + part.name + ") has " +
             std::to_string(section.bytes) + " bytes in elements of " +
             std::to_string(section.element) + ", not of " + std::to_string(part.element));
      }
      part.found = true;
      part.offset = section.offset;
      part.count = section.bytes / section.element;
    }
  }
  for (const Known& part : known) {
    if (!part.found) fail(std::string("no section has its ") + part.name);
  }
  if (!woop && bary_count != parts.triangle_count) {
    fail("has " + std::to_string(parts.triangle_count) + " plane parts and " +
         std::to_string(bary_count) + " barycentric parts");
  }
  if (image_.header().root >= parts.node_count) {
    fail("root " + std::to_string(image_.header().root) + " is not one of " +
         std::to_string(parts.node_count) + " nodes");
  }
  return parts;
}

void ImageChecker::check_finite(const char* name, std::size_t index, std::uint32_t bits) const {
  const Format format = image_.format();
  const std::uint32_t exponent = (bits >> static_cast<unsigned>(format.frac_bits)) &
                                 ((1U << static_cast<unsigned>(format.exp_bits)) - 1U);
  const bool fits = std::uint64_t{bits} >> static_cast<unsigned>(format.width()) == 0;
  if (!fits || exponent == (1U << static_cast<unsigned>(format.exp_bits)) - 1U) {
    fail(std::string(name) + " " + std::to_string(index) + " has the word " + hex(bits) +
         ", not a finite number of the format");
  }
}

void ImageChecker::check_nodes() const {
  const auto nodes = image_.nodes();
  const std::size_t list_count = image_.list().size();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ImageNode& node = nodes[i];
    if (node.is_leaf()) {
      if (node.count() > kMaxLeafCount || std::uint64_t{node.value} + node.count() > list_count) {
        fail("leaf " + std::to_string(i) + " has entries " + std::to_string(node.value) + " + " +
             std::to_string(node.count()) + " of a list of " + std::to_string(list_count));
      }
    } else {
      check_finite("split of node", i, node.value);
      if (i + 1 >= nodes.size() || node.other() <= i || node.other() >= nodes.size()) {
        fail("node " + std::to_string(i) + " has child " + std::to_string(node.other()) + " of " +
             std::to_string(nodes.size()) + " nodes");
      }
    }
  }
}

void ImageChecker::check_contents() const {
  const ImageHeader& header = image_.header();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    check_finite("lower bound of the scene box, axis", axis, header.box_lo[axis]);
    check_finite("upper bound of the scene box, axis", axis, header.box_hi[axis]);
    if (!(value_of_bits(image_.format(), header.box_lo[axis]) <=
          value_of_bits(image_.format(), header.box_hi[axis]))) {
      fail("scene box is upside down on axis " + std::to_string(axis));
    }
  }
  check_nodes();
  const auto list = image_.list();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i] >= image_.parts().triangle_count) {
      fail("list entry " + std::to_string(i) + " names triangle " + std::to_string(list[i]) +
           " of " + std::to_string(image_.parts().triangle_count));
    }
  }
  if (header.test == TestKind::Woop) {
    for (std::uint32_t i = 0; i < image_.parts().triangle_count; ++i) {
      for (const auto& corner : image_.corners(i).p) {
        for (const std::uint32_t bits : corner) check_finite("triangle", i, bits);
      }
    }
    return;
  }
  const auto planes = image_.planes();
  const auto barys = image_.barys();
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const ImagePlane& plane = planes[i];
    if (plane.axis > 2) {
      fail("triangle " + std::to_string(i) + " has axis " + std::to_string(plane.axis));
    }
    for (const std::uint32_t bits : {plane.nu, plane.nv, plane.pu, plane.pv, plane.pw, barys[i].e0u,
                                     barys[i].e0v, barys[i].e1u, barys[i].e1v}) {
      check_finite("triangle", i, bits);
    }
  }
}

}  // namespace

std::uint32_t image_checksum(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kPlace = offsetof(ImageHeader, checksum);
  constexpr std::size_t kAfter = kPlace + sizeof(std::uint32_t);
  const std::array<std::uint8_t, sizeof(std::uint32_t)> zero{};
  uLong sum = crc32_z(0, bytes.data(), kPlace);
  sum = crc32_z(sum, zero.data(), zero.size());
  sum = crc32_z(sum, bytes.data() + kAfter, bytes.size() - kAfter);
  return static_cast<std::uint32_t>(sum);
}

Image::Image(std::vector<std::uint8_t> bytes, const std::string& origin, ImageCheck check)
    : bytes_(std::move(bytes)), parts_(ImageChecker(*this, origin).find_parts()) {
  if (check == ImageCheck::All) ImageChecker(*this, origin).check_contents();
}

Image Image::load(const std::filesystem::path& path) {
  const std::string origin = path.string();
  std::error_code unknown;  // then `read_file` says why
  const std::uintmax_t size = std::filesystem::file_size(path, unknown);
  if (!unknown && size > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(origin + ": has " + std::to_string(size) +
                " bytes, an image has less than 4 GiB: give the path of a memory image");
  }
  const std::string bytes = read_file(path);
  return Image({bytes.begin(), bytes.end()}, origin);
}

const ImageHeader& Image::header() const {
  return *reinterpret_cast<const ImageHeader*>(bytes_.data());
}

Format Image::format() const {
  return {header().exp_bits,
          header().frac_bits,
          {.toward_zero = header().rounding == 1,
           .flush = header().subnormals == 1,
           .rcp_table_bits = header().reciprocal % 32,
           .rcp_newton_steps = header().reciprocal / 32}};
}

std::span<const ImageNode> Image::nodes() const {
  return elements<ImageNode>(bytes_, parts_.node_offset, parts_.node_count);
}

std::span<const ImageNode> Image::reach_of_nodes() const {
  const std::size_t bytes = bytes_.size() - parts_.node_offset;
  return elements<ImageNode>(bytes_, parts_.node_offset,
                             static_cast<std::uint32_t>(bytes / sizeof(ImageNode)));
}

std::span<const std::uint32_t> Image::list() const {
  return elements<std::uint32_t>(bytes_, parts_.list_offset, parts_.list_count);
}

std::span<const ImagePlane> Image::planes() const {
  const bool none = header().test == TestKind::Woop;
  return elements<ImagePlane>(bytes_, parts_.plane_offset, none ? 0 : parts_.triangle_count);
}

std::span<const ImageBary> Image::barys() const {
  const bool none = header().test == TestKind::Woop;
  return elements<ImageBary>(bytes_, parts_.bary_offset, none ? 0 : parts_.triangle_count);
}

ImageCorners Image::corners(std::uint32_t index) const {
  const auto width = static_cast<std::size_t>(format().width());
  const std::uint8_t* record =
      bytes_.data() + parts_.corner_offset + std::size_t{index} * corner_bytes(format());
  const auto field = [record](std::size_t place, std::size_t bits) {
    std::uint64_t word = 0;
    std::memcpy(&word, record + place / 8, (place % 8 + bits + 7) / 8);
    return static_cast<std::uint32_t>(word >> place % 8 & ((std::uint64_t{1} << bits) - 1));
  };
  ImageCorners corners{};
  for (std::size_t i = 0; i < 9; ++i) corners.p[i / 3][i % 3] = field(i * width, width);
  corners.prim = field(9 * width, 32);
  return corners;
}

std::uint32_t Image::prim(std::uint32_t index) const {
  return header().test == TestKind::Woop ? corners(index).prim : planes()[index].prim;
}

std::vector<std::uint8_t> pack(const ImageCorners& corners, Format format) {
  const auto width = static_cast<std::size_t>(format.width());
  std::vector<std::uint8_t> bytes(corner_bytes(format));
  const auto put = [&bytes](std::size_t place, std::uint32_t value) {
    const std::uint64_t word = std::uint64_t{value} << place % 8;
    for (std::size_t k = 0; k < 5 && place / 8 + k < bytes.size(); ++k)
      bytes[place / 8 + k] |= static_cast<std::uint8_t>(word >> 8 * k);
  };
  for (std::size_t i = 0; i < 9; ++i) put(i * width, corners.p[i / 3][i % 3]);
  put(9 * width, corners.prim);
  return bytes;
}

}  // namespace ti
