// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "accel/image.hpp"
#include "base/config_keys.hpp"
#include "model/work.hpp"
#include "scene/ray.hpp"

namespace ti {

/// A hit as the bits of the number format, for comparison in lock-step.
struct HitBits {
  std::uint32_t t = 0, u = 0, v = 0;
  std::int32_t prim = -1;
  Status status = Status::Ok;
  std::uint16_t steps = 0;

  bool operator==(const HitBits&) const = default;
};

/// The bit-exact model of the engine: what the hardware must answer, ray by ray.
class Tracer {
 public:
  struct Options {
    int stack_depth = 4;
    int watchdog_steps = 65535;
    bool interval_cull = true;  ///< whether a leaf's tests count only within its interval
    int interval_guard = 4;     ///< units in the last place by which it grows at each end
    bool early_exit = true;     ///< whether a test ends with the pass that it fails
    bool restart = true;        ///< whether a ray whose stack has overflowed goes back to the root
    Traversal traversal = Traversal::kPlain;
    bool any_hit = true;  ///< whether an any-hit ray is traced; when not, it is invalid
  };

  /// Traces on `image`, which must outlive the tracer. Formats in `formats` of
  /// configs/schema.yaml are compiled; others take some times as long. Throws `Error` for a stack
  /// that it has no room for, and for a tree whose walks may overflow the stack where no ray
  /// restarts.
  [[nodiscard]] static std::unique_ptr<Tracer> create(const Image& image, const Options& options);
  virtual ~Tracer() = default;

  /// One ray; adds to `work`. With `log`, hands one line a node visited to it (see
  /// `docs/step-log.md`). Safe to call from several threads.
  using Log = StepLog;
  [[nodiscard]] virtual HitBits trace(const Ray& ray, Work& work,
                                      const Log* log = nullptr) const = 0;

  /// All rays on all processors, in the order of `rays`.
  [[nodiscard]] std::vector<HitBits> trace(std::span<const Ray> rays, Work& work) const;
};

/// `bits` of `format` as a hit in binary32; exact, as every format fits in it.
[[nodiscard]] Hit hit_of(Format format, const HitBits& bits);

}  // namespace ti
