// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/core.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

namespace ti {

/// A bar with rays/s and cycles/s on a terminal; a line every ten seconds elsewhere.
class Progress {
 public:
  explicit Progress(std::uint64_t total = 0)
      : total_(total), terminal_(isatty(STDERR_FILENO) != 0) {}

  /// The rays that are expected, where they were not known before.
  void expect(std::uint64_t total) { total_ = total; }

  /// Counts of an engine that begins anew go on from here.
  void begin_at(std::uint64_t rays, std::uint64_t cycles) {
    rays_before_ = rays;
    cycles_before_ = cycles;
  }

  /// Ends the line of the bar.
  ~Progress() {
    if (shown_ != begin_ && terminal_) fmt::print(stderr, "\n");
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(std::uint64_t done, std::uint64_t cycles) {
    const auto now = Clock::now();
    if (now - shown_ < (terminal_ ? std::chrono::milliseconds(200) : std::chrono::seconds(10)))
      return;
    shown_ = now;
    show(rays_before_ + done, cycles_before_ + cycles);
    if (!terminal_) fmt::print(stderr, "\n");
  }

 private:
  using Clock = std::chrono::steady_clock;

  void show(std::uint64_t done, std::uint64_t cycles) const {
    constexpr std::size_t kWidth = 30;
    const double share =
        total_ == 0 ? 1.0 : static_cast<double>(done) / static_cast<double>(total_);
    const auto full = static_cast<std::size_t>(share * kWidth);
    const double elapsed = std::chrono::duration<double>(Clock::now() - begin_).count();
    fmt::print(stderr, "{}rtl [{}{}] {:3.0f} % {} rays, {:.0f} rays/s, {:.0f} cycles/s",
               terminal_ ? "\r" : "", std::string(full, '#'), std::string(kWidth - full, '.'),
               100 * share, done, static_cast<double>(done) / elapsed,
               static_cast<double>(cycles) / elapsed);
    std::fflush(stderr);
  }

  std::uint64_t total_;
  std::uint64_t rays_before_ = 0;
  std::uint64_t cycles_before_ = 0;
  bool terminal_;
  Clock::time_point begin_ = Clock::now();
  Clock::time_point shown_ = begin_;
};

}  // namespace ti
