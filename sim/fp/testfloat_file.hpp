// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <fstream>
#include <string>

namespace ti::sim {

/// One line of Berkeley TestFloat's generator: operands, expected result, exception flags.
struct TestFloatLine {
  std::uint64_t number = 0;  ///< in the file, from 1
  std::uint32_t a = 0;
  std::uint32_t b = 0;  ///< 0 for an operation of one operand
  std::uint32_t result = 0;
};

/// Reads `A B RESULT FLAGS` (or `A RESULT FLAGS`) in hex, line by line; empty lines are skipped and
/// FLAGS may be absent. Throws `ti::Error` naming the line when it has another form or a value does
/// not fit its width.
class TestFloatFile {
 public:
  /// `width` bits a number, `result_width` bits a result.
  TestFloatFile(const std::string& path, int operands, int width, int result_width);

  /// False at the end of the file.
  [[nodiscard]] bool next(TestFloatLine& line);

 private:
  [[nodiscard]] std::uint32_t number(const std::string& word, int width) const;

  std::string path_;
  std::ifstream in_;
  int operands_;
  int width_;
  int result_width_;
  std::uint64_t line_number_ = 0;
};

}  // namespace ti::sim
