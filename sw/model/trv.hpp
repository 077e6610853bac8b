// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "accel/image.hpp"
#include "base/vec.hpp"

namespace ti::model {

/// t at which a ray crosses the split plane; NaN exactly when it is parallel to the plane and in
/// it.
///
/// Bit-exact model of `ti_kd_step`.
template <class F>
[[nodiscard]] F split_distance(const ImageNode& node, const Vec3<F>& o, const Vec3<F>& inv) {
  return (F::from_bits(node.value) - o[node.axis()]) * inv[node.axis()];
}

/// Which children a ray visits.
enum class Side : std::uint8_t { Near, Far, Both };
[[nodiscard]] inline const char* name(Side side) {
  return side == Side::Near ? "near" : side == Side::Far ? "far" : "both";
}

/// The three-way choice: near only when not t < tmax, else far only when t <= tmin, else both.
template <class F>
[[nodiscard]] Side choose(F t, F tmin, F tmax) {
  if (!(t < tmax)) return Side::Near;
  return t <= tmin ? Side::Far : Side::Both;
}

/// Where a thick ray crosses the split plane: at no rounding before `least` nor after `most`.
template <class F>
struct Crossing {
  F least, most;
};

/// The choice of a thick ray, whose intervals in the two children overlap: near only when least >=
/// tmax, else far only when most <= tmin, else both. A crossing that is NaN, of a ray parallel to
/// the plane whose thickness just reaches it, is both.
template <class F>
[[nodiscard]] Side choose(const Crossing<F>& crossing, F tmin, F tmax) {
  if (tmax <= crossing.least) return Side::Near;
  return crossing.most <= tmin ? Side::Far : Side::Both;
}

/// The children in the order of the ray: near is the adjacent one exactly when sign XNOR reorder
/// flag.
struct Children {
  std::uint32_t near, far;
};
[[nodiscard]] inline Children ordered(const ImageNode& node, std::uint32_t index, bool negative) {
  const std::uint32_t adjacent = index + 1;
  if (negative == node.reorder()) return {adjacent, node.other()};
  return {node.other(), adjacent};
}

/// Deepest short stack that an engine can have; `configs/` stays within it.
constexpr int kMaxStackDepth = 64;

/// The newest `depth` entries; pushing on a full stack drops the oldest and remembers that it did.
template <class F>
class ShortStack {
 public:
  struct Entry {
    std::uint32_t node;
    F tmin;  ///< of the walk of a thick ray alone
    F tmax;
  };

  /// `depth` from 0, which keeps nothing, to `kMaxStackDepth`.
  explicit ShortStack(std::size_t depth) : depth_(depth) {}

  /// The entry that is dropped, if one is.
  std::optional<Entry> push(const Entry& entry) {
    std::optional<Entry> oldest;
    dropped_ = dropped_ || count_ == depth_;
    if (depth_ == 0) return entry;
    if (count_ == depth_) {
      oldest = entries_[top_];
    } else {
      ++count_;
    }
    entries_[top_] = entry;
    top_ = top_ + 1 == depth_ ? 0 : top_ + 1;
    return oldest;
  }
  [[nodiscard]] const Entry& top() const { return entries_[below()]; }
  Entry pop() {
    top_ = below();
    --count_;
    return entries_[top_];
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] bool dropped() const { return dropped_; }
  void forget_dropped() { dropped_ = false; }

 private:
  [[nodiscard]] std::size_t below() const { return top_ == 0 ? depth_ - 1 : top_ - 1; }

  std::array<Entry, kMaxStackDepth> entries_;  // a ring; the next entry goes to `top_`
  std::size_t depth_;
  std::size_t top_ = 0;
  std::size_t count_ = 0;
  bool dropped_ = false;
};

}  // namespace ti::model
