// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "host/axi_dma.hpp"
#include "host/link.hpp"
#include "host/mapped_device.hpp"

namespace ti::host {

/// Where the devices of a board are (docs/parts.md).
struct Board {
  std::filesystem::path registers;         ///< UIO device of the registers of `ti_top`
  std::vector<std::filesystem::path> dma;  ///< UIO device of an AXI DMA for each stream
  std::filesystem::path buffer;            ///< u-dma-buf device: scene, rays and hits
  /// Folder in which Linux tells sizes and addresses of devices.
  std::filesystem::path sysfs = "/sys/class";
  bool interrupts = true;  ///< whether the DMAs' are waited for
  double seconds = 10.0;   ///< within which the hits of a packet must come
  int length_bits = 26;    ///< of the length registers of the DMAs
};

/// The board of a JSON file with those keys. Paths are relative to its folder. Throws `Error`.
[[nodiscard]] Board load_board(const std::filesystem::path& file);

/// A `ti_top` on a board that runs Linux: registers by UIO, scene, rays and hits in one buffer of
/// u-dma-buf that engine and DMAs read and write by its physical address, a DMA for each stream.
class UioLink final : public Link {
 public:
  /// Throws `Error` when a device is not there.
  explicit UioLink(const Board& board);

  [[nodiscard]] std::uint32_t read(std::uint32_t address) override;
  void write(std::uint32_t address, std::uint32_t value) override;
  [[nodiscard]] std::uint64_t base() const override { return base_; }
  void store(std::uint64_t address, std::span<const std::uint8_t> bytes) override;
  void exchange(std::span<Packet> packets) override;

 private:
  [[nodiscard]] std::uint64_t room_for(std::uint64_t bytes, const char* what) const;

  MappedDevice registers_;
  MappedDevice buffer_;
  std::uint64_t base_;        // physical address of the buffer
  std::uint64_t stored_ = 0;  // bytes from its start that the scene has
  std::vector<std::unique_ptr<AxiDma>> dma_;
  std::chrono::duration<double> patience_;
};

}  // namespace ti::host
