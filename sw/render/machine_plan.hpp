// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "accel/tree_bounds.hpp"
#include "base/config.hpp"
#include "engine/engine.hpp"
#include "render/plan.hpp"

namespace ti {

/// What the machine's decisions look at of a scene, beside its plan.
struct MachineFacts {
  std::optional<TreeBounds> bounds;  ///< none of an image whose nodes share children
  ImageParts parts{};                ///< of its memory image
  int scale = 0;                     ///< of the image
  double extent = 0.0;               ///< largest |coordinate| of the scene box, in scene units
  MemoryKind memory = MemoryKind::Fixed;
  int memory_latency = 100;
  double memory_bytes_per_cycle = 64.0;
};
[[nodiscard]] MachineFacts machine_facts(const Image& image, const RtlOptions& memory);

/// Whether a part of the machine is needed, and what is taken for it.
struct MachineDecision {
  static constexpr const char* kExact = "no hit and no cycle differs";

  std::string what;
  bool on = false;           ///< the machine has it
  std::string set{};         ///< keys other than the base's, as `SET=` has them
  std::string reason{};      ///< the end of a sentence
  std::string bound{};       ///< what it does to picture and cycles
  std::uint64_t cycles = 0;  ///< more than the base takes, at most
};

/// The machine that a picture calls for, on the ground of another: no hit differs.
struct MachinePlan {
  std::vector<MachineDecision> decisions;

  /// All keys of the decisions, as `SET=` has them.
  [[nodiscard]] std::string set() const;
};

/// The first effect of a plan whose rays may end at any hit.
[[nodiscard]] std::optional<Effect> any_hit_effect(const Plan& plan);

/// A pure function of what it is given. The keys that it takes are of the RTL: the tree stays.
[[nodiscard]] MachinePlan make_machine_plan(const MachineFacts& facts, const Plan& plan,
                                            const Config& base);

}  // namespace ti
