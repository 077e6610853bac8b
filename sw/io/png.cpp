// SPDX-License-Identifier: Apache-2.0
#include "io/png.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

#include "base/error.hpp"
#include "io/picture_size.hpp"

namespace ti {

namespace {

/// IEC 61966-2-1 encoding of a linear value to 0..255; NaN becomes 0.
unsigned char srgb(float linear) {
  const float x = linear > 0.0F ? std::min(linear, 1.0F) : 0.0F;
  const float y = x <= 0.0031308F ? 12.92F * x : 1.055F * std::pow(x, 1.0F / 2.4F) - 0.055F;
  return static_cast<unsigned char>(std::lround(y * 255.0F));
}

void append(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data),
                                             static_cast<std::size_t>(size));
}

}  // namespace

std::string png_of(std::span<const unsigned char> rgb, int width, int height) {
  check_picture(rgb.size(), width, height);
  std::string bytes;
  if (stbi_write_png_to_func(append, &bytes, width, height, 3, rgb.data(), width * 3) == 0) {
    throw Error(
        fmt::format("the picture of {}x{} cannot be encoded; choose a smaller one", width, height));
  }
  return bytes;
}

std::string png_of(std::span<const glm::vec3> linear, int width, int height) {
  std::vector<unsigned char> rgb;
  rgb.reserve(linear.size() * 3);
  for (const glm::vec3& c : linear) {
    rgb.insert(rgb.end(), {srgb(c.x), srgb(c.y), srgb(c.z)});
  }
  return png_of(rgb, width, height);
}

}  // namespace ti
