// SPDX-License-Identifier: Apache-2.0
#include "truth/crack_judge.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "scene/geometry.hpp"
#include "truth/impl.hpp"

namespace ti {
namespace {

/// The plane at right angles to a ray, with its origin in the middle.
struct View {
  explicit View(const Ray& ray) : o(ray.o), d(glm::normalize(glm::dvec3(ray.d))) {
    const glm::dvec3 other = std::abs(d.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    side = glm::normalize(glm::cross(d, other));
    up = glm::cross(d, side);
  }
  [[nodiscard]] glm::dvec2 operator()(const glm::dvec3& place) const {
    return {glm::dot(place - o, side), glm::dot(place - o, up)};
  }

  glm::dvec3 o, d, side, up;
};

/// Distance of the line from `a` to `b` from the middle.
double distance(const glm::dvec2& a, const glm::dvec2& b) {
  const glm::dvec2 way = b - a;
  const double length = glm::dot(way, way);
  const double at = length > 0.0 ? std::clamp(-glm::dot(a, way) / length, 0.0, 1.0) : 0.0;
  return glm::length(a + at * way);
}

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

/// Bounds of the way along the ray to a triangle where it is within `reach` of the ray.
struct Ways {
  Ways(const View& view, const std::array<glm::dvec3, 3>& corners, double reach) {
    for (const glm::dvec3& corner : corners) {
      const double way = glm::dot(corner - view.o, view.d);
      least = std::min(least, way);
      most = std::max(most, way);
    }
    const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double facing = glm::dot(normal, view.d);
    if (facing == 0.0) return;
    const double middle = glm::dot(normal, corners[0] - view.o) / facing;
    const double slope = glm::length(normal - facing * view.d) / std::abs(facing);
    least = std::max(least, middle - slope * reach);
    most = std::min(most, middle + slope * reach);
  }

  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
};

}  // namespace

CrackJudge::CrackJudge(const Mesh& mesh, const Format& format) : format_(format) {
  const Bounds bounds = bounds_of(mesh).value_or(Bounds{});
  low_ = bounds.low;
  high_ = bounds.high;
  diagonal_ = bounds.diagonal();
  join(mesh);
}

void CrackJudge::join(const Mesh& mesh) {
  const std::size_t count = mesh.triangles.size();
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> places;
  std::vector<std::uint32_t> place(mesh.vertices.size());
  std::vector<glm::dvec3> rounded(mesh.vertices.size());
  for (std::size_t i = 0; i < place.size(); ++i) {
    std::array<std::uint32_t, 3> bits{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<std::size_t>(axis);
      bits[k] = round_to_bits(format_, double{mesh.vertices[i][axis]});
      rounded[i][axis] = value_of_bits(format_, bits[k]);
      if (rounded[i][axis] == 0.0) bits[k] = 0;  // -0 is the same place
    }
    place[i] = places.try_emplace(bits, static_cast<std::uint32_t>(places.size())).first->second;
  }
  struct Edge {
    std::uint32_t from, to;  // from < to
    std::int32_t triangle;
    std::uint8_t corner;
    bool turned;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * count);
  corners_.resize(count);
  beside_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<std::uint32_t, 3> at{};
    for (std::size_t k = 0; k < 3; ++k) {
      corners_[i][k] = rounded[mesh.triangles[i][k]];
      at[k] = place[mesh.triangles[i][k]];
    }
    // Of two corners or one it is an edge, or a point, of those beside it.
    if (at[0] == at[1] || at[1] == at[2] || at[2] == at[0]) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [from, to] = std::minmax(at[k], at[(k + 1) % 3]);
      edges.push_back(
          {from, to, static_cast<std::int32_t>(i), static_cast<std::uint8_t>(k), at[k] != from});
    }
  }
  const auto ends = [](const Edge& edge) { return std::tie(edge.from, edge.to); };
  std::sort(edges.begin(), edges.end(),
            [&ends](const Edge& a, const Edge& b) { return ends(a) < ends(b); });
  for (auto first = edges.begin(); first != edges.end();) {
    const auto last =
        std::find_if(first, edges.end(), [&](const Edge& e) { return ends(e) != ends(*first); });
    if (last - first == 2) {
      const bool same_turn = first[0].turned != first[1].turned;
      const auto of = [this](const Edge& edge) -> Neighbour& {
        return beside_[static_cast<std::size_t>(edge.triangle)][edge.corner];
      };
      of(first[0]) = {first[1].triangle, same_turn};
      of(first[1]) = {first[0].triangle, same_turn};
    }
    first = last;
  }
}

double CrackJudge::farthest(const glm::dvec3& o) const {
  double farthest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    farthest =
        std::max({farthest, std::abs(low_[axis] - o[axis]), std::abs(high_[axis] - o[axis])});
  }
  return farthest;
}

double CrackJudge::behind(const Ray& ray) const {
  const double errors = 64.0 * format_.rounding_unit() * farthest(glm::dvec3(ray.o));
  return std::max(1e-3 * diagonal_, errors) / glm::length(glm::dvec3(ray.d));
}

CrackJudge::Sheet CrackJudge::sheet(const Ray& given, const ExactTracer::Hit& hit) const {
  const Ray ray = round_ray(given, format_);
  for (const std::int32_t prim : hit.prims) {
    Sheet found = sheet_from(ray, prim);
    if (!found.triangles.empty()) return found;
  }
  return {};
}

CrackJudge::Sheet CrackJudge::sheet_from(const Ray& ray, std::int32_t first) const {
  const View view(ray);
  const double reach = (9.0 * format_.rounding_unit() + 2.0 * format_.reciprocal_unit()) *
                       farthest(glm::dvec3(ray.o));
  // t comes from ways along one axis, of which d has at least 1 / sqrt(3).
  const double length = glm::length(glm::dvec3(ray.d));
  const double begin = std::max(0.0, double{ray.tmin}) * length + 2.0 * reach;
  struct Place {
    std::int32_t triangle;
    bool turned;  // against the first
  };
  std::vector<Place> open{{first, false}};
  std::vector<std::int32_t> found{first};  // ascending
  double facing = 0.0, end = 0.0;
  while (!open.empty()) {
    const Place place = open.back();
    open.pop_back();
    const auto index = static_cast<std::size_t>(place.triangle);
    const std::array<glm::dvec3, 3>& corners = corners_[index];
    const Ways ways(view, corners, reach);
    if (ways.least < begin) return {};
    end = std::max(end, ways.most);
    std::array<glm::dvec2, 3> seen;
    for (std::size_t k = 0; k < 3; ++k) seen[k] = view(corners[k]);
    const double area = (place.turned ? -1.0 : 1.0) * cross(seen[1] - seen[0], seen[2] - seen[0]);
    if (facing == 0.0) facing = area;
    if (area * facing < 0.0) return {};
    for (std::size_t k = 0; k < 3; ++k) {
      if (distance(seen[k], seen[(k + 1) % 3]) > reach) continue;
      const Neighbour& next = beside_[index][k];
      if (next.triangle == kBorder) return {};
      const auto at = std::lower_bound(found.begin(), found.end(), next.triangle);
      if (at != found.end() && *at == next.triangle) continue;
      found.insert(at, next.triangle);
      open.push_back({next.triangle, place.turned == next.same_turn});
    }
  }
  if (facing == 0.0) return {};
  return {std::move(found), (end + 2.0 * reach) / length};
}

}  // namespace ti
