// SPDX-License-Identifier: Apache-2.0
#include "accel/range_audit.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

namespace ti {
namespace {

/// Adds "3 coordinates overflow" and the like to `parts`, where there are any.
void add(std::vector<std::string>& parts, std::uint64_t count, const std::string& one,
         const std::string& more) {
  if (count != 0) parts.push_back(fmt::format("{} {}", count, count == 1 ? one : more));
}

void add(std::vector<std::string>& parts, const RangeLosses& losses, const std::string& what,
         const std::string& off) {
  add(parts, losses.overflowed, what + " overflows", what + "s overflow");
  add(parts, losses.vanished, what + " vanishes" + off, what + "s vanish" + off);
  add(parts, losses.shortened, what + " keeps few bits" + off, what + "s keep few bits" + off);
}

}  // namespace

void RangeLosses::add(const Format& format, double given, double stored) {
  if (!std::isfinite(given) || given == stored) return;
  if (!std::isfinite(stored)) {
    ++overflowed;
  } else if (stored == 0.0) {
    ++vanished;
  } else if (std::abs(stored) < format.least_normal()) {
    ++shortened;
  }
}

std::string range_warning(const RangeAudit& audit, const Format& format) {
  std::vector<std::string> parts;
  add(parts, audit.coordinates, "coordinate", fmt::format(" (by up to {:.1e} units)", audit.moved));
  add(parts, audit.constants, "constant", "");
  const bool range = !parts.empty();
  add(parts, audit.merged, "vertex falls on another", "vertices fall on another");
  add(parts, audit.dropped_rounded, "triangle loses its area", "triangles lose their area");
  if (parts.empty()) return {};
  const bool fraction = audit.merged + audit.dropped_rounded != 0;
  return fmt::format("in {} {}: take more {}", name_of(format), fmt::join(parts, ", "),
                     range && fraction ? "exp_bits and frac_bits"
                     : range           ? "exp_bits"
                                       : "frac_bits");
}

}  // namespace ti
