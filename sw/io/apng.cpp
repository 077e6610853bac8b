// SPDX-License-Identifier: Apache-2.0
#include "io/apng.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string_view>

namespace ti {

namespace {

constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);

std::uint32_t word_of(std::string_view bytes) {
  std::uint32_t word = 0;
  for (const char c : bytes.substr(0, 4)) word = word << 8U | static_cast<unsigned char>(c);
  return word;
}

std::string big_endian(std::uint64_t value, int bytes) {
  std::string out;
  for (int i = bytes - 1; i >= 0; --i) out.push_back(static_cast<char>(value >> (8 * i) & 0xFFU));
  return out;
}

std::string chunk(std::string_view type, std::string_view content) {
  const std::string body = std::string(type) + std::string(content);
  const uLong crc =
      crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
  return big_endian(static_cast<std::uint32_t>(content.size()), 4) + body +
         big_endian(static_cast<std::uint32_t>(crc), 4);
}

struct Png {
  std::string_view header;  ///< content of IHDR
  std::string data;         ///< of all IDATs
};

Png read_png(std::string_view bytes) {
  Png png;
  if (!bytes.starts_with(kSignature)) throw std::invalid_argument("this is no PNG");
  for (std::size_t at = kSignature.size(); at + 12 <= bytes.size();) {
    const std::size_t size = word_of(bytes.substr(at));
    const std::string_view type = bytes.substr(at + 4, 4);
    const std::string_view content = bytes.substr(at + 8, size);
    if (type == "IHDR") png.header = content;
    if (type == "IDAT") png.data += content;
    at += 12 + size;
  }
  if (png.header.size() != 13 || png.data.empty()) throw std::invalid_argument("the PNG is cut");
  return png;
}

}  // namespace

std::string apng_of(std::span<const std::string> pngs, double seconds) {
  if (pngs.empty()) throw std::invalid_argument("an animation needs a picture");
  constexpr double kMost = 65535.0;
  const auto milliseconds =
      static_cast<std::uint32_t>(std::clamp(std::round(1000.0 * seconds), 1.0, kMost));
  const Png first = read_png(pngs[0]);
  std::string out(kSignature);
  out += chunk("IHDR", first.header);
  out += chunk("acTL", big_endian(static_cast<std::uint32_t>(pngs.size()), 4) + big_endian(0, 4));
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < pngs.size(); ++i) {
    const Png png = read_png(pngs[i]);
    if (png.header != first.header) throw std::invalid_argument("the pictures differ in size");
    // Size, no offset, delay over 1000, neither disposal nor blending.
    out += chunk("fcTL", big_endian(number++, 4) + std::string(png.header.substr(0, 8)) +
                             big_endian(0, 8) + big_endian(milliseconds, 2) + big_endian(1000, 2) +
                             big_endian(0, 2));
    out += i == 0 ? chunk("IDAT", png.data) : chunk("fdAT", big_endian(number, 4) + png.data);
    if (i != 0) ++number;
  }
  return out + chunk("IEND", {});
}

}  // namespace ti
