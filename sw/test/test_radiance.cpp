// SPDX-License-Identifier: Apache-2.0
// Radiance is written as it is, bit for bit, as an array and as OpenEXR.
#include <tinyexr.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "io/exr.hpp"
#include "io/npy.hpp"
#include "scene/random.hpp"
#include "test/support.hpp"

namespace {

using namespace ti;
using namespace ti::test;

/// What a reader finds in an OpenEXR picture.
struct Read {
  int width = 0;
  int height = 0;
  std::string names;
  std::vector<int> types;
  std::vector<glm::vec3> pixels;
};

Read read_exr(const std::string& bytes) {
  const auto* memory = reinterpret_cast<const unsigned char*>(bytes.data());
  Read out;
  EXRVersion version;
  REQUIRE(ParseEXRVersionFromMemory(&version, memory, bytes.size()) == TINYEXR_SUCCESS);
  CHECK(version.tiled == 0);
  CHECK(version.multipart == 0);
  EXRHeader header;
  InitEXRHeader(&header);
  const char* message = nullptr;
  REQUIRE(ParseEXRHeaderFromMemory(&header, &version, memory, bytes.size(), &message) ==
          TINYEXR_SUCCESS);
  EXRImage image;
  InitEXRImage(&image);
  REQUIRE(LoadEXRImageFromMemory(&image, &header, memory, bytes.size(), &message) ==
          TINYEXR_SUCCESS);
  REQUIRE(header.num_channels == 3);
  out.width = image.width;
  out.height = image.height;
  out.pixels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  for (int c = 0; c < 3; ++c) {
    out.names += header.channels[c].name;
    out.types.push_back(header.pixel_types[c]);
    for (std::size_t i = 0; i < out.pixels.size(); ++i)
      std::memcpy(&out.pixels[i][2 - c], image.images[c] + i * sizeof(float), sizeof(float));
  }
  FreeEXRImage(&image);
  FreeEXRHeader(&header);
  return out;
}

std::uint32_t bits(float x) { return std::bit_cast<std::uint32_t>(x); }

/// Pixels of any bits: what no compression makes smaller.
std::vector<glm::vec3> noise(std::size_t count) {
  Random random(1, count);
  std::vector<glm::vec3> out(count);
  for (glm::vec3& c : out)
    for (int axis = 0; axis < 3; ++axis)
      c[axis] = std::bit_cast<float>(static_cast<std::uint32_t>(random.uniform() * 0x1p32));
  return out;
}

TEST_CASE("an OpenEXR picture is read back bit for bit, whatever its size and numbers") {
  struct Size {
    int width, height;
  };
  for (const auto& [width, height] :
       {Size{1, 1}, Size{3, 2}, Size{5, 16}, Size{37, 33}, Size{1, 50}, Size{64, 1}}) {
    CAPTURE(width);
    CAPTURE(height);
    const auto count = static_cast<std::size_t>(width * height);
    std::vector<glm::vec3> ramp(count);
    for (std::size_t i = 0; i < count; ++i)
      ramp[i] = {static_cast<float>(i) * 0.01F, 1.0F, static_cast<float>(i % 5)};
    for (const auto& pixels : {ramp, noise(count), std::vector<glm::vec3>(count)}) {
      const Read read = read_exr(exr_of(pixels, width, height));
      CHECK(read.width == width);
      CHECK(read.height == height);
      CHECK(read.names == "BGR");
      CHECK(read.types == std::vector<int>(3, TINYEXR_PIXELTYPE_FLOAT));
      REQUIRE(read.pixels.size() == count);
      for (std::size_t i = 0; i < count; ++i)
        for (int axis = 0; axis < 3; ++axis)
          REQUIRE(bits(read.pixels[i][axis]) == bits(pixels[i][axis]));
    }
  }
}

TEST_CASE(
    "an OpenEXR picture has the format's mark, is compressed and keeps the ends of the range") {
  using Limits = std::numeric_limits<float>;
  const std::vector<glm::vec3> pixels{{-0.0F, Limits::denorm_min(), Limits::max()},
                                      {Limits::infinity(), Limits::quiet_NaN(), 65504.0F}};
  const std::string bytes = exr_of(pixels, 2, 1);
  CHECK(bytes.substr(0, 8) == std::string("\x76\x2f\x31\x01\x02\x00\x00\x00", 8));
  CHECK(exr_of(std::vector<glm::vec3>(4096), 64, 64).size() < 4096);
  const Read read = read_exr(bytes);
  for (std::size_t i = 0; i < 2; ++i)
    for (int axis = 0; axis < 3; ++axis) CHECK(bits(read.pixels[i][axis]) == bits(pixels[i][axis]));
}

TEST_CASE("the array of a picture has its rows from the top, three numbers a pixel") {
  const std::string npy = radiance_npy(
      std::vector<glm::vec3>{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {0, 0, 0}, {0, 0, 0}, {0, 0, 10}}, 3,
      2);
  CHECK(npy.find("'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 3)") !=
        std::string::npos);
  REQUIRE(npy.size() == 128 + 18 * sizeof(float));
  float value = 0.0F;
  for (const auto& [place, expected] : {std::pair{0, 1.0F}, {5, 6.0F}, {17, 10.0F}}) {
    std::memcpy(&value, npy.data() + 128 + static_cast<std::size_t>(place) * sizeof(float),
                sizeof(float));
    CHECK(value == expected);
  }
}

TEST_CASE("radiance that does not fill its picture is refused") {
  const std::vector<glm::vec3> six(6);
  for (const auto& write : {exr_of, radiance_npy}) {
    check_error([&] { (void)write(six, 2, 2); }, {"2x2", "18"});
    check_error([&] { (void)write({}, 0, 2); }, {"0x2"});
    check_error([&] { (void)write({}, 1, 100000); }, {"100000"});
    check_error([&] { (void)write({}, 16384, 8192); }, {"2^26"});
  }
}

}  // namespace
