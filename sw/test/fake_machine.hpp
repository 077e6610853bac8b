// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>

#include "base/format.hpp"
#include "host/link.hpp"
#include "host/ti_regs.h"
#include "model/tracer.hpp"

namespace ti::test {

/// Registers of an idle `ti_top` that are not 0, by their byte address.
inline std::map<std::size_t, std::uint32_t> machine_registers(int streams,
                                                              Format format = {8, 23}) {
  return {{offsetof(ti_regs_t, ID), TI_REGS__ID__VALUE_reset},
          {offsetof(ti_regs_t, VERSION), 1U << 16U | 7U},
          {offsetof(ti_regs_t, FORMAT),
           static_cast<std::uint32_t>(format.exp_bits | format.frac_bits << 8)},
          {offsetof(ti_regs_t, MACHINE),
           static_cast<std::uint32_t>(streams | streams << 8) | 1U << 20U},
          {offsetof(ti_regs_t, MEMORY), 64U | 32U << 8U},
          {offsetof(ti_regs_t, STATUS), TI_REGS__STATUS__IDLE_bm}};
}

/// What the machine answers a ray of number `number` in a packet; of the format (8,23).
inline host::Beat answer(const Tracer& model, const host::Beat& beat, bool any,
                         std::uint32_t number) {
  const auto value = [&beat](std::size_t word) { return std::bit_cast<float>(beat[word]); };
  Work work;
  const HitBits hit = model.trace({.o = {value(0), value(1), value(2)},
                                   .tmin = value(3),
                                   .d = {value(4), value(5), value(6)},
                                   .tmax = value(7),
                                   .any = any},
                                  work);
  return {number, static_cast<std::uint32_t>(hit.prim),   hit.t,     hit.u,
          hit.v,  static_cast<std::uint32_t>(hit.status), hit.steps, 0};
}

}  // namespace ti::test
