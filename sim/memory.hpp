// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "engine/counts.hpp"

namespace ti::sim {

/// The memory behind the read ports of an engine: it holds an image at `kBase` and answers whole
/// lines.
///
/// The harness calls, for each cycle of the engine's clock and each port: `ready`, `request` when a
/// request is taken, `answer` when the port can take one; and `tick` once. What a memory does with
/// its own time it does in `cycle`, which runs `clock_ratio` times a tick on average.
class Memory {
 public:
  static constexpr std::uint64_t kBase = 0x100000;  ///< a multiple of every line size

  struct Answer {
    std::uint32_t id;
    std::uint64_t address;
    bool error;
    bool spoilt = false;  ///< one bit is wrong
  };

  /// `clock_ratio`: cycles of the memory's clock in one of the engine's, above 0.
  Memory(std::span<const std::uint8_t> image, int line_bytes, double clock_ratio)
      : image_(image), line_bytes_(line_bytes), clock_ratio_(clock_ratio) {}
  virtual ~Memory() = default;

  /// Whether a port can take a request in this cycle.
  [[nodiscard]] virtual bool ready(int port) const = 0;
  /// Takes a request; the port was ready.
  virtual void request(int port, std::uint32_t id, std::uint64_t address) = 0;
  /// An answer for a port, if one is due.
  [[nodiscard]] virtual std::optional<Answer> answer(int port) = 0;

  /// What the DRAM did, when it is one.
  [[nodiscard]] virtual std::optional<DramCounts> dram() const { return std::nullopt; }

  /// A cycle of the engine's clock has passed.
  void tick() {
    for (time_ += clock_ratio_; time_ >= 1.0; time_ -= 1.0) cycle();
  }

  /// Copies a line into `words`; bytes outside the image, and all bytes of an error, are 0. The bit
  /// that is wrong in a spoilt one follows from how many lines have been counted.
  void read(const Answer& answer, std::uint32_t* words) const {
    for (int i = 0; i < line_bytes_ / 4; ++i) {
      std::uint32_t word = 0;
      for (int b = 3; b >= 0; --b) {
        const std::uint64_t at = answer.address + static_cast<std::uint64_t>(4 * i + b) - kBase;
        word = word << 8U | (!answer.error && at < image_.size() ? image_[at] : 0U);
      }
      words[i] = word;
    }
    if (!answer.spoilt) return;
    const std::uint64_t bit = lines_ * 0x9e3779b97f4a7c15U >> 32U;
    words[bit / 32 % static_cast<std::uint64_t>(line_bytes_ / 4)] ^= 1U << bit % 32;
  }

  /// Bytes that went to the ports.
  [[nodiscard]] std::uint64_t bytes() const {
    return lines_ * static_cast<std::uint64_t>(line_bytes_);
  }

 protected:
  virtual void cycle() = 0;

  /// Whether the line at `address` touches the image.
  [[nodiscard]] bool inside(std::uint64_t address) const {
    return address + static_cast<std::uint64_t>(line_bytes_) > kBase &&
           address < kBase + image_.size();
  }
  [[nodiscard]] int line_bytes() const { return line_bytes_; }
  /// Counts a line; its number, from 1.
  std::uint64_t count_line() { return ++lines_; }

 private:
  std::span<const std::uint8_t> image_;
  int line_bytes_;
  double clock_ratio_;
  double time_ = 0.0;
  std::uint64_t lines_ = 0;
};

}  // namespace ti::sim
