// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "accel/image.hpp"
#include "base/format.hpp"
#include "scene/mesh.hpp"
#include "scene/ray.hpp"

namespace ti {

/// How a hit stands against the truth.
enum class Verdict : std::uint8_t {
  Agree,        ///< same id (or both miss), t within the bound
  EmbreeWrong,  ///< exact arithmetic sides with the hit, not with Embree
  Tie,          ///< another triangle whose exact t is equal within the bound
  Edge,         ///< a hit or miss that hangs on an edge within the bound of the test
  Grazing,      ///< det within its bound of zero, or t within its bound of tmin or tmax
  Unexplained,
};

struct TruthReport {
  std::uint64_t rays = 0, agree = 0, embree_wrong = 0, tie = 0, edge = 0, grazing = 0,
                unexplained = 0;
  std::uint64_t unjudged = 0;         ///< of all these, left out by the limit of `Truth`
  std::vector<std::string> examples;  ///< up to 8 unexplained rays, one paste-able line each

  /// Those of other rays behind these.
  TruthReport& operator+=(const TruthReport& other);
};

/// What is right: Embree away from edges, exact rational arithmetic where the two disagree.
///
/// Holds an Embree scene of `mesh` (with the triangles that the builder keeps). Thread-compatible.
class Truth {
 public:
  /// A ray on which Embree and the engine disagree, and a ray that Embree does not take, may have
  /// to be tested against every triangle. As many tests as this are made, in the order of the rays;
  /// one takes 10 to 100 ns, so these come to minutes.
  static constexpr std::uint64_t kLooks = std::uint64_t{1} << 32;

  /// `device` configures Embree (`EmbreeScene`), `test` says whose bounds hits are held to.
  Truth(const Mesh& mesh, Format format, const std::string& device = "",
        std::uint64_t looks = kLooks, TestKind test = TestKind::Local);
  ~Truth();
  Truth(const Truth&) = delete;
  Truth& operator=(const Truth&) = delete;

  /// Embree's closest hits (any-hit rays: t = u = v = 0, prim 0 on a hit), in the order of `rays`.
  /// Throws `Error` when too many of them are rays that Embree does not take.
  [[nodiscard]] std::vector<Hit> trace(std::span<const Ray> rays) const;

  /// Judges `hit` for `ray`; `embree` is Embree's answer for it.
  [[nodiscard]] Verdict judge(const Ray& ray, const Hit& hit, const Hit& embree) const;

  /// Traces and judges all rays; hits whose status is not Ok must be misses. Disagreements beyond
  /// the limit are counted as unjudged, whatever the threads do.
  [[nodiscard]] TruthReport compare(std::span<const Ray> rays, std::span<const Hit> hits) const;

  /// Exact closest hit by brute force over all triangles with rational arithmetic: every id of
  /// least t.
  struct ExactHit {
    bool hit = false;
    std::vector<std::int32_t> prims;  ///< ascending
    double t = 0.0;                   ///< exact t rounded to double
    bool on_boundary = false;         ///< some id of `prims` is hit on its edge or vertex
  };
  [[nodiscard]] ExactHit exact(const Ray& ray) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ti
