// SPDX-License-Identifier: Apache-2.0
#include "top/top_link.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <type_traits>

#include "base/error.hpp"
#include "bits.hpp"
#include "make_memory.hpp"
#include "patience.hpp"
#include "ti_config.hpp"

namespace ti::sim {
namespace {

constexpr int kIdWidth = std::bit_width(unsigned{config::kMaxReads}) - 1;
constexpr int kBeatBits = 256;
constexpr int kLineBits = 8 * config::kLineBytes;

/// Bits of a port from `low` on, at most 64: ports of up to 64 bits are numbers, others words.
template <typename Port>
[[nodiscard]] std::uint64_t bits_of(const Port& port, int low, int width) {
  if constexpr (std::is_integral_v<Port>) {
    const std::uint64_t value = std::uint64_t{port} >> low;
    return width == 64 ? value : value & ((std::uint64_t{1} << width) - 1);
  } else {
    return Unpacker(port.m_storage, low).get(width);
  }
}
template <typename Port>
void set_bits(Port& port, int low, int width, std::uint64_t value) {
  if constexpr (std::is_integral_v<Port>) {
    const std::uint64_t mask = ((std::uint64_t{1} << (width - 1)) * 2 - 1) << low;
    port = static_cast<Port>((port & ~mask) | ((value << low) & mask));
  } else {
    for (int done = 0; done < width;) {
      const int bit = (low + done) % 32;
      const int take = std::min(width - done, 32 - bit);
      const auto mask = static_cast<std::uint32_t>(((std::uint64_t{1} << take) - 1) << bit);
      std::uint32_t& word = port.m_storage[(low + done) / 32];
      word = (word & ~mask) | (static_cast<std::uint32_t>((value >> done) << bit) & mask);
      done += take;
    }
  }
}
template <typename Port>
[[nodiscard]] bool bit_of(const Port& port, int index) {
  return bits_of(port, index, 1) != 0;
}

}  // namespace

TopLink::TopLink(std::size_t bytes, const RtlOptions& options)
    : options_(options), random_(options.stall_seed), bytes_(bytes) {
  memory_ = make_memory(bytes_, options_);
  Waves<Vti_top>::prepare(context_);
  context_.randReset(options_.stall_seed != 0 ? 2 : 0);
  context_.randSeed(static_cast<int>(options_.stall_seed & 0x7fffffffU));
  // Verilator needs arguments even when there are none.
  const char* name = "ti";
  context_.commandArgs(1, &name);
  top_ = std::make_unique<Vti_top>(&context_);
  if (!options_.waves_file.empty()) waves_.open(*top_, options_.waves_file);
  top_->s_axil_awvalid = top_->s_axil_wvalid = top_->s_axil_bready = 0;
  top_->s_axil_arvalid = top_->s_axil_rready = 0;
  top_->s_axis_ray_tvalid = 0;
  top_->m_axis_hit_tready = 0;
  top_->m_axi_arready = top_->m_axi_rvalid = 0;
  top_->aresetn = 0;
  for (int i = 0; i < 8; ++i) cycle();
  top_->aresetn = 1;
  for (int i = 0; i < 8; ++i) cycle();
}

TopLink::~TopLink() {
  top_->final();
  waves_.close();
}

bool TopLink::stall() {
  return options_.stall_seed != 0 &&
         static_cast<double>(random_() >> 11U) * 0x1p-53 < options_.stall_share;
}

/// One cycle, in which the memory answers. Outputs come from registers, so the inputs of the next
/// cycle may follow from those of this one.
void TopLink::cycle() {
  Vti_top& top = *top_;
  std::uint64_t answered = 0;
  for (int core = 0; core < config::kCores; ++core) {
    if (bit_of(top.m_axi_arvalid, core) && bit_of(top.m_axi_arready, core)) {
      memory_->request(
          core, static_cast<std::uint32_t>(bits_of(top.m_axi_arid, core * kIdWidth, kIdWidth)),
          bits_of(top.m_axi_araddr, core * config::kAddrBits, config::kAddrBits));
    }
    if (bit_of(top.m_axi_rvalid, core) && bit_of(top.m_axi_rready, core))
      answered |= std::uint64_t{1} << core;
  }
  for (const std::uint8_t clock : {0, 1}) {
    top.aclk = clock;
    set_bits(top.axis_aclk, 0, config::kStreams, clock != 0 ? ~std::uint64_t{0} : 0);
    top.eval();
    waves_.sample();
  }
  memory_->tick();
  for (int core = 0; core < config::kCores; ++core) {
    set_bits(top.m_axi_arready, core, 1, memory_->ready(core) && !stall() ? 1 : 0);
    if ((answered >> core & 1U) != 0) set_bits(top.m_axi_rvalid, core, 1, 0);
    if (bit_of(top.m_axi_rvalid, core) || stall()) continue;
    const std::optional<Memory::Answer> answer = memory_->answer(core);
    if (!answer) continue;
    set_bits(top.m_axi_rid, core * kIdWidth, kIdWidth, answer->id);
    set_bits(top.m_axi_rresp, core * 2, 2, answer->error ? 2 : 0);
    set_bits(top.m_axi_rlast, core, 1, 1);
    memory_->read(*answer, top.m_axi_rdata.m_storage + core * kLineBits / 32);
    set_bits(top.m_axi_rvalid, core, 1, 1);
  }
}

void TopLink::check(std::uint32_t address, std::uint32_t response) const {
  if (response != 0)
    throw Error(fmt::format("register {:02x}: the bus answers with error {}, there is none",
                            address, response));
}

std::uint32_t TopLink::read(std::uint32_t address) {
  top_->s_axil_araddr = static_cast<std::uint8_t>(address);
  top_->s_axil_arvalid = 1;
  top_->s_axil_rready = 1;
  for (bool taken = false; !taken;) {
    top_->eval();
    taken = top_->s_axil_arready != 0;
    cycle();
  }
  top_->s_axil_arvalid = 0;
  for (;;) {
    top_->eval();
    if (top_->s_axil_rvalid != 0) break;
    cycle();
  }
  const std::uint32_t value = top_->s_axil_rdata;
  const std::uint32_t response = top_->s_axil_rresp;
  cycle();
  top_->s_axil_rready = 0;
  check(address, response);
  return value;
}

void TopLink::write(std::uint32_t address, std::uint32_t value) {
  top_->s_axil_awaddr = static_cast<std::uint8_t>(address);
  top_->s_axil_wdata = value;
  top_->s_axil_wstrb = 0xf;
  top_->s_axil_awvalid = top_->s_axil_wvalid = 1;
  top_->s_axil_bready = 1;
  while (top_->s_axil_awvalid != 0 || top_->s_axil_wvalid != 0) {
    top_->eval();
    const bool address_taken = top_->s_axil_awready != 0;
    const bool value_taken = top_->s_axil_wready != 0;
    cycle();
    if (address_taken) top_->s_axil_awvalid = 0;
    if (value_taken) top_->s_axil_wvalid = 0;
  }
  for (;;) {
    top_->eval();
    if (top_->s_axil_bvalid != 0) break;
    cycle();
  }
  const std::uint32_t response = top_->s_axil_bresp;
  cycle();
  top_->s_axil_bready = 0;
  check(address, response);
}

void TopLink::store(std::uint64_t address, std::span<const std::uint8_t> bytes) {
  const std::uint64_t at = address - Memory::kBase;
  if (address < Memory::kBase || at + bytes.size() > bytes_.size())
    throw Error(fmt::format("there is no memory for {} bytes at {:x}, as it was made for one image",
                            bytes.size(), address));
  std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
}

void TopLink::exchange(std::span<host::Packet> packets) {
  Vti_top& top = *top_;
  std::vector<std::size_t> sent(packets.size(), 0);
  std::size_t missing = 0;  // last hits
  for (host::Packet& packet : packets) {
    packet.hits.clear();
    packet.hits.reserve(packet.rays.size());
    missing += packet.rays.empty() ? 0 : 1;
  }
  const std::uint64_t patience = sim::patience(options_);
  for (std::uint64_t quiet = 0; missing != 0; ++quiet, ++cycles_) {
    if (quiet >= patience)
      throw Error(fmt::format("{} cycles without a hit, the engine hangs", quiet));
    for (std::size_t s = 0; s < packets.size(); ++s) {
      const int stream = static_cast<int>(s);
      host::Packet& packet = packets[s];
      if (!bit_of(top.s_axis_ray_tvalid, stream) && sent[s] < packet.rays.size() && !stall()) {
        const host::Beat& beat = packet.rays[sent[s]];
        std::copy(beat.begin(), beat.end(),
                  top.s_axis_ray_tdata.m_storage + stream * kBeatBits / 32);
        set_bits(top.s_axis_ray_tlast, stream, 1, sent[s] + 1 == packet.rays.size() ? 1 : 0);
        set_bits(top.s_axis_ray_tvalid, stream, 1, 1);
      }
      set_bits(top.m_axis_hit_tready, stream, 1, stall() ? 0 : 1);
    }
    top.eval();
    std::uint64_t taken = 0;
    for (std::size_t s = 0; s < packets.size(); ++s) {
      const int stream = static_cast<int>(s);
      if (bit_of(top.s_axis_ray_tvalid, stream) && bit_of(top.s_axis_ray_tready, stream)) {
        ++sent[s];
        taken |= std::uint64_t{1} << s;
        quiet = 0;
      }
      if (!bit_of(top.m_axis_hit_tvalid, stream) || !bit_of(top.m_axis_hit_tready, stream))
        continue;
      const std::uint32_t* words = top.m_axis_hit_tdata.m_storage + stream * kBeatBits / 32;
      std::copy_n(words, 8, packets[s].hits.emplace_back().begin());
      missing -= bit_of(top.m_axis_hit_tlast, stream) ? 1 : 0;
      quiet = 0;
    }
    cycle();
    for (std::size_t s = 0; s < packets.size(); ++s) {
      if ((taken >> s & 1U) != 0) set_bits(top.s_axis_ray_tvalid, static_cast<int>(s), 1, 0);
    }
  }
  set_bits(top.m_axis_hit_tready, 0, config::kStreams, 0);
}

}  // namespace ti::sim
