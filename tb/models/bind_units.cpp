// SPDX-License-Identifier: Apache-2.0

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <array>
#include <cstdint>
#include <optional>
#include <tuple>

#include "bind.hpp"
#include "formats.hpp"
#include "model/ist1.hpp"
#include "model/ist2.hpp"
#include "model/rd.hpp"
#include "model/trv.hpp"
#include "model/woop_test.hpp"

namespace ti {
namespace {

namespace nb = nanobind;
using Bits = std::uint32_t;
using Bits3 = std::array<Bits, 3>;
using Bits4 = std::tuple<Bits, Bits, Bits, Bits>;
using Plane = std::array<Bits, 8>;  ///< words of `ImagePlane` in memory order
using Bary = std::array<Bits, 4>;   ///< words of `ImageBary` in memory order

template <class F>
Vec3<F> vec(const Bits3& bits) {
  return {F::from_bits(bits[0]), F::from_bits(bits[1]), F::from_bits(bits[2])};
}

ImagePlane plane_of(const Plane& w) { return {w[0], w[1], w[2], w[3], w[4], w[5], w[6], w[7]}; }

template <typename F>
Bits3 bits_of(const Vec3<F>& v) {
  return {v[0].bits(), v[1].bits(), v[2].bits()};
}

std::tuple<bool, int, Bits3, Bits, Bits> clip_ray(const Format& format, const Bits3& lo,
                                                  const Bits3& hi, const Bits3& o, const Bits3& d,
                                                  Bits tmin, Bits tmax, bool padded) {
  return in_format<UnitFormats>(format, [&]<typename F>() {
    const model::FpRay<F> ray{vec<F>(o), vec<F>(d), F::from_bits(tmin), F::from_bits(tmax)};
    const model::Box<F> box{vec<F>(lo), vec<F>(hi)};
    const auto origins =
        padded ? model::thick_origins(box, ray.o, ray.d) : model::Origins<F>{ray.o, ray.o};
    const auto c = model::clip(box, ray, origins);
    return std::tuple{c.miss, static_cast<int>(c.status), bits_of(c.inv), c.tmin.bits(),
                      c.tmax.bits()};
  });
}

std::tuple<Bits3, Bits3> thick_origins(const Format& format, const Bits3& lo, const Bits3& hi,
                                       const Bits3& o, const Bits3& d) {
  return in_format<UnitFormats>(format, [&]<typename F>() {
    const auto origins =
        model::thick_origins(model::Box<F>{vec<F>(lo), vec<F>(hi)}, vec<F>(o), vec<F>(d));
    return std::tuple{bits_of(origins.least), bits_of(origins.most)};
  });
}

std::tuple<int, Bits3> shear(const Format& format, const Bits3& d, const Bits3& inv) {
  return in_format<UnitFormats>(format, [&]<typename F>() {
    const auto made = model::shear_of(vec<F>(d), vec<F>(inv));
    return std::tuple{static_cast<int>(made.z), bits_of(Vec3<F>{made.sx, made.sy, made.sz})};
  });
}

std::optional<std::tuple<Bits3, Bits3>> edge_functions(const Format& format,
                                                       const std::array<Bits3, 3>& corners,
                                                       const Bits3& o, int z, const Bits3& shear) {
  using Result = std::optional<std::tuple<Bits3, Bits3>>;
  return in_format<UnitFormats>(format, [&]<typename F>() -> Result {
    const auto [sx, sy, sz] = vec<F>(shear);
    const auto edges =
        model::edge_functions<F>({vec<F>(corners[0]), vec<F>(corners[1]), vec<F>(corners[2])},
                                 vec<F>(o), {static_cast<std::size_t>(z), sx, sy, sz});
    if (!edges) return std::nullopt;
    return std::tuple{bits_of(edges->weight), bits_of(edges->z)};
  });
}

std::tuple<Bits, Bits, Bits> woop_level(const Format& format, const Bits3& weight) {
  return in_format<UnitFormats>(format, [&]<typename F>() {
    const auto w = model::level(vec<F>(weight));
    return std::tuple{w[0].bits(), w[1].bits(), w[2].bits()};
  });
}

std::optional<std::tuple<Bits, Bits, Bits>> woop_pass_c(const Format& format, const Bits3& weight,
                                                        const Bits3& z, Bits sz) {
  using Result = std::optional<std::tuple<Bits, Bits, Bits>>;
  return in_format<UnitFormats>(format, [&]<typename F>() -> Result {
    const auto c = model::pass_c(model::Edges<F>{vec<F>(weight), vec<F>(z)}, F::from_bits(sz));
    if (!c) return std::nullopt;
    return std::tuple{c->t.bits(), c->u.bits(), c->v.bits()};
  });
}

Bits split_distance(const Format& format, Bits value, Bits link, const Bits3& o, const Bits3& inv) {
  return in_format<UnitFormats>(format, [&]<typename F>() {
    return model::split_distance(ImageNode{value, link}, vec<F>(o), vec<F>(inv)).bits();
  });
}

int choose(const Format& format, Bits t, Bits tmin, Bits tmax) {
  return in_format<UnitFormats>(format, [&]<typename F>() {
    return static_cast<int>(model::choose(F::from_bits(t), F::from_bits(tmin), F::from_bits(tmax)));
  });
}

std::tuple<Bits, Bits> ordered(Bits link, Bits index, bool negative) {
  const auto children = model::ordered(ImageNode{0, link}, index, negative);
  return {children.near, children.far};
}

std::optional<Bits4> pass_a(const Format& format, const Plane& plane, const Bits3& o,
                            const Bits3& d, Bits tnear, Bits tfar, bool as_published) {
  return in_format<UnitFormats>(format, [&]<typename F>() -> std::optional<Bits4> {
    const model::TestRange<F> range{F::from_bits(tnear), F::from_bits(tfar)};
    const auto a =
        as_published ? model::pass_a<TestKind::Np>(plane_of(plane), vec<F>(o), vec<F>(d), range)
                     : model::pass_a<TestKind::Local>(plane_of(plane), vec<F>(o), vec<F>(d), range);
    if (!a) return std::nullopt;
    return Bits4{a->det.bits(), a->dett.bits(), a->audet.bits(), a->av.bits()};
  });
}

std::optional<Bits4> pass_b(const Format& format, const Plane& plane, const Bary& bary,
                            const Bits3& d, const Bits4& after_a) {
  return in_format<UnitFormats>(format, [&]<typename F>() -> std::optional<Bits4> {
    const auto [det, dett, audet, av] = after_a;
    const model::AfterA<F> a{F::from_bits(det), F::from_bits(dett), F::from_bits(audet),
                             F::from_bits(av)};
    const ImageBary parts{bary[0], bary[1], bary[2], bary[3]};
    const auto b = model::pass_b(plane_of(plane), parts, vec<F>(d), a);
    if (!b) return std::nullopt;
    return Bits4{b->det.bits(), b->dett.bits(), b->detu.bits(), b->detv.bits()};
  });
}

std::optional<std::tuple<Bits, Bits, Bits>> pass_c(const Format& format, const Bits4& after_b) {
  using Result = std::optional<std::tuple<Bits, Bits, Bits>>;
  return in_format<UnitFormats>(format, [&]<typename F>() -> Result {
    const auto [det, dett, detu, detv] = after_b;
    const auto c = model::pass_c(model::AfterB<F>{F::from_bits(det), F::from_bits(dett),
                                                  F::from_bits(detu), F::from_bits(detv)});
    if (!c) return std::nullopt;
    return std::tuple{c->t.bits(), c->u.bits(), c->v.bits()};
  });
}

}  // namespace

void bind_units(nb::module_& module) {
  module.def("clip", &clip_ray, nb::arg("format"), nb::arg("box_lo"), nb::arg("box_hi"),
             nb::arg("o"), nb::arg("d"), nb::arg("tmin"), nb::arg("tmax"),
             nb::arg("padded") = false, "Set-up of a ray: (miss, status, inv, tmin, tmax).");
  module.def("thick_origins", &thick_origins, nb::arg("format"), nb::arg("box_lo"),
             nb::arg("box_hi"), nb::arg("o"), nb::arg("d"),
             "(least, most): the origins of a thick ray.");
  module.def("shear", &shear, nb::arg("format"), nb::arg("d"), nb::arg("inv"),
             "(z, (sx, sy, sz)) of Woop's test.");
  module.def("edge_functions", &edge_functions, nb::arg("format"), nb::arg("corners"), nb::arg("o"),
             nb::arg("z"), nb::arg("shear"),
             "(weights, ways along z) of the corners, or None when the ray passes outside.");
  module.def("woop_level", &woop_level, nb::arg("format"), nb::arg("weight"),
             "The weights, the largest brought to [2, 4).");
  module.def("woop_pass_c", &woop_pass_c, nb::arg("format"), nb::arg("weight"), nb::arg("z"),
             nb::arg("sz"), "(t, u, v), or None when t is not finite or less than 0.");
  module.def("split_distance", &split_distance, nb::arg("format"), nb::arg("value"),
             nb::arg("link"), nb::arg("o"), nb::arg("inv"));
  module.def("choose", &choose, nb::arg("format"), nb::arg("t"), nb::arg("tmin"), nb::arg("tmax"),
             "0: near only, 1: far only, 2: both.");
  module.def("ordered", &ordered, nb::arg("link"), nb::arg("index"), nb::arg("negative"),
             "(near, far) of the inner node at `index`.");
  module.def("pass_a", &pass_a, nb::arg("format"), nb::arg("plane"), nb::arg("o"), nb::arg("d"),
             nb::arg("tnear"), nb::arg("tfar"), nb::arg("as_published") = false,
             "(det, dett, audet, av), or None when the test is over.");
  module.def("pass_b", &pass_b, nb::arg("format"), nb::arg("plane"), nb::arg("bary"), nb::arg("d"),
             nb::arg("after_a"), "(det, dett, detu, detv), or None when the test is over.");
  module.def("pass_c", &pass_c, nb::arg("format"), nb::arg("after_b"),
             "(t, u, v), or None when t is not finite.");
}

}  // namespace ti
