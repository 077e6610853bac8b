// SPDX-License-Identifier: Apache-2.0
//
// In place of dram_memory.cpp where DRAMsim3 is not.
#include "base/error.hpp"
#include "dram/dram_memory.hpp"

namespace ti::sim {

std::unique_ptr<Memory> make_dram_memory(std::span<const std::uint8_t> /*image*/,
                                         const DramSettings& /*settings*/) {
  throw Error(
      "MEM=dram: this library of the RTL was built without DRAMsim3; build it by `make engine "
      "MEM=dram CONFIG=...`, which needs cargo, or give MEM=fixed");
}

}  // namespace ti::sim
