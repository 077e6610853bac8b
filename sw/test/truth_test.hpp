// SPDX-License-Identifier: Apache-2.0
//
// What the tests of the truth have in common.
#pragma once

#include <limits>
#include <span>

#include "truth/truth.hpp"

namespace ti::test {

constexpr Format kF32{8, 23};
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Two parallel squares of two triangles each, at z = 1 (0, 1) and z = 2 (2, 3).
inline Mesh two_squares() {
  Mesh mesh;
  for (const float z : {1.0F, 2.0F}) {
    const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{0, 0, z}, {2, 0, z}, {2, 2, z}, {0, 2, z}});
    mesh.triangles.push_back({n, n + 1, n + 2});
    mesh.triangles.push_back({n, n + 2, n + 3});
  }
  return mesh;
}

inline Ray up(float x, float y) { return {{x, y, 0}, 0.0F, {0, 0, 1}, kInf, false}; }

inline Verdict judge(const Truth& truth, const Ray& ray, const Hit& hit) {
  return truth.judge(ray, hit, truth.trace(std::span(&ray, 1)).front());
}

}  // namespace ti::test
