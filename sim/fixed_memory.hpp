// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <deque>
#include <random>
#include <vector>

#include "memory.hpp"

namespace ti::sim {

/// A memory of fixed latency and bandwidth, which the ports share; its clock is the engine's.
///
/// Lines that do not touch the image are answered with an error, as is each n-th line when the
/// settings say so; each n-th may also be lost, late or spoilt. With a shuffle seed, answers that
/// are due come in random order.
class FixedMemory final : public Memory {
 public:
  struct Settings {
    int ports = 1;
    int latency = 100;              ///< cycles from a request to its answer
    double bytes_per_cycle = 64.0;  ///< of all ports together
    int line_bytes = 64;
    std::uint64_t error_every = 0;  ///< 0: never
    std::uint64_t lose_every = 0;   ///< the same of the others
    std::uint64_t late_every = 0;
    std::uint64_t late_cycles = 0;  ///< by which a late one comes later
    std::uint64_t spoil_every = 0;
    std::uint64_t shuffle_seed = 0;  ///< 0: in the order of the requests
  };

  FixedMemory(std::span<const std::uint8_t> image, const Settings& settings)
      : Memory(image, settings.line_bytes, 1.0),
        settings_(settings),
        waiting_(static_cast<std::size_t>(settings.ports)),
        random_(settings.shuffle_seed) {}

  [[nodiscard]] bool ready(int /*port*/) const override { return true; }

  void request(int port, std::uint32_t id, std::uint64_t address) override {
    const double start = static_cast<double>(now_) > free_ ? static_cast<double>(now_) : free_;
    free_ = start + line_bytes() / settings_.bytes_per_cycle;
    const std::uint64_t number = count_line();
    const auto each = [number](std::uint64_t n) { return n != 0 && number % n == 0; };
    if (each(settings_.lose_every)) return;
    std::uint64_t when = static_cast<std::uint64_t>(start);
    when += static_cast<std::uint64_t>(settings_.latency);
    if (each(settings_.late_every)) when += settings_.late_cycles;
    const bool error = !inside(address) || each(settings_.error_every);
    waiting_[static_cast<std::size_t>(port)].push_back(
        {when, {id, address, error, each(settings_.spoil_every)}});
  }

  [[nodiscard]] std::optional<Answer> answer(int port) override {
    auto& waiting = waiting_[static_cast<std::size_t>(port)];
    constexpr std::size_t kLooks = 8;
    std::array<std::size_t, kLooks> due{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < waiting.size() && count < kLooks; ++i) {
      if (waiting[i].when <= now_)
        due[count++] = i;
      else if (settings_.late_every == 0)  // those behind are due later still
        break;
    }
    if (count == 0) return std::nullopt;
    const std::size_t pick = due[settings_.shuffle_seed != 0 ? random_() % count : 0];
    const Answer answer = waiting[pick].answer;
    waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(pick));
    return answer;
  }

 private:
  struct Waiting {
    std::uint64_t when;
    Answer answer;
  };

  void cycle() override { ++now_; }

  Settings settings_;
  std::vector<std::deque<Waiting>> waiting_;
  std::mt19937_64 random_;
  std::uint64_t now_ = 0;
  double free_ = 0.0;
};

}  // namespace ti::sim
