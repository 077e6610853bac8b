// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "accel/image.hpp"
#include "model/ist1.hpp"
#include "model/ist2.hpp"
#include "model/rd.hpp"
#include "model/work.hpp"

namespace ti::model {

/// The triangle records of an image and their test, Shevtsov's, `Local` or `Np`: `pass_a` to
/// `pass_c`.
template <class F, TestKind kTest>
class PlaneTest {
 public:
  static constexpr TestKind kKind = kTest;

  /// Without `early_exit` each test takes all passes, also when an earlier one has failed it.
  PlaneTest(const Image& image, bool early_exit)
      : planes_(image.planes()), barys_(image.barys()), early_exit_(early_exit) {}

  /// Number of records.
  [[nodiscard]] std::size_t size() const { return planes_.size(); }
  /// Number of the triangle in the mesh.
  [[nodiscard]] std::uint32_t prim(std::uint32_t record) const { return planes_[record].prim; }

  /// Nothing when the triangle is missed, or surely outside `range`.
  [[nodiscard]] std::optional<Candidate<F>> test(std::uint32_t record, const FpRay<F>& ray,
                                                 const Clipped<F>&, const TestRange<F>& range,
                                                 Work& work) const {
    const ImagePlane& plane = planes_[record];
    ++work.a_tests;
    const auto a = pass_a<kTest>(plane, ray.o, ray.d, range);
    if (a || !early_exit_) ++work.b_tests;
    const auto b = a ? pass_b(plane, barys_[record], ray.d, *a) : std::nullopt;
    if (b || !early_exit_) ++work.c_tests;
    return b ? pass_c(*b) : std::nullopt;
  }

 private:
  std::span<const ImagePlane> planes_;
  std::span<const ImageBary> barys_;
  bool early_exit_;
};

}  // namespace ti::model
