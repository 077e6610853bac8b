// SPDX-License-Identifier: Apache-2.0
#include "testfloat_file.hpp"

#include <charconv>
#include <filesystem>
#include <sstream>
#include <vector>

#include "base/error.hpp"

namespace ti::sim {

TestFloatFile::TestFloatFile(const std::string& path, int operands, int width, int result_width)
    : path_(path), in_(path), operands_(operands), width_(width), result_width_(result_width) {
  if (!in_ || std::filesystem::is_directory(path)) {
    throw Error("Cannot read the TestFloat file '" + path +
                "': give FILE= the path of a text file.");
  }
}

std::uint32_t TestFloatFile::number(const std::string& word, int width) const {
  std::uint32_t value = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value, 16);
  if (error != std::errc() || stop != end || (std::uint64_t{value} >> width) != 0) {
    throw Error(path_ + ":" + std::to_string(line_number_) + ": '" + word +
                "' is not a hex number of at most " + std::to_string(width) + " bits.");
  }
  return value;
}

bool TestFloatFile::next(TestFloatLine& line) {
  std::string text;
  while (std::getline(in_, text)) {
    ++line_number_;
    std::istringstream stream(text);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    if (words.empty()) continue;

    const auto least = static_cast<std::size_t>(operands_) + 1;
    if (words.size() != least && words.size() != least + 1) {
      throw Error(path_ + ":" + std::to_string(line_number_) + ": " + std::to_string(words.size()) +
                  " words, where this operation needs " +
                  (operands_ == 1 ? "'A RESULT FLAGS'." : "'A B RESULT FLAGS'."));
    }
    line.number = line_number_;
    line.a = number(words[0], width_);
    line.b = operands_ == 1 ? 0 : number(words[1], width_);
    line.result = number(words[least - 1], result_width_);
    if (words.size() > least) static_cast<void>(number(words[least], 8));
    return true;
  }
  if (line_number_ == 0) throw Error("The TestFloat file '" + path_ + "' is empty.");
  return false;
}

}  // namespace ti::sim
