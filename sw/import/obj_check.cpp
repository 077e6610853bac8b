// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "import/import.hpp"
#include "io/file.hpp"
#include "io/words.hpp"

namespace ti {

namespace {

constexpr std::string_view kBlank = " \t\r";

class ObjChecker {
 public:
  explicit ObjChecker(const std::filesystem::path& path)
      : folder_(path.parent_path()), file_(path.string()) {}

  void statement(std::string_view line, std::size_t number) {
    std::string_view rest = line;
    const std::string_view key = next_word(rest, kBlank);
    if (key == "v") {
      vertex(rest, number);
    } else if (key == "f") {
      face(rest, number);
    } else if (key == "mtllib") {
      library(rest);
    }
  }

  ObjSummary finish() {
    // An index may point ahead, so the greatest one is judged at the end.
    if (greatest_ > vertices_) fail(greatest_line_, static_cast<std::int64_t>(greatest_));
    return std::move(summary_);
  }

 private:
  [[noreturn]] void fail(std::size_t line, std::int64_t index) const {
    throw Error(
        fmt::format("{}: line {}: the face has index {}, and there are {} vertices; export "
                    "the mesh again",
                    file_, line, index, vertices_));
  }

  void vertex(std::string_view rest, std::size_t line) {
    ++vertices_;
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = next_word(rest, kBlank);
      double value = 0.0;
      if (parse_number(word, value)) continue;
      throw Error(
          fmt::format("{}: line {}: a vertex has `{}` where 3 numbers are needed; export the "
                      "mesh again",
                      file_, line, word));
    }
  }

  void face(std::string_view rest, std::size_t line) {
    std::size_t corners = 0;
    for (std::string_view word = next_word(rest, kBlank); !word.empty();
         word = next_word(rest, kBlank)) {
      if (word.front() == '#') break;
      std::int64_t index = 0;
      const auto [end, ec] = std::from_chars(word.data(), word.data() + word.size(), index);
      const bool ends_well = end == word.data() + word.size() || *end == '/';
      if (ec != std::errc() || !ends_well) {
        throw Error(
            fmt::format("{}: line {}: `{}` is not a corner of a face; export the mesh again", file_,
                        line, word));
      }
      if (index == 0 || index < -static_cast<std::int64_t>(vertices_)) fail(line, index);
      if (index > 0 && static_cast<std::uint64_t>(index) > greatest_) {
        greatest_ = static_cast<std::uint64_t>(index);
        greatest_line_ = line;
      }
      ++corners;
    }
    if (corners >= 3) summary_.triangles += corners - 2;
  }

  void library(std::string_view rest) {
    rest.remove_prefix(std::min(rest.find_first_not_of(kBlank), rest.size()));
    rest = rest.substr(0, rest.find_last_not_of(kBlank) + 1);
    std::error_code ec;
    if (!std::filesystem::exists(folder_ / rest, ec)) {
      summary_.missing_libraries.emplace_back(rest);
    }
  }

  std::filesystem::path folder_;
  std::string file_;
  ObjSummary summary_;
  std::uint64_t vertices_ = 0;
  std::uint64_t greatest_ = 0;
  std::size_t greatest_line_ = 0;
};

}  // namespace

ObjSummary check_obj(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  ObjChecker checker(path);
  std::string joined;  // a statement that goes on over several lines, each but the last ending in a
                       // backslash
  std::size_t number = 0;
  for (std::string_view rest = text; !rest.empty();) {
    const auto end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    ++number;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.ends_with('\\')) {
      joined.append(line.substr(0, line.size() - 1)).push_back(' ');
    } else if (joined.empty()) {
      checker.statement(line, number);
    } else {
      checker.statement(joined.append(line), number);
      joined.clear();
    }
  }
  return checker.finish();
}

}  // namespace ti
