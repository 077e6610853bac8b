// SPDX-License-Identifier: Apache-2.0
//
// The structure of a PLY file. Assimp 5.2 makes up faces where a file is cut, so the body is
// measured before it is read.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "base/error.hpp"
#include "import/import.hpp"
#include "io/words.hpp"

namespace ti {

namespace {

constexpr std::string_view kBlank = " \t\r\n\v\f";

struct TypeName {
  std::string_view name;
  std::string_view canonical;
  std::size_t bytes;
};

constexpr std::array<TypeName, 16> kTypes{{
    {"char", "char", 1},
    {"int8", "char", 1},
    {"uchar", "uchar", 1},
    {"uint8", "uchar", 1},
    {"short", "short", 2},
    {"int16", "short", 2},
    {"ushort", "ushort", 2},
    {"uint16", "ushort", 2},
    {"int", "int", 4},
    {"int32", "int", 4},
    {"uint", "int", 4},
    {"uint32", "int", 4},
    {"float", "float", 4},
    {"float32", "float", 4},
    {"double", "double", 8},
    {"float64", "double", 8},
}};

class HeaderReader {
 public:
  HeaderReader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  PlyHeader read() {
    if (!bytes_.starts_with("ply")) {
      throw Error(file_ + ": this is not a PLY file, which starts with `ply`; check its name");
    }
    bool ended = false;
    for (line_ = 1; !ended; ++line_) {
      const auto end = bytes_.find('\n', header_.body);
      if (end == std::string_view::npos) fail("`end_header` is missing");
      std::string_view rest = bytes_.substr(header_.body, end - header_.body);
      header_.body = end + 1;
      std::vector<std::string_view> words;
      for (auto w = next_word(rest, kBlank); !w.empty(); w = next_word(rest, kBlank))
        words.push_back(w);
      if (line_ > 1 && !words.empty()) ended = statement(words);
    }
    if (header_.format.empty()) fail("the line `format` is missing");
    const std::string plain = "vertex;float x;float y;float z;face;list uchar int vertex_indices;";
    header_.plain = header_.format == "binary_little_endian" &&
                    (form_ == plain || form_ == plain + "ushort material;");
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(fmt::format("{}: line {} of the PLY header: {}; export the mesh again", file_,
                            line_, what));
  }

  /// True at the end of the header.
  bool statement(const std::vector<std::string_view>& words) {
    const std::string_view key = words[0];
    if (key == "end_header") return true;
    if (key == "comment" || key == "obj_info") return false;
    if (key == "format" && words.size() == 3) {
      header_.format = words[1];
      if (words[1] != "ascii" && words[1] != "binary_little_endian" &&
          words[1] != "binary_big_endian") {
        fail(fmt::format("`{}` is not a format", words[1]));
      }
    } else if (key == "element" && words.size() == 3) {
      element(words[1], words[2]);
    } else if (key == "property" && words.size() > 1 &&
               words.size() == (words[1] == "list" ? 5U : 3U)) {
      property(words);
    } else {
      fail(fmt::format("`{}` has no meaning here", key));
    }
    return false;
  }

  void element(std::string_view name, std::string_view word) {
    std::uint64_t count = 0;
    if (!parse_number(word, count)) fail(fmt::format("`{}` is not a count", word));
    constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max());
    if (count > std::min<std::uint64_t>(kMax, bytes_.size())) {
      fail(fmt::format("{} elements cannot be in a file of {} bytes", word, bytes_.size()));
    }
    if (name == "vertex") header_.vertices = count;
    if (name == "face") header_.faces = count;
    header_.has_strips |= name == "tristrips";
    header_.elements.push_back({std::string(name), count, {}});
    form_ += fmt::format("{};", name);
  }

