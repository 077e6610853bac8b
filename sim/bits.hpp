// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace ti::sim {

/// Writes the fields of a packed struct into a wide Verilator port, last field first.
class Packer {
 public:
  /// `words` must be all 0.
  explicit Packer(std::uint32_t* words) : words_(words) {}

  Packer& put(std::uint64_t value, int width) {
    for (int done = 0; done < width;) {
      const int bit = position_ % 32;
      const int take = width - done < 32 - bit ? width - done : 32 - bit;
      const auto part =
          static_cast<std::uint32_t>((value >> done) & ((std::uint64_t{1} << take) - 1));
      words_[position_ / 32] |= part << bit;
      position_ += take;
      done += take;
    }
    return *this;
  }

 private:
  std::uint32_t* words_;
  int position_ = 0;
};

/// Reads the fields of a packed struct from a wide Verilator port, last field first.
class Unpacker {
 public:
  explicit Unpacker(const std::uint32_t* words, int position = 0)
      : words_(words), position_(position) {}

  [[nodiscard]] std::uint64_t get(int width) {
    std::uint64_t value = 0;
    for (int done = 0; done < width;) {
      const int bit = position_ % 32;
      const int take = width - done < 32 - bit ? width - done : 32 - bit;
      const std::uint64_t part = (words_[position_ / 32] >> bit) & ((std::uint64_t{1} << take) - 1);
      value |= part << done;
      position_ += take;
      done += take;
    }
    return value;
  }

 private:
  const std::uint32_t* words_;
  int position_;
};

}  // namespace ti::sim
