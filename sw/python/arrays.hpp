// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "scene/ray.hpp"

namespace ti {

namespace nb = nanobind;
template <typename T, typename Shape>
using Array = nb::ndarray<const T, Shape, nb::c_contig, nb::device::cpu>;
using RayArray = Array<float, nb::shape<-1, 8>>;
using HitArray = Array<float, nb::shape<-1, 3>>;
using PrimArray = Array<std::int32_t, nb::shape<-1>>;

/// A numpy array that owns its data.
template <typename T>
nb::ndarray<nb::numpy, T> array_of(std::vector<T> values, std::size_t columns = 0) {
  auto* kept = new std::vector<T>(std::move(values));
  const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  if (columns == 0) return {kept->data(), {kept->size()}, owner};
  return {kept->data(), {kept->size() / columns, columns}, owner};
}

/// The same of a value of each element.
template <typename T, typename Range, typename Of>
auto array_of_each(const Range& range, Of of) {
  std::vector<T> values;
  values.reserve(range.size());
  for (const auto& element : range) values.push_back(of(element));
  return array_of(std::move(values));
}

/// Rays of an array as `rays.npy` has them.
inline std::vector<Ray> rays_of(const RayArray& array, bool any_hit = false) {
  std::vector<Ray> rays(array.shape(0));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const float* f = array.data() + 8 * i;
    rays[i] = {.o = {f[0], f[1], f[2]},
               .tmin = f[3],
               .d = {f[4], f[5], f[6]},
               .tmax = f[7],
               .any = any_hit};
  }
  return rays;
}

inline auto array_of_rays(const std::vector<Ray>& rays) {
  std::vector<float> data;
  data.reserve(8 * rays.size());
  for (const Ray& r : rays)
    data.insert(data.end(), {r.o.x, r.o.y, r.o.z, r.tmin, r.d.x, r.d.y, r.d.z, r.tmax});
  return array_of(std::move(data), 8);
}

/// t, u, v of each.
inline auto array_of_hits(const std::vector<Hit>& hits) {
  std::vector<float> data;
  data.reserve(3 * hits.size());
  for (const Hit& h : hits) data.insert(data.end(), {h.t, h.u, h.v});
  return array_of(std::move(data), 3);
}

/// What `Wave` and `Hits` have in common; `hits` gives them.
template <typename Class, typename Hits>
void bind_hits(nb::class_<Class>& bound, Hits hits) {
  bound
      .def_prop_ro(
          "hits", [hits](const Class& of) { return array_of_hits(hits(of)); }, nb::rv_policy::move,
          "float32 [N,3]: t, u, v; t is inf for a miss.")
      .def_prop_ro(
          "prims",
          [hits](const Class& of) {
            return array_of_each<std::int32_t>(hits(of), [](const Hit& h) { return h.prim; });
          },
          nb::rv_policy::move, "int32 [N]: number of the triangle in its file, -1 for a miss.")
      .def_prop_ro(
          "steps",
          [hits](const Class& of) {
            return array_of_each<std::uint16_t>(hits(of), [](const Hit& h) { return h.steps; });
          },
          nb::rv_policy::move, "uint16 [N]: nodes visited.");
}

/// `ti.Device`, `ti.Image` and `ti.Hits`.
void bind_device(nb::module_& module);

}  // namespace ti
