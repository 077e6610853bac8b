// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "base/format.hpp"

namespace ti {

/// Numbers of an image that the range of its format does not hold as they were.
struct RangeLosses {
  std::uint64_t overflowed = 0;  ///< finite before, infinite in the format
  std::uint64_t vanished = 0;    ///< not 0 before, 0 in the format
  std::uint64_t shortened = 0;   ///< below the least normal number and not exact: few bits are left

  /// Counts one number, that stands as `stored`.
  void add(const Format& format, double given, double stored);
  [[nodiscard]] bool none() const { return overflowed + vanished + shortened == 0; }
};

/// What the range and the fraction of a format make of a mesh, once it is scaled.
struct RangeAudit {
  RangeLosses coordinates;   ///< of the vertices that triangles name
  RangeLosses constants;     ///< of the triangles, of Shevtsov's test
  double moved = 0.0;        ///< by how much such a coordinate is off at most, in scene units
  std::uint32_t merged = 0;  ///< places that others of the mesh fall on by rounding
  std::uint32_t dropped_overflow = 0;  ///< triangles that are finite as they are given
  std::uint32_t dropped_rounded = 0;   ///< triangles that have an area as they are given
};

/// One sentence that names what was lost and what helps; empty where nothing was.
[[nodiscard]] std::string range_warning(const RangeAudit& audit, const Format& format);

}  // namespace ti
