// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "accel/image.hpp"

namespace ti {

/// What is damaged in a memory image.
enum class ImageFault : std::uint8_t {
  NodeBit,       ///< a bit of a node flips
  NodeWord,      ///< a word of a node becomes any other
  Loop,          ///< a child of an inner node is the node itself or one before it
  Beyond,        ///< a child, a leaf's first entry or its count lies far away
  ListBit,       ///< a bit of a list entry
  ListWord,      ///< a list entry becomes any number
  TriangleBit,   ///< a bit of a triangle record
  TriangleWord,  ///< a word of one
  Line,          ///< 64 bytes anywhere behind the header become any others
  Header,        ///< a bit of the header or of the table of sections; the checksum is right again
};
constexpr std::size_t kImageFaults = 10;
constexpr std::array<const char*, kImageFaults> kImageFaultNames{
    "node bit",  "node word",    "loop",          "beyond", "list bit",
    "list word", "triangle bit", "triangle word", "line",   "header"};

/// The bytes of `image` with one fault of a kind, chosen by `seed`: the same on every machine.
[[nodiscard]] std::vector<std::uint8_t> damaged(const Image& image, ImageFault fault,
                                                std::uint64_t seed);

/// The leaves that no ray may test and be none the wiser: of too many entries, of some beyond the
/// list, of one that names no triangle.
///
/// Written from `docs/memory-image.md`, beside the model.
[[nodiscard]] std::set<std::uint32_t> unsound_leaves(const Image& image);

}  // namespace ti
