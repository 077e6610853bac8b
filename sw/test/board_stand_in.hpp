// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "accel/image.hpp"
#include "fake_machine.hpp"
#include "host/mapped_device.hpp"

namespace ti::test {

/// A board of ordinary files: registers of a `ti_top` whose engine is the model, DMAs, and their
/// memory. A thread plays them.
class BoardStandIn {
 public:
  enum class Fault { None, RaysUnmapped, HitsRefused, Silent, Deaf, Version };
  struct Options {
    int streams = 1;
    std::uint64_t buffer_bytes = 1U << 20U;
    Fault fault = Fault::None;
    double seconds = 60.0;  ///< in the board file
    int length_bits = 26;
    Tracer::Options model = {};
  };

  static constexpr std::uint64_t kBase = 0x3'7000'0000;

  BoardStandIn(const std::filesystem::path& folder, const Options& options)
      : folder_(folder), options_(options) {
    make_device("uio", "uio0", "maps/map0/size", kRegisterBytes);
    registers_.emplace(folder / "uio0", kRegisterBytes);
    nlohmann::json board = {{"registers", "uio0"},        {"buffer", "udmabuf0"},
                            {"sysfs", "sysfs"},           {"interrupts", false},
                            {"seconds", options.seconds}, {"length_bits", options.length_bits}};
    for (int s = 0; s < options.streams; ++s) {
      const std::string name = "uio" + std::to_string(s + 1);
      make_device("uio", name, "maps/map0/size", kRegisterBytes);
      dma_.push_back(std::make_unique<host::MappedDevice>(folder / name, kRegisterBytes));
      board["dma"].push_back(name);
    }
    make_device("u-dma-buf", "udmabuf0", "size", options.buffer_bytes);
    write(folder / "sysfs/u-dma-buf/udmabuf0/phys_addr", std::to_string(kBase));
    memory_.emplace(folder / "udmabuf0", options.buffer_bytes);
    write(file(), board.dump());
    for (const auto& [address, value] : machine_registers(options.streams))
      registers_->write(address, value);
    // Of 34 bits of addresses, as the buffer lies beyond 32.
    registers_->write(offsetof(ti_regs_t, MEMORY), 64U | 34U << 8U);
    if (options.fault == Fault::Version) registers_->write(offsetof(ti_regs_t, VERSION), 2U << 16U);
    thread_ = std::thread([this] {
      while (!stop_) {
        play();
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      }
    });
  }
  ~BoardStandIn() {
    stop_ = true;
    thread_.join();
  }
  BoardStandIn(const BoardStandIn&) = delete;
  BoardStandIn& operator=(const BoardStandIn&) = delete;

  [[nodiscard]] std::filesystem::path file() const { return folder_ / "board.json"; }

 private:
  static constexpr std::uint64_t kRegisterBytes = 4096;
  static constexpr std::uint32_t kReset = 4, kHalted = 1;
  static constexpr std::uint32_t kSlaveError = 1U << 5U, kDecodeError = 1U << 6U;
  static constexpr std::uint32_t kDone = 1U << 12U;

  static void write(const std::filesystem::path& path, const std::string& text) {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  void make_device(const std::string& driver, const std::string& name, const std::string& size_file,
                   std::uint64_t bytes) const {
    write(folder_ / name, "");
    std::filesystem::resize_file(folder_ / name, bytes);
    write(folder_ / "sysfs" / driver / name / size_file, std::to_string(bytes) + "\n");
  }

  void play() {
    const std::uint32_t control = registers_->read(offsetof(ti_regs_t, CONTROL));
    if ((control & TI_REGS__CONTROL__FLUSH_bm) != 0) {
      host::device_barrier();
      model_.reset();
      image_.reset();
      registers_->write(offsetof(ti_regs_t, CONTROL), control & ~TI_REGS__CONTROL__FLUSH_bm);
    }
    if (options_.fault == Fault::Deaf) return;
    for (const auto& dma : dma_) play(*dma, control);
  }

  void play(host::MappedDevice& dma, std::uint32_t control) {
    if ((dma.read(0x00) & kReset) != 0) {
      for (const std::uint64_t length : {0x28U, 0x58U}) dma.write(length, 0);
      for (const std::uint64_t status : {0x04U, 0x34U}) dma.write(status, kHalted);
      dma.write(0x30, 0);
      dma.write(0x00, 0);
      return;
    }
    const std::uint64_t bytes = dma.read(0x28);
    const bool run = (dma.read(0x00) & dma.read(0x30) & 1U) != 0;
    if (bytes == 0 || !run || (control & TI_REGS__CONTROL__RUN_bm) == 0) return;
    dma.write(0x28, 0);
    if (options_.fault == Fault::Silent) return;
    if (options_.fault == Fault::RaysUnmapped) return dma.write(0x04, kHalted | kDecodeError);
    if (options_.fault == Fault::HitsRefused) return dma.write(0x34, kHalted | kSlaveError);
    trace(place(dma, 0x18), place(dma, 0x48), bytes / sizeof(host::Beat),
          (control & TI_REGS__CONTROL__ANY_HIT_bm) != 0);
    dma.write(0x58, static_cast<std::uint32_t>(bytes));
    host::device_barrier();
    dma.write(0x34, kDone);
  }

  /// Where in the buffer the address in two registers is.
  static std::uint64_t place(const host::MappedDevice& dma, std::uint64_t low) {
    return (dma.read(low) | std::uint64_t{dma.read(low + 4)} << 32U) - kBase;
  }

  /// The hits come last ray first.
  void trace(std::uint64_t rays, std::uint64_t hits, std::uint64_t count, bool any) {
    if (!model_) load();
    for (std::uint64_t i = count; i-- > 0; hits += sizeof(host::Beat)) {
      host::Beat beat;
      memory_->read(rays + i * sizeof beat, std::span<std::uint32_t>(beat));
      beat = answer(*model_, beat, any, static_cast<std::uint32_t>(i));
      memory_->write(hits, std::span<const std::uint32_t>(beat));
    }
  }

  void load() {
    ImageHeader header;
    std::vector<std::uint32_t> words(sizeof header / 4);
    memory_->read(0, std::span(words));
    std::memcpy(&header, words.data(), sizeof header);
    words.resize((header.size_bytes + 3) / 4);
    memory_->read(0, std::span(words));
    std::vector<std::uint8_t> bytes(header.size_bytes);
    std::memcpy(bytes.data(), words.data(), bytes.size());
    image_.emplace(std::move(bytes), "memory of the board");
    model_ = Tracer::create(*image_, options_.model);
  }

  std::filesystem::path folder_;
  Options options_;
  std::optional<host::MappedDevice> registers_, memory_;
  std::vector<std::unique_ptr<host::MappedDevice>> dma_;
  std::optional<Image> image_;
  std::unique_ptr<Tracer> model_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace ti::test
