// SPDX-License-Identifier: Apache-2.0
// An image that is not exactly what was built is refused with one sentence, and never read out of
// bounds.

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "accel/image_checksum.hpp"
#include "base/error.hpp"
#include "io/file.hpp"
#include "test/support.hpp"
#include "test/tree_walk.hpp"

namespace ti {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes small_image(std::size_t triangles = 12) {
  BuildStats stats;
  const Image image = build_image(soup(triangles, 0.6F, 7), {}, stats);
  return {image.bytes().begin(), image.bytes().end()};
}

/// The message of the error that `bytes` give; empty when they are accepted.
std::string refusal(Bytes bytes) {
  try {
    const Image image(std::move(bytes), "a.tiim");
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

/// Writes `word` at `offset` and makes the checksum right again.
Bytes with_word(Bytes bytes, std::size_t offset, std::uint32_t word) {
  std::memcpy(bytes.data() + offset, &word, sizeof(word));
  const std::uint32_t sum = image_checksum(bytes);
  std::memcpy(bytes.data() + offsetof(ImageHeader, checksum), &sum, sizeof(sum));
  return bytes;
}

/// Where entry `number` of the table of sections stands.
constexpr std::size_t entry(std::size_t number) {
  return sizeof(ImageHeader) + number * sizeof(ImageSection);
}

/// The image with one more section of four bytes at its end, of that kind.
Bytes with_section(Bytes bytes, std::uint32_t kind, std::uint32_t element = 4) {
  const auto word = [&bytes](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof(value));
    return value;
  };
  const auto put = [&bytes](std::size_t at, std::uint32_t value) {
    std::memcpy(bytes.data() + at, &value, sizeof(value));
  };
  const std::uint32_t count = word(offsetof(ImageHeader, section_count));
  bytes.insert(bytes.begin() + kSectionAlign, kSectionAlign, 0);  // room for a longer table
  for (std::uint32_t i = 0; i < count; ++i) put(entry(i) + 4, word(entry(i) + 4) + kSectionAlign);
  const ImageSection more{static_cast<SectionKind>(kind), static_cast<std::uint32_t>(bytes.size()),
                          4, element};
  std::memcpy(bytes.data() + entry(count), &more, sizeof(more));
  bytes.resize(bytes.size() + kSectionAlign);
  put(offsetof(ImageHeader, section_count), count + 1);
  return with_word(bytes, offsetof(ImageHeader, size_bytes),
                   static_cast<std::uint32_t>(bytes.size()));
}

}  // namespace

TEST_CASE("image: every flipped byte is noticed") {
  const Bytes good = small_image();
  REQUIRE(refusal(good).empty());
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (const std::uint8_t flip : {0x01, 0x80, 0xFF}) {
      Bytes bad = good;
      bad[i] ^= flip;
      CAPTURE(i);
      CHECK(refusal(bad).starts_with("a.tiim: "));
    }
  }
}

TEST_CASE("image: every other length is noticed") {
  const Bytes good = small_image();
  for (std::size_t size = 0; size < good.size(); ++size) {
    CHECK(refusal(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)))
              .starts_with("a.tiim: "));
  }
  Bytes longer = good;
  longer.resize(good.size() + 128);
  CHECK_FALSE(refusal(longer).empty());
}

TEST_CASE("image: the sentence names the place and the cure") {
  const Bytes good = small_image();
  const ImageParts parts = Image(good, "a.tiim").parts();
  Bytes bad = good;
  bad[200] ^= 1U;
  CHECK(refusal(bad).find("does not match the bytes (") != std::string::npos);
  CHECK(refusal(bad).ends_with("the image is damaged, build it again"));
  CHECK(refusal(with_word(good, 4, 9)) ==
        "a.tiim: version 9 at byte 4, this tool reads 2: build the image again by `make image`");
  CHECK(refusal(with_word(good, 4, 1)) ==
        "a.tiim: version 1 at byte 4, this tool reads 2: build the image again by `make image`");
  CHECK(refusal(with_word(good, 16, 0x01021708)) ==
        "a.tiim: its tree is of kind 2, this tool reads 1 (kd): build the image again by `make "
        "image`");
  CHECK(refusal(with_word(good, 16, 0x09011708)) ==
        "a.tiim: its triangle test is of kind 9, this tool reads 1 (local), 2 (np) and 3 (woop): "
        "build the image again by `make image`");
  for (const int scale : {161, -161, std::numeric_limits<int>::min()}) {
    CHECK(refusal(with_word(good, 56, static_cast<std::uint32_t>(scale))) ==
          "a.tiim: scale " + std::to_string(scale) +
              " at byte 56 is not from -160 to 160: the image is damaged, build it again");
  }
  CHECK(refusal(with_word(good, 56, static_cast<std::uint32_t>(-160))).empty());
  CHECK(refusal({}).find("has 0 bytes") != std::string::npos);
  CHECK(refusal(with_word(good, offsetof(ImageHeader, root), parts.node_count)).find("root") !=
        std::string::npos);
}

