// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "engine/engine.hpp"
#include "host/device.hpp"
#include "host/link.hpp"

namespace ti::host {

/// The `ti_top` behind a link as an engine: packets of rays in, hits out. Rays of a packet are of
/// one kind; counters count while a packet is on its way.
class HostEngine : public Engine {
 public:
  /// Loads the image. `progress` is that of `RtlOptions`.
  HostEngine(std::unique_ptr<Link> link, const Image& image,
             std::function<void(std::uint64_t, std::uint64_t)> progress);

  [[nodiscard]] Format format() const override { return format_; }
  void submit(std::span<const Ray> rays) override;
  std::size_t cancel() override;
  void poll(std::vector<Answer>& answers, std::size_t least) override;
  [[nodiscard]] Counts counts() override { return counts_; }

 protected:
  [[nodiscard]] Device& device() { return device_; }

 private:
  /// The machine's cycle; 0 where nobody knows it.
  [[nodiscard]] virtual std::uint64_t cycle() const { return 0; }

  std::unique_ptr<Link> link_;
  Device device_;
  Format format_;
  std::function<void(std::uint64_t, std::uint64_t)> progress_;
  std::deque<Ray> queue_;
  Counts counts_;  // but for `work` and `machine`
};

/// The board that a file describes (`load_board`).
[[nodiscard]] std::unique_ptr<Engine> make_board_engine(const std::filesystem::path& board,
                                                        const Image& image);

}  // namespace ti::host
