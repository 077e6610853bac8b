// SPDX-License-Identifier: Apache-2.0
#include "host/uio_link.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.hpp"
#include "io/file.hpp"

namespace ti::host {
namespace {

using nlohmann::json;

constexpr std::uint64_t kBeatBytes = sizeof(Beat);
/// Where rays and hits begin: a multiple of the widest beat of a DMA.
constexpr std::uint64_t kAlign = 128;

constexpr std::uint64_t aligned(std::uint64_t bytes) {
  return (bytes + kAlign - 1) / kAlign * kAlign;
}

/// What Linux says of a device in a file of one number.
std::uint64_t told(const Board& board, const std::filesystem::path& device, const char* driver,
                   const char* what) {
  const std::filesystem::path file =
      board.sysfs / driver / std::filesystem::weakly_canonical(device).filename() / what;
  if (!std::filesystem::is_regular_file(file)) {
    throw Error(fmt::format("{}: there is no such device of {}, as {} is missing", device.string(),
                            driver, file.string()));
  }
  const std::string text = read_file(file);
  char* end = nullptr;
  const std::uint64_t value = std::strtoull(text.c_str(), &end, 0);
  if (end == text.c_str() || value == 0)
    throw Error(fmt::format("{}: this is no size and no address; see {}", file.string(), driver));
  return value;
}

std::uint64_t size_of_uio(const Board& board, const std::filesystem::path& device) {
  return told(board, device, "uio", "maps/map0/size");
}

}  // namespace

Board load_board(const std::filesystem::path& path) {
  const std::string file = path.string();
  const json given = json::parse(read_file(path), nullptr, false);
  if (!given.is_object())
    throw Error(fmt::format("{}: this is no JSON object; docs/parts.md has an example", file));
  Board board;
  const auto device = [&path](const json& value) {
    return path.parent_path() / value.get<std::string>();
  };
  const std::map<std::string, std::function<void(const json&)>> keys{
      {"registers", [&](const json& value) { board.registers = device(value); }},
      {"buffer", [&](const json& value) { board.buffer = device(value); }},
      {"dma",
       [&](const json& value) {
         for (const json& each : value.get<std::vector<json>>()) board.dma.push_back(device(each));
       }},
      {"sysfs", [&](const json& value) { board.sysfs = device(value); }},
      {"interrupts", [&](const json& value) { board.interrupts = value.get<bool>(); }},
      {"seconds", [&](const json& value) { board.seconds = value.get<double>(); }},
      {"length_bits", [&](const json& value) { board.length_bits = value.get<int>(); }}};
  for (const auto& [key, value] : given.items()) {
    const auto found = keys.find(key);
    if (found == keys.end())
      throw Error(fmt::format("{}: there is no key {}; docs/parts.md has them", file, key));
    try {
      found->second(value);
    } catch (const json::exception&) {
      throw Error(
          fmt::format("{}: {} is {}; docs/parts.md has an example", file, key, value.dump()));
    }
  }
  if (board.registers.empty() || board.buffer.empty() || board.dma.empty())
    throw Error(fmt::format("{}: registers, buffer or dma is missing; name these devices", file));
  if (!(board.seconds > 0 && board.seconds < 1e6) || board.length_bits < 8 ||
      board.length_bits > 26) {
    throw Error(
        fmt::format("{}: seconds is {} and length_bits {}; give a time below 1e6 and 8 to "
                    "26 bits",
                    file, board.seconds, board.length_bits));
  }
  return board;
}

UioLink::UioLink(const Board& board)
    : registers_(board.registers, size_of_uio(board, board.registers)),
      buffer_(board.buffer, told(board, board.buffer, "u-dma-buf", "size")),
      base_(told(board, board.buffer, "u-dma-buf", "phys_addr")),
      patience_(board.seconds) {
  for (const std::filesystem::path& device : board.dma) {
    dma_.push_back(std::make_unique<AxiDma>(device, size_of_uio(board, device), board.length_bits,
                                            board.interrupts));
  }
}

std::uint32_t UioLink::read(std::uint32_t address) { return registers_.read(address); }

void UioLink::write(std::uint32_t address, std::uint32_t value) {
  registers_.write(address, value);
}

/// Bytes that the scene and so many more take; throws `Error` when there are not as many.
std::uint64_t UioLink::room_for(std::uint64_t bytes, const char* what) const {
  if (bytes > buffer_.bytes()) {
    throw Error(fmt::format("{}: the buffer has {} bytes and {} take {}; make it larger",
                            buffer_.name(), buffer_.bytes(), what, bytes));
  }
  return bytes;
}

void UioLink::store(std::uint64_t address, std::span<const std::uint8_t> bytes) {
  if (address < base_)
    throw Error(fmt::format("address {:x} lies before {}, which begins at {:x}", address,
                            buffer_.name(), base_));
  stored_ = std::max(stored_, room_for(address - base_ + bytes.size(), "the scene"));
  buffer_.write(address - base_, bytes);
  device_barrier();
}

void UioLink::exchange(std::span<Packet> packets) {
  if (packets.size() > dma_.size()) {
    throw Error(
        fmt::format("the engine has {} streams and the board file {} DMAs; name one for "
                    "each stream",
                    packets.size(), dma_.size()));
  }
  // Behind the scene, for each stream its rays and as much for its hits.
  std::vector<std::uint64_t> places;
  std::uint64_t end = aligned(stored_);
  for (const Packet& packet : packets) {
    places.push_back(end);
    end += 2 * aligned(packet.rays.size() * kBeatBytes);
  }
  (void)room_for(end, "scene, rays and hits");

  const auto last =
      AxiDma::Clock::now() + std::chrono::duration_cast<AxiDma::Clock::duration>(patience_);
  const auto hits_at = [&](std::size_t s) {
    return places[s] + aligned(packets[s].rays.size() * kBeatBytes);
  };
  for (std::size_t s = 0; s < packets.size(); ++s) {
    packets[s].hits.clear();
    if (packets[s].rays.empty()) continue;
    const std::vector<Beat>& rays = packets[s].rays;
    for (std::size_t i = 0; i < rays.size(); ++i)
      buffer_.write(places[s] + i * kBeatBytes, std::span<const std::uint32_t>(rays[i]));
    dma_[s]->start(base_ + places[s], base_ + hits_at(s), rays.size() * kBeatBytes, last);
  }
  for (std::size_t s = 0; s < packets.size(); ++s) {
    if (packets[s].rays.empty()) continue;
    const std::uint64_t bytes = dma_[s]->finish(last);
    packets[s].hits.resize(std::min<std::uint64_t>(bytes / kBeatBytes, packets[s].rays.size()));
    for (std::size_t i = 0; i < packets[s].hits.size(); ++i)
      buffer_.read(hits_at(s) + i * kBeatBytes, std::span<std::uint32_t>(packets[s].hits[i]));
  }
}

}  // namespace ti::host