TEST_CASE("image: with a right checksum, every rule about the contents still holds") {
  const Bytes good = small_image();
  const Image image(good, "a.tiim");
  const ImageParts parts = image.parts();
  REQUIRE_FALSE(image.nodes()[0].is_leaf());
  const std::size_t root = parts.node_offset;
  const auto refused = [&](std::size_t offset, std::uint32_t word) {
    return !refusal(with_word(good, offset, word)).empty();
  };
  CHECK(refused(root + 4, 0U << 3U));                // child before its parent
  CHECK(refused(root + 4, parts.node_count << 3U));  // child outside
  CHECK(refused(root, 0x7F800000U));                 // split at infinity
  CHECK(refused(root, 0x7FC00000U));                 // no number
  CHECK(refused(root + 4, 100000U << 3U | 3U));      // leaf over the limit
  const std::size_t last = root + (std::size_t{parts.node_count} - 1) * sizeof(ImageNode);
  CHECK(refused(last, parts.list_count));  // leaf outside the list
  CHECK(refused(last, 0xFFFFFFFFU));
  CHECK(refused(last + 4, (parts.node_count - 1) << 3U));  // inner node at the end
  CHECK(refused(parts.list_offset, parts.triangle_count));
  CHECK(refused(parts.plane_offset + offsetof(ImagePlane, axis), 3));
  CHECK(refused(parts.plane_offset + offsetof(ImagePlane, nu), 0x7F800000U));
  CHECK(refused(parts.bary_offset, 0xFF800000U));
  CHECK(refused(16, 0x01011709U));  // exponent bits 9
  CHECK(refused(48, 2));            // layout 2
  CHECK(refused(48, 2U << 8U));     // rounding 2
  CHECK(refused(48, 2U << 16U));    // subnormals 2
  CHECK(refused(48, 24U << 24U));   // seeds of 24 bits, but 23 of fraction
  CHECK(refused(48, 32U << 24U));   // a Newton step without seeds
  CHECK_FALSE(refused(48, 0x47010101U));
  for (std::size_t section = 0; section < 4; ++section) {
    for (const std::uint32_t word : {0U, 64U, 129U, image.header().size_bytes, 0xFFFFFF80U}) {
      CHECK(refused(entry(section) + offsetof(ImageSection, offset), word));
    }
    for (const std::uint32_t word : {1U, 0xFFFFFFFFU, 0x20000000U}) {
      CHECK(refused(entry(section) + offsetof(ImageSection, bytes), word));
    }
    for (const std::uint32_t word : {0U, 1U, 12U, 0xFFFFFFFFU}) {
      CHECK(refused(entry(section) + offsetof(ImageSection, element), word));
    }
    CHECK(refused(entry(section), 77));  // none of its kind
    CHECK(refused(entry(section), section == 0 ? 2 : 1));
  }
  for (const std::uint32_t count : {0U, 3U, 5U, 0x10000000U, 0xFFFFFFFFU}) {
    CHECK(refused(offsetof(ImageHeader, section_count), count));
  }
}

TEST_CASE("image: a section of an unknown kind is skipped, its place is checked") {
  const Bytes good = small_image();
  const Image image(good, "a.tiim");
  const Bytes longer = with_section(good, 77, 1);
  const Image more(longer, "a.tiim");
  const auto same = [](auto a, auto b) {
    return std::ranges::equal(std::as_bytes(a), std::as_bytes(b));
  };
  CHECK(same(image.nodes(), more.nodes()));
  CHECK(same(image.list(), more.list()));
  CHECK(same(image.planes(), more.planes()));
  CHECK(same(image.barys(), more.barys()));
  for (const std::uint32_t place : {0U, 64U, 128U, 0xFFFFFF80U}) {
    CHECK_FALSE(
        refusal(with_word(longer, entry(4) + offsetof(ImageSection, offset), place)).empty());
  }
  CHECK(refusal(with_section(good, 1, 8)).find("two sections have its nodes") != std::string::npos);
}

TEST_CASE("image: random bytes under a right checksum are refused or can be walked") {
  const Bytes good = small_image(40);
  std::mt19937 random(11);
  std::size_t accepted = 0;
  for (int run = 0; run < 3000; ++run) {
    const std::size_t place = random() % (good.size() / 4) * 4;
    const std::uint32_t word = random() >> (random() % 32U);
    try {
      const Image image(with_word(good, place, word), "a.tiim");
      std::vector<std::uint32_t> reached;
      for (std::uint32_t i = 0; i < image.nodes().size(); ++i) {
        const ImageNode node = image.nodes()[i];
        if (!node.is_leaf()) {
          REQUIRE(node.other() > i);
          REQUIRE(node.other() < image.nodes().size());
          continue;
        }
        for (std::uint32_t entry = 0; entry < node.count(); ++entry) {
          REQUIRE(image.planes()[image.list()[node.value + entry]].axis < 3);
        }
      }
      ++accepted;
    } catch (const Error&) {
    }
  }
  CHECK(accepted > 0);
  CHECK(accepted < 3000);
}

TEST_CASE("image: a written file is loaded as it was, anything else is refused") {
  const test::TempDir folder;
  const Bytes good = small_image();
  write_file(folder / "a.tiim", {reinterpret_cast<const char*>(good.data()), good.size()});
  CHECK(std::ranges::equal(Image::load(folder / "a.tiim").bytes(), good));
  CHECK_THROWS_AS((void)Image::load(folder / "b.tiim"), Error);
  CHECK_THROWS_AS((void)Image::load(folder / "."), Error);
  CHECK_THROWS_AS((void)Image::load(folder.file("empty.tiim", "")), Error);
}

}  // namespace ti
