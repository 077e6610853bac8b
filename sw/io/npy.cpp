// SPDX-License-Identifier: Apache-2.0
//
// NumPy's .npy, format 1.0 written, 1.0 and 2.0 read (numpy.lib.format). Little-endian, C order
// only; the arrays of this program have three fixed shapes, so this is a reader of those and not a
// library.
#include "io/npy.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "io/file.hpp"
#include "io/picture_size.hpp"

namespace ti {

static_assert(std::endian::native == std::endian::little,
              "arrays are copied as they lie in memory");

namespace {

constexpr std::string_view kMagic{"\x93NUMPY", 6};
constexpr std::size_t kRayFloats = 8;

struct Header {
  std::string descr;
  bool fortran = false;
  std::vector<std::size_t> shape;
};

/// Reads the one Python dict literal that a header is. Every function gives nothing when the text
/// has another form.
class HeaderParser {
 public:
  explicit HeaderParser(std::string_view text) : text_(text) {}

  std::optional<Header> parse() {
    Header header;
    bool descr = false;
    bool fortran = false;
    bool shape = false;
    if (!take('{')) return {};
    while (!take('}')) {
      const auto key = quoted();
      if (!key || !take(':')) return {};
      if (*key == "descr" && !descr) {
        const auto value = quoted();
        if (!value) return {};
        header.descr = *value;
        descr = true;
      } else if (*key == "fortran_order" && !fortran) {
        if (word("True")) {
          header.fortran = true;
        } else if (!word("False")) {
          return {};
        }
        fortran = true;
      } else if (*key == "shape" && !shape) {
        if (!tuple(header.shape)) return {};
        shape = true;
      } else {
        return {};
      }
      if (!take(',')) {
        if (!take('}')) return {};
        break;
      }
    }
    skip_space();
    if (!text_.empty() || !descr || !fortran || !shape) return {};
    return header;
  }

 private:
  void skip_space() {
    const auto n = text_.find_first_not_of(" \t\n");
    text_.remove_prefix(n == std::string_view::npos ? text_.size() : n);
  }
  bool word(std::string_view w) {
    skip_space();
    if (!text_.starts_with(w)) return false;
    text_.remove_prefix(w.size());
    return true;
  }
  bool take(char c) { return word(std::string_view(&c, 1)); }
  std::optional<std::string> quoted() {
    skip_space();
    if (text_.empty() || (text_[0] != '\'' && text_[0] != '"')) return {};
    const auto end = text_.find(text_[0], 1);
    if (end == std::string_view::npos) return {};
    std::string value(text_.substr(1, end - 1));
    text_.remove_prefix(end + 1);
    return value;
  }
  bool tuple(std::vector<std::size_t>& values) {
    if (!take('(')) return false;
    while (!take(')')) {
      skip_space();
      std::size_t value = 0;
      const auto [end, ec] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
      if (ec != std::errc()) return false;
      values.push_back(value);
      text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
      if (!take(',')) return take(')');
    }
    return true;
  }

