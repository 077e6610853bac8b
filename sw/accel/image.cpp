// SPDX-License-Identifier: Apache-2.0
#include "accel/image.hpp"

#include <unistd.h>
#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>
#include <utility>

#include "accel/image_checksum.hpp"
#include "base/error.hpp"

namespace ti {
namespace {

static_assert(std::endian::native == std::endian::little,
              "an image is used as it stands in memory");

constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kSectionAlign = 128;

std::string hex(std::uint32_t word) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text(8, '0');
  for (std::size_t i = 0; i < 8; ++i) text[i] = kDigits[(word >> (28U - 4U * i)) & 15U];
  return text;
}

/// Checks one image; each failure is an `Error` that starts with the origin.
class Checker {
 public:
  Checker(const Image& image, const std::string& origin) : image_(image), origin_(origin) {}

  /// Everything that must hold before a span of a section may be made.
  void check_frame() const;
  void check_contents() const;

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(origin_ + ": " + what + ": the image is damaged, build it again");
  }
  void check_section(const char* name, std::uint32_t offset, std::uint32_t count,
                     std::uint32_t record) const;
  void check_nodes() const;
  void check_finite(const char* name, std::size_t index, std::uint32_t bits) const;

  const Image& image_;
  const std::string& origin_;
};

void Checker::check_section(const char* name, std::uint32_t offset, std::uint32_t count,
                            std::uint32_t record) const {
  const std::uint64_t end = std::uint64_t{offset} + std::uint64_t{count} * record;
  if (offset < sizeof(ImageHeader) || offset % kSectionAlign != 0 || end > image_.bytes().size()) {
    fail("section of " + std::string(name) + " at byte " + std::to_string(offset) + " with " +
         std::to_string(count) + " records does not fit in " +
         std::to_string(image_.bytes().size()) + " bytes");
  }
}

void Checker::check_frame() const {
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
                ": build the image again");
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
  if (header.layout > 1)
    fail("layout " + std::to_string(header.layout) + " at byte 18 is not 0 or 1");
  check_section("nodes", header.node_offset, header.node_count, sizeof(ImageNode));
  check_section("the list", header.list_offset, header.list_count, sizeof(std::uint32_t));
  check_section("plane parts", header.plane_offset, header.triangle_count, sizeof(ImagePlane));
  check_section("barycentric parts", header.bary_offset, header.triangle_count, sizeof(ImageBary));
  if (header.root >= header.node_count) {
    fail("root " + std::to_string(header.root) + " is not one of " +
         std::to_string(header.node_count) + " nodes");
  }
}

void Checker::check_finite(const char* name, std::size_t index, std::uint32_t bits) const {
  const Format format = image_.format();
  const std::uint32_t exponent = (bits >> static_cast<unsigned>(format.frac_bits)) &
                                 ((1U << static_cast<unsigned>(format.exp_bits)) - 1U);
  const bool fits = std::uint64_t{bits} >> static_cast<unsigned>(format.width()) == 0;
  if (!fits || exponent == (1U << static_cast<unsigned>(format.exp_bits)) - 1U) {
    fail(std::string(name) + " " + std::to_string(index) + " has the word " + hex(bits) +
         ", not a finite number of the format");
  }
}

void Checker::check_nodes() const {
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

void Checker::check_contents() const {
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
    if (list[i] >= header.triangle_count) {
      fail("list entry " + std::to_string(i) + " names triangle " + std::to_string(list[i]) +
           " of " + std::to_string(header.triangle_count));
    }
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

template <typename T>
std::span<const T> section(const std::vector<std::uint8_t>& bytes, std::uint32_t offset,
                           std::uint32_t count) {
  return {reinterpret_cast<const T*>(bytes.data() + offset), count};
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

Image::Image(std::vector<std::uint8_t> bytes, const std::string& origin)
    : bytes_(std::move(bytes)) {
  const Checker checker(*this, origin);
  checker.check_frame();
  checker.check_contents();
}

Image Image::load(const std::filesystem::path& path) {
  const std::string origin = path.string();
  std::error_code code;
  const std::uintmax_t size = std::filesystem::file_size(path, code);
  if (code) {
    throw Error(origin + ": cannot be read (" + code.message() +
                "): give the path of a memory image");
  }
  if (size > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(origin + ": has " + std::to_string(size) +
                " bytes, an image has less than 4 GiB: give the path of a memory image");
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file) throw Error(origin + ": cannot be read to its end: check the file and the disk");
  return Image(std::move(bytes), origin);
}

void Image::save(const std::filesystem::path& path) const {
  std::filesystem::path scratch = path;
  scratch += ".part" + std::to_string(::getpid());
  std::error_code code;
  {
    std::ofstream file(scratch, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes_.data()),
               static_cast<std::streamsize>(bytes_.size()));
    file.close();
    if (!file) {
      std::filesystem::remove(scratch, code);
      throw Error(path.string() + ": cannot be written: check that the folder exists and has room");
    }
  }
  std::filesystem::rename(scratch, path, code);
  if (code) {
    const std::string reason = code.message();
    std::filesystem::remove(scratch, code);
    throw Error(path.string() + ": cannot be written (" + reason + "): give another path");
  }
}

const ImageHeader& Image::header() const {
  return *reinterpret_cast<const ImageHeader*>(bytes_.data());
}

Format Image::format() const { return {header().exp_bits, header().frac_bits}; }

std::span<const ImageNode> Image::nodes() const {
  return section<ImageNode>(bytes_, header().node_offset, header().node_count);
}

std::span<const std::uint32_t> Image::list() const {
  return section<std::uint32_t>(bytes_, header().list_offset, header().list_count);
}

std::span<const ImagePlane> Image::planes() const {
  return section<ImagePlane>(bytes_, header().plane_offset, header().triangle_count);
}

std::span<const ImageBary> Image::barys() const {
  return section<ImageBary>(bytes_, header().bary_offset, header().triangle_count);
}

}  // namespace ti
