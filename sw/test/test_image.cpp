// SPDX-License-Identifier: Apache-2.0
// An image that is not exactly what was built is refused with one sentence, and never read out of
// bounds.

#include <doctest/doctest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "accel/image_checksum.hpp"
#include "base/error.hpp"
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

ImageHeader header_of(const Bytes& bytes) {
  ImageHeader header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  return header;
}

/// A folder of its own, removed at the end.
struct Folder {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("ti_test_image_" + std::to_string(::getpid()));
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
};

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
  const ImageHeader header = header_of(good);
  Bytes bad = good;
  bad[200] ^= 1U;
  CHECK(refusal(bad).find("does not match the bytes (") != std::string::npos);
  CHECK(refusal(bad).ends_with("the image is damaged, build it again"));
  CHECK(refusal(with_word(good, 4, 9)) ==
        "a.tiim: version 9 at byte 4, this tool reads 1: build the image again");
  CHECK(refusal({}).find("has 0 bytes") != std::string::npos);
  CHECK(refusal(with_word(good, offsetof(ImageHeader, root), header.node_count)).find("root") !=
        std::string::npos);
}

TEST_CASE("image: with a right checksum, every rule about the contents still holds") {
  const Bytes good = small_image();
  const ImageHeader header = header_of(good);
  const Image image(good, "a.tiim");
  REQUIRE_FALSE(image.nodes()[0].is_leaf());
  const std::size_t root = header.node_offset;
  const auto refused = [&](std::size_t offset, std::uint32_t word) {
    return !refusal(with_word(good, offset, word)).empty();
  };
  CHECK(refused(root + 4, 0U << 3U));                 // child before its parent
  CHECK(refused(root + 4, header.node_count << 3U));  // child outside
  CHECK(refused(root, 0x7F800000U));                  // split at infinity
  CHECK(refused(root, 0x7FC00000U));                  // no number
  CHECK(refused(root + 4, 100000U << 3U | 3U));       // leaf over the limit
  const std::size_t last = root + (std::size_t{header.node_count} - 1) * sizeof(ImageNode);
  CHECK(refused(last, header.list_count));  // leaf outside the list
  CHECK(refused(last, 0xFFFFFFFFU));
  CHECK(refused(last + 4, (header.node_count - 1) << 3U));  // inner node at the end
  CHECK(refused(header.list_offset, header.triangle_count));
  CHECK(refused(header.plane_offset + offsetof(ImagePlane, axis), 3));
  CHECK(refused(header.plane_offset + offsetof(ImagePlane, nu), 0x7F800000U));
  CHECK(refused(header.bary_offset, 0xFF800000U));
  CHECK(refused(16, 0x00001708U + 1));  // exponent bits 9
  CHECK(refused(16, 0x00021708U));      // layout 2
  for (const std::size_t place :
       {offsetof(ImageHeader, node_offset), offsetof(ImageHeader, list_offset),
        offsetof(ImageHeader, plane_offset), offsetof(ImageHeader, bary_offset)}) {
    for (const std::uint32_t word : {0U, 64U, 129U, header.size_bytes, 0xFFFFFF80U}) {
      CHECK(refused(place, word));
    }
  }
  for (const std::size_t place :
       {offsetof(ImageHeader, node_count), offsetof(ImageHeader, list_count),
        offsetof(ImageHeader, triangle_count)}) {
    CHECK(refused(place, 0xFFFFFFFFU));
    CHECK(refused(place, 0x20000000U));
  }
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

TEST_CASE("image: a saved file is loaded as it was, and nothing else is left behind") {
  const Folder folder;
  const Bytes good = small_image();
  const Image image(good, "built");
  const auto path = folder.path / "a.tiim";
  image.save(path);
  image.save(path);
  CHECK(std::ranges::equal(Image::load(path).bytes(), good));
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path), {}) == 1);
  CHECK_THROWS_AS(image.save(folder.path / "none" / "a.tiim"), Error);
  CHECK_THROWS_AS(image.save(folder.path), Error);
  CHECK_THROWS_AS((void)Image::load(folder.path / "b.tiim"), Error);
  CHECK_THROWS_AS((void)Image::load(folder.path), Error);
  std::ofstream(folder.path / "empty.tiim");
  CHECK_THROWS_AS((void)Image::load(folder.path / "empty.tiim"), Error);
}

}  // namespace ti
