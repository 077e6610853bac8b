// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace ti::host {

/// What was written before reaches a device before what is written after, and reads likewise.
inline void device_barrier() {
#if defined(__aarch64__) || defined(__arm__)
  asm volatile("dsb sy" ::: "memory");
#else
  std::atomic_thread_fence(std::memory_order_seq_cst);
#endif
}

/// Memory of a device (UIO, u-dma-buf), or of a file in its place, as words of 32 bits. Each word
/// is one access, so registers and uncached memory are safe.
class MappedDevice {
 public:
  /// Maps the first `bytes` of it; throws `Error` when there is no such device.
  MappedDevice(const std::filesystem::path& device, std::uint64_t bytes);
  ~MappedDevice();
  MappedDevice(const MappedDevice&) = delete;
  MappedDevice& operator=(const MappedDevice&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

  /// The word at a byte offset, a multiple of 4; throws `Error` beyond the end.
  [[nodiscard]] std::uint32_t read(std::uint64_t offset) const;
  void write(std::uint64_t offset, std::uint32_t value);
  /// Many of them; bytes of a last word that the data do not have become 0.
  void read(std::uint64_t offset, std::span<std::uint32_t> words) const;
  void write(std::uint64_t offset, std::span<const std::uint32_t> words);
  void write(std::uint64_t offset, std::span<const std::uint8_t> data);

  /// The file descriptor, for interrupts.
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  [[nodiscard]] volatile std::uint32_t* at(std::uint64_t offset, std::uint64_t words) const;

  std::string name_;
  std::uint64_t bytes_;
  int descriptor_ = -1;
  volatile std::uint32_t* words_ = nullptr;
};

/// Lets the interrupt of a UIO device come; false where the device takes none.
[[nodiscard]] bool arm_interrupt(int descriptor);
/// Waits for it; false when it does not come in that time.
[[nodiscard]] bool await_interrupt(int descriptor, std::chrono::milliseconds most);

}  // namespace ti::host
