// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <span>

namespace ti::sim {

/// A memory of fixed latency and bandwidth that holds an image at `kBase`; answers whole lines.
///
/// Lines that do not touch the image are answered with an error, as is each n-th line when the
/// settings say so. With stalls, answers that are due come in random order.
class Memory {
 public:
  static constexpr std::uint64_t kBase = 0x100000;  ///< a multiple of every line size

  struct Settings {
    int latency = 100;  ///< cycles
    double bytes_per_cycle = 64.0;
    int line_bytes = 64;
    std::uint64_t error_every = 0;  ///< 0: never
    bool shuffle = false;
  };

  struct Answer {
    std::uint32_t id;
    std::uint64_t address;
    bool error;
  };

  Memory(std::span<const std::uint8_t> image, const Settings& settings)
      : image_(image), settings_(settings) {}

  /// Takes a request in cycle `now`.
  void request(std::uint64_t now, std::uint32_t id, std::uint64_t address) {
    const double start =
        static_cast<double>(now) > port_free_ ? static_cast<double>(now) : port_free_;
    port_free_ = start + settings_.line_bytes / settings_.bytes_per_cycle;
    ++requests_;
    const bool inside = address + static_cast<std::uint64_t>(settings_.line_bytes) > kBase &&
                        address < kBase + image_.size();
    const bool error =
        !inside || (settings_.error_every != 0 && requests_ % settings_.error_every == 0);
    waiting_.push_back(
        {static_cast<std::uint64_t>(start) + static_cast<std::uint64_t>(settings_.latency),
         {id, address, error}});
  }

  /// An answer that is due in cycle `now`.
  [[nodiscard]] std::optional<Answer> answer(std::uint64_t now, std::mt19937_64& random) {
    std::size_t due = 0;
    while (due < waiting_.size() && due < 8 && waiting_[due].when <= now) ++due;
    if (due == 0) return std::nullopt;
    const std::size_t pick = settings_.shuffle ? random() % due : 0;
    const Answer answer = waiting_[pick].answer;
    waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(pick));
    return answer;
  }

  /// Copies a line into `words`; bytes outside the image, and all bytes of an error, are 0.
  void read(const Answer& answer, std::uint32_t* words) const {
    for (int i = 0; i < settings_.line_bytes / 4; ++i) {
      std::uint32_t word = 0;
      for (int b = 3; b >= 0; --b) {
        const std::uint64_t at = answer.address + static_cast<std::uint64_t>(4 * i + b) - kBase;
        word = word << 8U | (!answer.error && at < image_.size() ? image_[at] : 0U);
      }
      words[i] = word;
    }
  }

  [[nodiscard]] std::uint64_t bytes() const {
    return requests_ * static_cast<std::uint64_t>(settings_.line_bytes);
  }

 private:
  struct Waiting {
    std::uint64_t when;
    Answer answer;
  };

  std::span<const std::uint8_t> image_;
  Settings settings_;
  std::deque<Waiting> waiting_;
  double port_free_ = 0.0;
  std::uint64_t requests_ = 0;
};

}  // namespace ti::sim