  std::string_view text_;
};

std::string npy(std::string_view descr, std::string_view shape, std::string_view data) {
  std::string dict =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", descr, shape);
  const std::size_t prefix = kMagic.size() + 4;
  dict.append(63 - (prefix + dict.size()) % 64, ' ');
  dict.push_back('\n');
  std::string bytes(kMagic);
  bytes +=
      {'\x01', '\x00', static_cast<char>(dict.size() & 0xFF), static_cast<char>(dict.size() >> 8)};
  bytes += dict;
  bytes += data;
  return bytes;
}

template <typename T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

}  // namespace

std::vector<Ray> load_rays(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code unknown;  // then `read_file` says why
  const std::uintmax_t size_of_file = std::filesystem::file_size(path, unknown);
  if (!unknown) check_ray_count(name, size_of_file / (kRayFloats * sizeof(float)));
  const std::string file = read_file(path);
  const std::string_view bytes = file;
  if (!bytes.starts_with(kMagic) || bytes.size() < 12) {
    throw Error(name + ": this is not a .npy file; write it with numpy.save");
  }
  const int major = static_cast<unsigned char>(bytes[6]);
  if (major != 1 && major != 2) {
    throw Error(
        fmt::format("{}: .npy format {}.{} is not read; write it with numpy.save, which "
                    "uses 1.0 or 2.0",
                    name, major, static_cast<int>(static_cast<unsigned char>(bytes[7]))));
  }
  std::size_t size = 0;
  for (int i = major == 1 ? 1 : 3; i >= 0; --i) {
    size = size << 8 | static_cast<unsigned char>(bytes[8 + static_cast<std::size_t>(i)]);
  }
  const std::size_t start = major == 1 ? 10 : 12;
  if (size > bytes.size() - start) {
    throw Error(name + ": the file is cut in its header; write it again with numpy.save");
  }
  const auto header = HeaderParser(bytes.substr(start, size)).parse();
  if (!header) {
    throw Error(name + ": the header is malformed; write the file again with numpy.save");
  }
  if (header->descr != "<f4") {
    throw Error(
        fmt::format("{}: the type is '{}' where '<f4' (little-endian float32) is needed; "
                    "save rays.astype('<f4')",
                    name, header->descr));
  }
  if (header->shape.size() != 2 || header->shape[1] != kRayFloats) {
    throw Error(
        fmt::format("{}: the shape is ({}) where (N, 8) is needed: origin xyz, tmin, "
                    "direction xyz, tmax; reshape the array",
                    name, fmt::join(header->shape, ", ")));
  }
  if (header->fortran) {
    throw Error(name + ": the array is in Fortran order; save numpy.ascontiguousarray(rays)");
  }
  const std::string_view data = bytes.substr(start + size);
  const std::size_t count = header->shape[0];
  constexpr std::size_t kRayBytes = kRayFloats * sizeof(float);
  if (count > data.size() / kRayBytes) {
    throw Error(
        fmt::format("{}: the file is cut: the header promises {} rays of {} bytes, and {} "
                    "bytes follow it; write it again",
                    name, count, kRayBytes, data.size()));
  }
  if (count * kRayBytes != data.size()) {
    throw Error(fmt::format("{}: {} bytes follow the {} rays of the header; write the file again",
                            name, data.size() - count * kRayBytes, count));
  }
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    float f[kRayFloats];
    std::memcpy(f, data.data() + i * kRayBytes, kRayBytes);
    rays[i] = {.o = {f[0], f[1], f[2]}, .tmin = f[3], .d = {f[4], f[5], f[6]}, .tmax = f[7]};
  }
  return rays;
}

std::string rays_npy(std::span<const Ray> rays) {
  std::vector<float> data;
  data.reserve(rays.size() * kRayFloats);
  for (const Ray& r : rays) {
    data.insert(data.end(), {r.o.x, r.o.y, r.o.z, r.tmin, r.d.x, r.d.y, r.d.z, r.tmax});
  }
  return npy("<f4", fmt::format("({}, 8)", rays.size()), bytes_of(data));
}

std::string hits_npy(std::span<const Hit> hits) {
  std::vector<float> data;
  data.reserve(hits.size() * 3);
  for (const Hit& h : hits) {
    data.insert(data.end(), {h.t, h.u, h.v});
  }
  return npy("<f4", fmt::format("({}, 3)", hits.size()), bytes_of(data));
}

std::string prims_npy(std::span<const Hit> hits) {
  std::vector<std::int32_t> data;
  data.reserve(hits.size());
  for (const Hit& h : hits) {
    data.push_back(h.prim);
  }
  return npy("<i4", fmt::format("({},)", hits.size()), bytes_of(data));
}

std::string steps_npy(std::span<const Hit> hits) {
  std::vector<std::uint16_t> data;
  data.reserve(hits.size());
  for (const Hit& h : hits) {
    data.push_back(h.steps);
  }
  return npy("<u2", fmt::format("({},)", hits.size()), bytes_of(data));
}

std::string tests_npy(std::span<const std::uint32_t> tests) {
  return npy("<u4", fmt::format("({},)", tests.size()),
             {reinterpret_cast<const char*>(tests.data()), tests.size_bytes()});
}

std::string radiance_npy(std::span<const glm::vec3> pixels, int width, int height) {
  check_picture(3 * pixels.size(), width, height);
  std::vector<float> data;
  data.reserve(pixels.size() * 3);
  for (const glm::vec3& c : pixels) data.insert(data.end(), {c.x, c.y, c.z});
  return npy("<f4", fmt::format("({}, {}, 3)", height, width), bytes_of(data));
}

}  // namespace ti
