// SPDX-License-Identifier: Apache-2.0
#include "truth/truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <map>
#include <mutex>
#include <thread>

#include "base/error.hpp"
#include "truth/impl.hpp"

namespace ti {
namespace {

float rounded(float x, Format format) { return static_cast<float>(round_to(format, x)); }

glm::vec3 rounded(const glm::vec3& p, Format format) {
  return {rounded(p.x, format), rounded(p.y, format), rounded(p.z, format)};
}

/// Calls `work(first, last)` on pieces of [0, count) from all hardware threads; `work` must not
/// throw.
template <typename Work>
void parallel_pieces(std::size_t count, std::size_t piece, const Work& work) {
  std::atomic<std::size_t> next{0};
  const auto loop = [&] {
    for (std::size_t first = next.fetch_add(piece); first < count; first = next.fetch_add(piece)) {
      work(first, std::min(first + piece, count));
    }
  };
  std::vector<std::jthread> others;
  const std::size_t threads =
      std::min<std::size_t>(std::thread::hardware_concurrency(), (count + piece - 1) / piece);
  for (std::size_t i = 1; i < threads; ++i) {
    others.emplace_back(loop);
  }
  loop();
}

std::string hex(float x) { return fmt::format("\"{:08X}\"", std::bit_cast<std::uint32_t>(x)); }

std::string hex(const glm::vec3& p) {
  return fmt::format("[{}, {}, {}]", hex(p.x), hex(p.y), hex(p.z));
}

std::string paste_line(std::size_t index, const Ray& ray, const Hit& hit, const Hit& embree) {
  return fmt::format(
      R"({{"ray": {}, "o": {}, "d": {}, "tmin": {}, "tmax": {}, "any": {}, "got": [{}, {}], "embree": [{}, {}]}})",
      index, hex(ray.o), hex(ray.d), hex(ray.tmin), hex(ray.tmax), ray.any, hit.prim, hex(hit.t),
      embree.prim, hex(embree.t));
}

void count(TruthReport& report, Verdict verdict) {
  switch (verdict) {
    case Verdict::Agree:
      ++report.agree;
      break;
    case Verdict::EmbreeWrong:
      ++report.embree_wrong;
      break;
    case Verdict::Tie:
      ++report.tie;
      break;
    case Verdict::Edge:
      ++report.edge;
      break;
    case Verdict::Grazing:
      ++report.grazing;
      break;
    case Verdict::Unexplained:
      ++report.unexplained;
      break;
  }
}

}  // namespace

Ray round_ray(const Ray& ray, Format format) {
  return {rounded(ray.o, format), rounded(ray.tmin, format), rounded(ray.d, format),
          rounded(ray.tmax, format), ray.any};
}

bool valid_ray(const Ray& ray, Format format) {
  bool some_axis = false;
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(ray.o[k]) || !std::isfinite(ray.d[k])) {
      return false;
    }
    some_axis = some_axis || std::isfinite(round_to(format, 1.0 / double{ray.d[k]}));
  }
  return some_axis && !std::isnan(ray.tmin) && !std::isnan(ray.tmax);
}

Truth::Impl::Impl(const Mesh& mesh, Format number_format, const std::string& device)
    : format(number_format),
      ops(number_format),
      corners(mesh.triangles),
      place(mesh.triangles.size(), -1) {
  vertices.reserve(mesh.vertices.size());
  for (const glm::vec3& p : mesh.vertices) {
    vertices.push_back(rounded(p, format));
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (const std::uint32_t vertex : corners[i]) {
      if (vertex >= vertices.size()) {
        throw Error(fmt::format("Triangle {} names vertex {}, but the mesh has only {} vertices.",
                                i, vertex, vertices.size()));
      }
    }
  }
  std::map<std::array<float, 9>, std::int32_t> first_of;
  std::vector<std::array<std::uint32_t, 3>> kept;
  std::vector<std::int32_t> prims;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto prim = static_cast<std::int32_t>(i);
    const Corners tri = corners_of(prim);
    const auto constants = test_constants(tri, format);
    if (!constants) {
      continue;
    }
    std::array<float, 9> key{};
    for (std::size_t k = 0; k < 9; ++k) {
      key[k] = tri[k / 3][static_cast<int>(k % 3)];
    }
    const bool twin = !first_of.emplace(key, prim).second;
    place[i] = static_cast<std::int32_t>(triangles.size());
    triangles.push_back({*constants, prim, twin});
    kept.push_back(corners[i]);
    prims.push_back(prim);
  }
  embree = std::make_unique<EmbreeScene>(vertices, kept, std::move(prims), device);
}

