// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "base/format.hpp"
#include "model/fp_rules.hpp"
#include "scene/mesh.hpp"
#include "scene/ray.hpp"
#include "truth/impl.hpp"

namespace ti::reference {

/// The engine's test and acceptance by brute force, without a tree: every operation a double
/// rounded once to the format, in its modes.
class Engine {
 public:
  Engine(const Mesh& mesh, Format format) : format_(format), rules_(format) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      Corners tri;
      for (int k = 0; k < 3; ++k) {
        const glm::vec3 p = mesh.vertex(i, k);
        tri[static_cast<std::size_t>(k)] = {rounded(p.x), rounded(p.y), rounded(p.z)};
      }
      auto c = test_constants(tri, format);
      if (c) {
        for (double* x : {&c->nu, &c->nv, &c->e0u, &c->e0v, &c->e1u, &c->e1v}) {
          *x = round_to(format, *x);
        }
      }
      triangles_.push_back(c);
    }
  }

  struct Result {
    double t, u, v;
  };

  /// Phases (a) to (c) for one triangle; none when rejected. `ray` is in the format.
  [[nodiscard]] std::optional<Result> test(std::size_t prim, const Ray& ray) const {
    if (!triangles_[prim]) {
      return std::nullopt;
    }
    const TestConstants& c = *triangles_[prim];
    const int iu = (c.w + 1) % 3;
    const int iv = (c.w + 2) % 3;
    const double du = ray.d[iu];
    const double dv = ray.d[iv];
    const double au = fl(c.pu - ray.o[iu]);
    const double av = fl(c.pv - ray.o[iv]);
    const double aw = fl(c.pw - ray.o[c.w]);
    const double det = fl(fl(fl(c.nu * du) + fl(c.nv * dv)) + ray.d[c.w]);
    const double dett = fl(fl(fl(c.nu * au) + fl(c.nv * av)) + aw);
    if (!(det != 0.0) || std::isnan(dett) || (dett != 0.0 && (dett < 0.0) != (det < 0.0))) {
      return std::nullopt;
    }
    const double big_u = fl(fl(du * dett) - fl(au * det));
    const double big_v = fl(fl(dv * dett) - fl(av * det));
    const double detu = fl(fl(c.e1v * big_u) - fl(c.e1u * big_v));
    const double detv = fl(fl(c.e0u * big_v) - fl(c.e0v * big_u));
    const double s = det < 0.0 ? -1.0 : 1.0;
    if (!(s * detu >= 0.0 && s * detv >= 0.0 && std::abs(fl(detu + detv)) <= std::abs(det))) {
      return std::nullopt;
    }
    const double r = fl(1.0 / det);
    return Result{fl(dett * r), fl(detu * r), fl(detv * r)};
  }

  /// Closest hit; `skip` names a triangle that is left out, as a broken traversal would.
  [[nodiscard]] Hit trace(const Ray& given, std::int32_t skip = -1) const {
    const Ray ray = round_ray(given, format_);
    Hit best;
    if (!valid_ray(ray, format_)) {
      best.status = Status::InvalidRay;
      return best;
    }
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const auto result = test(i, ray);
      const auto prim = static_cast<std::int32_t>(i);
      if (!result || prim == skip || !std::isfinite(result->t)) {
        continue;
      }
      const auto t = static_cast<float>(result->t);
      const bool nearer = best.is_hit() ? t < best.t : t <= ray.tmax;
      if (t >= ray.tmin && nearer) {
        best = {t, static_cast<float>(result->u), static_cast<float>(result->v), prim, Status::Ok,
                0};
      }
    }
    if (ray.any && best.is_hit()) {
      best.t = best.u = best.v = 0.0F;
      best.prim = 0;
    }
    return best;
  }

 private:
  [[nodiscard]] double fl(double x) const {
    return format_.modes.toward_zero ? rules_.toward_zero(x, 0.0) : rules_.nearest(x);
  }
  [[nodiscard]] float rounded(float x) const { return static_cast<float>(round_to(format_, x)); }

  Format format_;
  FpRules rules_;
  std::vector<std::optional<TestConstants>> triangles_;
};

/// A closed sphere of radius 1: an octahedron, each triangle split into four `levels` times.
inline Mesh sphere(int levels) {
  Mesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& tri : mesh.triangles) {
      std::array<std::uint32_t, 3> mid{};
      for (std::size_t k = 0; k < 3; ++k) {
        const glm::vec3 a = mesh.vertices[std::min(tri[k], tri[(k + 1) % 3])];
        const glm::vec3 b = mesh.vertices[std::max(tri[k], tri[(k + 1) % 3])];
        const glm::vec3 p = a + b;
        mid[k] = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(p / std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z));
      }
      finer.push_back({tri[0], mid[0], mid[2]});
      finer.push_back({mid[0], tri[1], mid[1]});
      finer.push_back({mid[2], mid[1], tri[2]});
      finer.push_back({mid[0], mid[1], mid[2]});
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

}  // namespace ti::reference
