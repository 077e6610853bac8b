// SPDX-License-Identifier: Apache-2.0
#include "io/exr.hpp"

#include <fmt/format.h>
#include <tinyexr.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "io/picture_size.hpp"

namespace ti {

std::string exr_of(std::span<const glm::vec3> linear, int width, int height) {
  check_picture(3 * linear.size(), width, height);
  // Channels stand in the order of their names.
  constexpr std::array<char, 3> kNames{'B', 'G', 'R'};
  std::array<std::vector<float>, 3> planes;
  std::array<unsigned char*, 3> images{};
  std::array<EXRChannelInfo, 3> channels{};
  for (std::size_t c = 0; c < 3; ++c) {
    planes[c].reserve(linear.size());
    for (const glm::vec3& colour : linear)
      planes[c].push_back(colour[2 - static_cast<glm::vec3::length_type>(c)]);
    images[c] = reinterpret_cast<unsigned char*>(planes[c].data());
    channels[c].name[0] = kNames[c];
  }
  std::array<int, 3> types{TINYEXR_PIXELTYPE_FLOAT, TINYEXR_PIXELTYPE_FLOAT,
                           TINYEXR_PIXELTYPE_FLOAT};

  EXRHeader header;
  InitEXRHeader(&header);
  header.num_channels = 3;
  header.channels = channels.data();
  header.pixel_types = types.data();
  header.requested_pixel_types = types.data();
  header.compression_type = TINYEXR_COMPRESSIONTYPE_ZIP;
  EXRImage image;
  InitEXRImage(&image);
  image.num_channels = 3;
  image.images = images.data();
  image.width = width;
  image.height = height;

  unsigned char* memory = nullptr;
  const char* message = nullptr;
  const std::size_t size = SaveEXRImageToMemory(&image, &header, &memory, &message);
  const std::unique_ptr<unsigned char, decltype(&std::free)> owner(memory, &std::free);
  if (size == 0) {
    const std::string why = message != nullptr ? message : "tinyexr does not say why";
    if (message != nullptr) FreeEXRErrorMessage(message);
    throw Error(
        fmt::format("the picture of {}x{} cannot be encoded as OpenEXR ({}); choose a smaller one",
                    width, height, why));
  }
  return {reinterpret_cast<const char*>(memory), size};
}

}  // namespace ti