  void property(const std::vector<std::string_view>& words) {
    if (header_.elements.empty()) fail("a property stands before any element");
    const bool list = words[1] == "list";
    PlyHeader::Property p;
    p.name = words.back() == "vertex_index" ? "vertex_indices" : words.back();
    const TypeName& item = type(words[list ? 3 : 1]);
    p.bytes = item.bytes;
    if (list) {
      const TypeName& count = type(words[2]);
      p.count_bytes = count.bytes;
      form_ += fmt::format("list {} ", count.canonical);
    }
    form_ += fmt::format("{} {};", item.canonical, p.name);
    auto& element = header_.elements.back();
    header_.has_material |= element.name == "face" && p.name == "material";
    element.properties.push_back(std::move(p));
  }

  const TypeName& type(std::string_view word) const {
    for (const TypeName& t : kTypes) {
      if (t.name == word) return t;
    }
    fail(fmt::format("`{}` is not a type", word));
  }

  std::string_view bytes_;
  const std::string& file_;
  std::size_t line_ = 1;
  PlyHeader header_;
  std::string form_;  // the elements and properties in canonical words
};

/// Walks over the numbers of a body.
class Body {
 public:
  Body(std::string_view bytes, const PlyHeader& header, const std::string& file)
      : bytes_(bytes.substr(header.body)), format_(header.format), file_(file) {}

  void skip(std::size_t bytes, std::size_t count) {
    if (format_ == "ascii") {
      for (std::size_t i = 0; i < count; ++i) (void)number();
    } else {
      if (count > bytes_.size() / bytes) cut();
      bytes_.remove_prefix(bytes * count);
    }
  }

  /// A list's count of items.
  std::size_t count(std::size_t bytes) {
    if (format_ == "ascii") {
      const double value = number();
      if (!(value >= 0.0 && value <= static_cast<double>(bytes_.size() + 1))) cut();
      return static_cast<std::size_t>(value);
    }
    if (bytes > bytes_.size()) cut();
    std::size_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      const std::size_t k = format_ == "binary_big_endian" ? i : bytes - 1 - i;
      value = value << 8 | static_cast<unsigned char>(bytes_[k]);
    }
    bytes_.remove_prefix(bytes);
    return value;
  }

  void at(const std::string& element, std::size_t number) {
    element_ = &element;
    number_ = number;
  }

  void end() {
    const std::size_t left =
        format_ == "ascii" ? next_word(bytes_, kBlank).size() + bytes_.size() : bytes_.size();
    if (left == 0) return;
    throw Error(fmt::format("{}: {} bytes follow the last element; copy or export the file again",
                            file_, left));
  }

 private:
  double number() {
    const std::string_view word = next_word(bytes_, kBlank);
    if (word.empty()) cut();
    double value = 0.0;
    if (!parse_number(word, value)) {
      throw Error(fmt::format("{}: {} {}: `{}` is not a number; export the mesh again", file_,
                              *element_, number_, word));
    }
    return value;
  }

  [[noreturn]] void cut() const {
    throw Error(fmt::format("{}: the file is cut in {} {}; copy or export it again", file_,
                            *element_, number_));
  }

  std::string_view bytes_;
  std::string_view format_;
  const std::string& file_;
  const std::string* element_ = nullptr;
  std::size_t number_ = 0;
};

}  // namespace

PlyHeader read_ply_header(std::string_view bytes, const std::string& file) {
  return HeaderReader(bytes, file).read();
}

std::size_t check_ply_body(std::string_view bytes, const PlyHeader& header,
                           const std::string& file) {
  Body body(bytes, header, file);
  std::size_t triangles = 0;
  for (const auto& element : header.elements) {
    for (std::size_t i = 0; i < element.count; ++i) {
      body.at(element.name, i);
      for (const auto& p : element.properties) {
        const std::size_t count = p.count_bytes > 0 ? body.count(p.count_bytes) : 1;
        body.skip(p.bytes, count);
        const bool corners = element.name == "face" && p.name == "vertex_indices";
        if (corners && count >= 3) triangles += count - 2;
      }
    }
  }
  body.end();
  return triangles;
}

}  // namespace ti
