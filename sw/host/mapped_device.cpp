// SPDX-License-Identifier: Apache-2.0
#include "host/mapped_device.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "base/error.hpp"

namespace ti::host {

MappedDevice::MappedDevice(const std::filesystem::path& device, std::uint64_t bytes)
    : name_(device.string()), bytes_(bytes) {
  // O_SYNC: u-dma-buf maps without the cache of the processor.
  descriptor_ = open(name_.c_str(), O_RDWR | O_SYNC | O_CLOEXEC);
  if (descriptor_ < 0) {
    throw Error(fmt::format("{}: the device cannot be opened ({}); see the board file", name_,
                            std::strerror(errno)));
  }
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor_, 0);
  if (memory == MAP_FAILED) {
    const std::string why = std::strerror(errno);
    close(descriptor_);
    throw Error(
        fmt::format("{}: {} bytes of the device cannot be mapped ({}); is it the device that "
                    "the board file means?",
                    name_, bytes, why));
  }
  words_ = static_cast<volatile std::uint32_t*>(memory);
}

MappedDevice::~MappedDevice() {
  munmap(const_cast<std::uint32_t*>(words_), bytes_);
  close(descriptor_);
}

volatile std::uint32_t* MappedDevice::at(std::uint64_t offset, std::uint64_t words) const {
  if (offset % 4 != 0 || offset > bytes_ || 4 * words > bytes_ - offset) {
    throw Error(fmt::format("{}: there are no {} words at offset {:x}, as it has {} bytes", name_,
                            words, offset, bytes_));
  }
  return words_ + offset / 4;
}

std::uint32_t MappedDevice::read(std::uint64_t offset) const { return *at(offset, 1); }

void MappedDevice::write(std::uint64_t offset, std::uint32_t value) { *at(offset, 1) = value; }

void MappedDevice::read(std::uint64_t offset, std::span<std::uint32_t> words) const {
  const volatile std::uint32_t* from = at(offset, words.size());
  for (std::uint32_t& word : words) word = *from++;
}

void MappedDevice::write(std::uint64_t offset, std::span<const std::uint32_t> words) {
  volatile std::uint32_t* to = at(offset, words.size());
  for (const std::uint32_t word : words) *to++ = word;
}

void MappedDevice::write(std::uint64_t offset, std::span<const std::uint8_t> data) {
  volatile std::uint32_t* to = at(offset, (data.size() + 3) / 4);
  for (; !data.empty(); data = data.subspan(std::min<std::size_t>(4, data.size()))) {
    std::array<std::uint8_t, 4> bytes{};
    std::copy_n(data.begin(), std::min<std::size_t>(4, data.size()), bytes.begin());
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data(), 4);
    *to++ = word;
  }
}

bool arm_interrupt(int descriptor) {
  const std::uint32_t on = 1;
  return ::write(descriptor, &on, sizeof on) == sizeof on;
}

bool await_interrupt(int descriptor, std::chrono::milliseconds most) {
  pollfd ready{.fd = descriptor, .events = POLLIN, .revents = 0};
  if (poll(&ready, 1, static_cast<int>(most.count())) <= 0) return false;
  std::uint32_t count = 0;
  return ::read(descriptor, &count, sizeof count) == sizeof count;
}

}  // namespace ti::host