Corners Truth::Impl::corners_of(std::int32_t prim) const {
  const auto& tri = corners[static_cast<std::size_t>(prim)];
  return {vertices[tri[0]], vertices[tri[1]], vertices[tri[2]]};
}

const TruthTriangle* Truth::Impl::find(std::int32_t prim) const {
  if (prim < 0 || static_cast<std::size_t>(prim) >= place.size()) {
    return nullptr;
  }
  const std::int32_t at = place[static_cast<std::size_t>(prim)];
  return at < 0 ? nullptr : &triangles[static_cast<std::size_t>(at)];
}

std::vector<std::size_t> Truth::Impl::candidates(const Ray& ray) const {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (may_meet(ops, triangles[i].constants, ray)) {
      found.push_back(i);
    }
  }
  return found;
}

Hit Truth::Impl::trace(const Ray& ray) const {
  Hit result;
  if (!valid_ray(ray, format)) {
    result.status = Status::InvalidRay;
    return result;
  }
  if (EmbreeScene::takes(ray)) {
    return embree->trace(ray);
  }
  const ExactHit best = exact(ray);
  if (best.hit && ray.any) {
    result.t = 0.0F;
    result.prim = 0;
  } else if (best.hit) {
    const std::int32_t prim = best.prims.front();
    const TestBand band = test_band(ops, find(prim)->constants, ray);
    result = {static_cast<float>(best.t),
              static_cast<float>(band.u.v),
              static_cast<float>(band.v.v),
              prim,
              Status::Ok,
              0};
  }
  return result;
}

Truth::Truth(const Mesh& mesh, Format format, const std::string& device)
    : impl_(std::make_unique<Impl>(mesh, format, device)) {}

Truth::~Truth() = default;

std::vector<Hit> Truth::trace(std::span<const Ray> rays) const {
  std::vector<Hit> hits(rays.size());
  parallel_pieces(rays.size(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      hits[i] = impl_->trace(round_ray(rays[i], impl_->format));
    }
  });
  return hits;
}

Verdict Truth::judge(const Ray& ray, const Hit& hit, const Hit& embree) const {
  return impl_->judge(round_ray(ray, impl_->format), hit, embree);
}

TruthReport Truth::compare(std::span<const Ray> rays, std::span<const Hit> hits) const {
  TruthReport report;
  report.rays = rays.size();
  std::mutex mutex;
  std::map<std::size_t, std::string> examples;  // the first ones whatever the threads do
  parallel_pieces(std::min(rays.size(), hits.size()), 512,
                  [&](std::size_t first, std::size_t last) {
                    TruthReport part;
                    std::map<std::size_t, std::string> lines;
                    for (std::size_t i = first; i < last; ++i) {
                      const Ray ray = round_ray(rays[i], impl_->format);
                      const Hit embree = impl_->trace(ray);
                      const Verdict verdict = impl_->judge(ray, hits[i], embree);
                      count(part, verdict);
                      if (verdict == Verdict::Unexplained && lines.size() < 8) {
                        lines.emplace(i, paste_line(i, rays[i], hits[i], embree));
                      }
                    }
                    const std::lock_guard lock(mutex);
                    report.agree += part.agree;
                    report.embree_wrong += part.embree_wrong;
                    report.tie += part.tie;
                    report.edge += part.edge;
                    report.grazing += part.grazing;
                    report.unexplained += part.unexplained;
                    examples.merge(lines);
                  });
  if (hits.size() < rays.size()) {
    report.unexplained += rays.size() - hits.size();  // rays without an answer
  }
  for (const auto& [index, line] : examples) {
    if (report.examples.size() < 8) {
      report.examples.push_back(line);
    }
  }
  return report;
}

TruthReport& TruthReport::operator+=(const TruthReport& other) {
  rays += other.rays;
  agree += other.agree;
  embree_wrong += other.embree_wrong;
  tie += other.tie;
  edge += other.edge;
  grazing += other.grazing;
  unexplained += other.unexplained;
  for (const std::string& example : other.examples)
    if (examples.size() < 8) examples.push_back(example);
  return *this;
}

}  // namespace ti
