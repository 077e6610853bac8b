// SPDX-License-Identifier: Apache-2.0
// Which frames are asked for, and the animated picture that is made of them.

#include <doctest/doctest.h>
#include <zlib.h>

#include <array>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "cli/frames.hpp"
#include "io/apng.hpp"
#include "io/png.hpp"
#include "test/support.hpp"

namespace ti {
namespace {

TEST_CASE("frames: A:B as in Python, either left out, or one number") {
  const auto check_range = [](const char* text, int first, int end) {
    const FrameRange range = parse_frames(text, 16);
    CAPTURE(text);
    CHECK(range.first == first);
    CHECK(range.end == end);
  };
  check_range("0:16", 0, 16);
  check_range(":", 0, 16);
  check_range("3:", 3, 16);
  check_range(":5", 0, 5);
  check_range("7", 7, 8);
  for (const char* text :
       {"16", "5:5", "9:3", "0:17", "-1:3", "a:b", "1:2:3", "1.5", "99999999999"}) {
    CAPTURE(text);
    test::check_error([text] { (void)parse_frames(text, 16); }, {std::string("FRAMES=") + text});
  }
  test::check_error([] { (void)parse_frames("1", 1); }, {"one frame, 0"});
}

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word = word << 8U | static_cast<unsigned char>(bytes[at + i]);
  return word;
}

struct Chunk {
  std::string type, content;
};

/// The chunks of a PNG, each with a right sum.
std::vector<Chunk> chunks(const std::string& bytes) {
  std::vector<Chunk> out;
  REQUIRE(bytes.substr(1, 3) == "PNG");
  for (std::size_t at = 8; at < bytes.size();) {
    const std::size_t size = word_at(bytes, at);
    REQUIRE(at + 12 + size <= bytes.size());
    out.push_back({bytes.substr(at + 4, 4), bytes.substr(at + 8, size)});
    const auto sum = crc32(0, reinterpret_cast<const Bytef*>(bytes.data() + at + 4),
                           static_cast<uInt>(4 + size));
    CHECK(word_at(bytes, at + 8 + size) == sum);
    at += 12 + size;
  }
  return out;
}

TEST_CASE("animated PNG: the pictures' data in their order, each with its time") {
  std::vector<std::string> pngs;
  for (unsigned char grey = 10; grey < 40; grey += 10)
    pngs.push_back(png_of(std::vector<unsigned char>(2 * 3 * 3, grey), 2, 3));
  const auto all = chunks(apng_of(pngs, 0.125));
  std::string types;
  for (const Chunk& chunk : all) types += chunk.type + " ";
  CHECK(types == "IHDR acTL fcTL IDAT fcTL fdAT fcTL fdAT IEND ");
  CHECK(word_at(all[1].content, 0) == 3);  // frames
  CHECK(word_at(all[1].content, 4) == 0);  // for ever
  std::uint32_t number = 0;
  std::size_t picture = 0;
  for (const Chunk& chunk : all) {
    if (chunk.type == "fcTL") {
      CHECK(word_at(chunk.content, 0) == number++);
      CHECK(word_at(chunk.content, 4) == 2);
      CHECK(word_at(chunk.content, 8) == 3);
      CHECK(word_at(chunk.content, 20) == (125U << 16U | 1000U));
    }
    if (chunk.type == "fdAT") CHECK(word_at(chunk.content, 0) == number++);
    if (chunk.type == "IDAT" || chunk.type == "fdAT")
      CHECK(chunk.content.substr(chunk.type == "fdAT" ? 4 : 0) ==
            chunks(pngs[picture++])[1].content);
  }
  CHECK(picture == 3);
}

TEST_CASE("animated PNG: pictures of two sizes, none, or no picture are refused") {
  const std::vector<std::string> two{png_of(std::vector<unsigned char>(12, 1), 2, 2),
                                     png_of(std::vector<unsigned char>(6, 1), 2, 1)};
  CHECK_THROWS_AS((void)apng_of(two, 1.0), std::invalid_argument);
  CHECK_THROWS_AS((void)apng_of({}, 1.0), std::invalid_argument);
  const std::vector<std::string> none{"GIF89a"};
  CHECK_THROWS_AS((void)apng_of(none, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace ti
