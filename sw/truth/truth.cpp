// SPDX-License-Identifier: Apache-2.0
#include "truth/truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <map>
#include <mutex>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "truth/impl.hpp"

namespace ti {
namespace {

float rounded(float x, Format format) { return static_cast<float>(round_to(format, x)); }

glm::vec3 rounded(const glm::vec3& p, Format format) {
  return {rounded(p.x, format), rounded(p.y, format), rounded(p.z, format)};
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

/// Counts verdicts; the examples are those of the first rays, whatever the threads do.
class Tally {
 public:
  Tally(std::span<const Ray> rays, std::span<const Hit> hits) : rays_(rays), hits_(hits) {}

  void add(std::size_t index, Verdict verdict, const Hit& embree) {
    ++count_[static_cast<std::size_t>(verdict)];
    if (verdict == Verdict::Unexplained) {
      lines_.emplace(index, paste_line(index, rays_[index], hits_[index], embree));
      if (lines_.size() > kExamples) lines_.erase(std::prev(lines_.end()));
    }
  }

  void add(Tally& part) {
    for (std::size_t i = 0; i < count_.size(); ++i) count_[i] += part.count_[i];
    lines_.merge(part.lines_);
    while (lines_.size() > kExamples) lines_.erase(std::prev(lines_.end()));
  }

  [[nodiscard]] TruthReport report(std::size_t unjudged) const {
    const auto of = [this](Verdict verdict) { return count_[static_cast<std::size_t>(verdict)]; };
    TruthReport report{.rays = rays_.size(),
                       .agree = of(Verdict::Agree),
                       .embree_wrong = of(Verdict::EmbreeWrong),
                       .tie = of(Verdict::Tie),
                       .edge = of(Verdict::Edge),
                       .grazing = of(Verdict::Grazing),
                       .unexplained = of(Verdict::Unexplained),
                       .unjudged = unjudged,
                       .examples = {}};
    if (hits_.size() < rays_.size()) {
      report.unexplained += rays_.size() - hits_.size();  // rays without an answer
    }
    for (const auto& [index, line] : lines_) report.examples.push_back(line);
    return report;
  }

 private:
  static constexpr std::size_t kExamples = 8;

  std::span<const Ray> rays_;
  std::span<const Hit> hits_;
  std::array<std::uint64_t, 6> count_{};
  std::map<std::size_t, std::string> lines_;
};

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
    // Toward zero only 1/0 is infinite.
    some_axis = some_axis || (format.modes.toward_zero
                                  ? ray.d[k] != 0.0F
                                  : std::isfinite(round_to(format, 1.0 / double{ray.d[k]})));
  }
  return some_axis && !std::isnan(ray.tmin) && !std::isnan(ray.tmax);
}

Truth::Impl::Impl(const Mesh& mesh, Format number_format, const std::string& device,
                  std::uint64_t most_looks, TestKind test)
    : format(number_format),
      looks(most_looks),
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
    const auto constants = test_constants(tri, format, test);
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

Truth::Truth(const Mesh& mesh, Format format, const std::string& device, std::uint64_t looks,
             TestKind test)
    : impl_(std::make_unique<Impl>(mesh, format, device, looks, test)) {}

Truth::~Truth() = default;

std::vector<Hit> Truth::trace(std::span<const Ray> rays) const {
  const auto slow =
      static_cast<std::size_t>(std::count_if(rays.begin(), rays.end(), [this](const Ray& ray) {
        const Ray given = round_ray(ray, impl_->format);
        return valid_ray(given, impl_->format) && !EmbreeScene::takes(given);
      }));
  if (slow > impl_->most_searches()) {
    throw Error(
        fmt::format("{} rays have a component beyond 1.844e18, which Embree does not take, and "
                    "exact arithmetic "
                    "has time for {} of them on {} triangles; scale the scene or the rays down",
                    slow, impl_->most_searches(), impl_->triangles.size()));
  }
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
  Tally tally(rays, hits);
  std::vector<std::size_t> open;  // rays that take a look at every triangle
  std::mutex mutex;
  parallel_pieces(std::min(rays.size(), hits.size()), 512,
                  [&](std::size_t first, std::size_t last) {
                    Tally part(rays, hits);
                    std::vector<std::size_t> left;
                    for (std::size_t i = first; i < last; ++i) {
                      const Ray ray = round_ray(rays[i], impl_->format);
                      if (valid_ray(ray, impl_->format) && !EmbreeScene::takes(ray)) {
                        left.push_back(i);
                        continue;
                      }
                      const Hit embree = impl_->trace(ray);
                      const auto verdict = impl_->judge_quickly(ray, hits[i], embree);
                      verdict ? part.add(i, *verdict, embree) : left.push_back(i);
                    }
                    const std::lock_guard lock(mutex);
                    tally.add(part);
                    open.insert(open.end(), left.begin(), left.end());
                  });
  std::sort(open.begin(), open.end());
  const std::size_t judged = std::min(open.size(), impl_->most_searches());
  parallel_pieces(judged, 8, [&](std::size_t first, std::size_t last) {
    Tally part(rays, hits);
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = open[k];
      const Ray ray = round_ray(rays[i], impl_->format);
      const Hit embree = impl_->trace(ray);
      part.add(i, impl_->judge(ray, hits[i], embree), embree);
    }
    const std::lock_guard lock(mutex);
    tally.add(part);
  });
  return tally.report(open.size() - judged);
}

TruthReport& TruthReport::operator+=(const TruthReport& other) {
  rays += other.rays;
  agree += other.agree;
  embree_wrong += other.embree_wrong;
  tie += other.tie;
  edge += other.edge;
  grazing += other.grazing;
  unexplained += other.unexplained;
  unjudged += other.unjudged;
  for (const std::string& example : other.examples)
    if (examples.size() < 8) examples.push_back(example);
  return *this;
}

}  // namespace ti
