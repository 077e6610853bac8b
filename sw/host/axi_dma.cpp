// SPDX-License-Identifier: Apache-2.0
#include "host/axi_dma.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <thread>

#include "base/error.hpp"

namespace ti::host {
namespace {

// Registers of a channel, and where the channels' begin.
constexpr std::uint64_t kMm2s = 0x00, kS2mm = 0x30;
constexpr std::uint64_t kControl = 0x00, kStatus = 0x04, kAddress = 0x18, kLength = 0x28;

constexpr std::uint32_t kRun = 1U << 0U, kReset = 1U << 2U;  // of the control
constexpr std::uint32_t kDoneInterrupt = 1U << 12U, kErrorInterrupt = 1U << 14U;

constexpr std::uint32_t kDone = 1U << 12U;  // of the status
constexpr std::uint32_t kInternal = 1U << 4U, kSlave = 1U << 5U, kDecode = 1U << 6U;
constexpr std::uint32_t kErrors = kInternal | kSlave | kDecode;

/// How long an interrupt is waited for until the status is read all the same.
constexpr std::chrono::milliseconds kLook{100};
/// Between two looks at the status without interrupts.
constexpr std::chrono::microseconds kPause{10};

}  // namespace

AxiDma::AxiDma(const std::filesystem::path& device, std::uint64_t bytes, int length_bits,
               bool interrupts)
    : registers_(device, bytes),
      most_((std::uint64_t{1} << length_bits) - 1),
      interrupts_(interrupts) {}

void AxiDma::start(std::uint64_t rays, std::uint64_t hits, std::uint64_t bytes,
                   Clock::time_point end) {
  if (bytes > most_) {
    throw Error(
        fmt::format("{}: a transfer of {} bytes is longer than the {} that the DMA takes; "
                    "build it with a wider length register, or send fewer rays at once",
                    registers_.name(), bytes, most_));
  }
  // Resets both channels, whatever an earlier transfer has left.
  registers_.write(kMm2s + kControl, kReset);
  while ((registers_.read(kMm2s + kControl) & kReset) != 0) {
    if (Clock::now() > end) time_out("its reset does not end");
    std::this_thread::yield();
  }
  if (interrupts_ && !arm_interrupt(registers_.descriptor())) {
    throw Error(
        fmt::format("{}: the device takes no interrupts; set \"interrupts\" to false in "
                    "the board file",
                    registers_.name()));
  }
  device_barrier();  // the rays are in memory
  const std::uint32_t interrupts = interrupts_ ? kDoneInterrupt | kErrorInterrupt : 0;
  const auto begin = [&](std::uint64_t channel, std::uint64_t address, std::uint32_t control) {
    registers_.write(channel + kControl, control);
    registers_.write(channel + kAddress, static_cast<std::uint32_t>(address));
    registers_.write(channel + kAddress + 4, static_cast<std::uint32_t>(address >> 32U));
    registers_.write(channel + kLength, static_cast<std::uint32_t>(bytes));  // starts it
  };
  begin(kS2mm, hits, kRun | interrupts);
  begin(kMm2s, rays, kRun);
}

std::uint32_t AxiDma::finish(Clock::time_point end) {
  for (bool fired = false;;) {
    check_errors();
    if ((registers_.read(kS2mm + kStatus) & kDone) != 0) break;
    if (Clock::now() > end) time_out("the hits do not come");
    if (interrupts_) {
      if (fired) (void)arm_interrupt(registers_.descriptor());  // it was not of the hits
      fired = await_interrupt(registers_.descriptor(), kLook);
    } else {
      std::this_thread::sleep_for(kPause);
    }
  }
  device_barrier();  // the hits are in memory
  return registers_.read(kS2mm + kLength);
}

void AxiDma::check_errors() const {
  for (const std::uint64_t channel : {kMm2s, kS2mm}) {
    const std::uint32_t status = registers_.read(channel + kStatus);
    if ((status & kErrors) == 0) continue;
    const char* kind = (status & kDecode) != 0  ? "no memory is at an address"
                       : (status & kSlave) != 0 ? "the memory answers with an error"
                                                : "a transfer is longer or shorter than asked for";
    throw Error(fmt::format("{}: the DMA of the {} stops, {} ({}_DMASR is {:08x})",
                            registers_.name(), channel == kMm2s ? "rays" : "hits", kind,
                            channel == kMm2s ? "MM2S" : "S2MM", status));
  }
}

void AxiDma::time_out(const char* what) const {
  throw Error(fmt::format(
      "{}: {} in the time of the board file, MM2S_DMASR is {:08x} and "
      "S2MM_DMASR {:08x}",
      registers_.name(), what, registers_.read(kMm2s + kStatus), registers_.read(kS2mm + kStatus)));
}

}  // namespace ti::host
