// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <iterator>

#include "Vti_engine.h"
#include "bits.hpp"
#include "engine/engine.hpp"
#include "memory.hpp"
#include "ti_config.hpp"
#include "waves.hpp"

/// The ports of an engine: clock and reset, and what the payloads on them are in C++.
namespace ti::sim {

inline constexpr int kFpWidth = 1 + config::kExpBits + config::kFracBits;
inline constexpr int kStepsWidth = std::bit_width(unsigned{config::kWatchdogSteps});
inline constexpr bool kNewton = config::kReciprocal == Reciprocal::kNewton;
inline constexpr Format kFormat{config::kExpBits,
                                config::kFracBits,
                                {.toward_zero = config::kRounding == Rounding::kZero,
                                 .flush = config::kSubnormals == Subnormals::kFlush,
                                 .rcp_table_bits = kNewton ? config::kRcpTableBits : 0,
                                 .rcp_newton_steps = kNewton ? config::kRcpNewtonSteps : 0}};

/// Bit `index` of a port that has one bit a core or a stream.
template <typename Port>
[[nodiscard]] bool bit(const Port& port, int index) {
  return ((port >> index) & 1U) != 0;
}
template <typename Port>
void set_bit(Port& port, int index, bool value) {
  const auto mask = static_cast<Port>(Port{1} << index);
  port = static_cast<Port>(value ? port | mask : port & ~mask);
}

/// One cycle.
inline void step(Vti_engine& top, Waves<Vti_engine>& waves) {
  for (const std::uint8_t clock : {0, 1}) {
    top.clk_i = clock;
    top.eval();
    waves.sample();
  }
}

/// All inputs are as if nobody were there; the scene is not set.
inline void reset(Vti_engine& top, Waves<Vti_engine>& waves) {
  top.flush_i = 0;
  top.ray_valid_i = 0;
  top.hit_ready_i = 0;
  top.m_axi_arready = 0;
  top.m_axi_rvalid = 0;
  top.count_run_i = 0;
  top.snapshot_i = 0;
  top.rst_ni = 0;
  for (int i = 0; i < 4; ++i) step(top, waves);
  top.rst_ni = 1;
  step(top, waves);
}

/// `scene_i`: where the parts of an image are that stands at `Memory::kBase`.
inline void set_scene(Vti_engine& top, const Image& image) {
  const ImageHeader& header = image.header();
  const ImageParts& parts = image.parts();
  std::fill(std::begin(top.scene_i.m_storage), std::end(top.scene_i.m_storage), 0U);
  Packer scene(top.scene_i.m_storage);
  for (const auto& corner : {header.box_hi, header.box_lo}) {
    for (std::uint32_t bits : corner) scene.put(bits, kFpWidth);
  }
  for (std::uint32_t offset :
       {parts.bary_offset, parts.record_offset(), parts.list_offset, parts.node_offset}) {
    scene.put(Memory::kBase + offset, config::kAddrBits);
  }
  scene.put(parts.triangle_count, 29);
  scene.put(parts.list_count, 32);
  scene.put(header.root, 29);
}

/// `ray_data_i` of a stream.
inline void put_ray(Vti_engine& top, int stream, std::uint32_t id, const Ray& ray) {
  auto& words = top.ray_data_i[stream].m_storage;
  std::fill(std::begin(words), std::end(words), 0U);
  Packer packer(words);
  const auto put = [&packer](float value) { packer.put(round_to_bits(kFormat, value), kFpWidth); };
  put(ray.tmax);
  put(ray.tmin);
  for (int axis = 0; axis < 3; ++axis) put(ray.d[axis]);
  for (int axis = 0; axis < 3; ++axis) put(ray.o[axis]);
  packer.put(ray.any ? 1 : 0, 1);
  packer.put(id, 32);
}

/// A beat of `hit_data_o`.
struct HitBeat {
  std::uint32_t id;
  bool found;
  HitBits hit;
};

/// `hit_data_o` of a stream.
[[nodiscard]] inline HitBeat get_hit(const Vti_engine& top, int stream) {
  Unpacker fields(top.hit_data_o[stream].m_storage);
  HitBeat beat{};
  beat.hit.steps = static_cast<std::uint16_t>(fields.get(kStepsWidth));
  beat.hit.v = static_cast<std::uint32_t>(fields.get(kFpWidth));
  beat.hit.u = static_cast<std::uint32_t>(fields.get(kFpWidth));
  beat.hit.t = static_cast<std::uint32_t>(fields.get(kFpWidth));
  beat.hit.prim = static_cast<std::int32_t>(fields.get(32));
  beat.found = fields.get(1) != 0;
  beat.hit.status = static_cast<Status>(fields.get(2));
  beat.id = static_cast<std::uint32_t>(fields.get(32));
  return beat;
}

}  // namespace ti::sim
