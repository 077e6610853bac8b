// SPDX-License-Identifier: Apache-2.0

#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "accel/tree_bounds.hpp"
#include "bind.hpp"
#include "model/tracer.hpp"

namespace ti {
namespace {

namespace nb = nanobind;
using Corner = std::array<float, 3>;
using Triangle = std::array<Corner, 3>;

/// The one of `names` that is `name`, as a number.
std::size_t number_of(std::span<const char* const> names, const std::string& name) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (name == names[i]) return i;
  }
  throw nb::value_error(("no value " + name).c_str());
}

TestKind test_of(const std::string& name) {
  return test_kind(static_cast<TriangleTest>(number_of(kTriangleTestNames, name)));
}

/// The image of triangles that share no vertex; triangle i is primitive i.
std::unique_ptr<Image> build(const Format& format, const std::vector<Triangle>& triangles,
                             const std::string& test) {
  Mesh mesh;
  for (const Triangle& triangle : triangles) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Corner& c : triangle) mesh.vertices.emplace_back(c[0], c[1], c[2]);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  BuildOptions options;
  options.format = format;
  options.test = test_of(test);
  BuildStats stats;
  return std::make_unique<Image>(build_image(mesh, options, stats));
}

/// What a ray did, beside its hit.
struct Traced {
  HitBits hit;
  Work work;
  std::vector<std::string> log;  ///< one line a node visited
};

/// The components are numbers of the image's format, so the float holds them exactly.
Traced trace(const Tracer& tracer, const Corner& o, const Corner& d, float tmin, float tmax,
             bool any_hit) {
  Ray ray;
  ray.o = {o[0], o[1], o[2]};
  ray.d = {d[0], d[1], d[2]};
  ray.tmin = tmin;
  ray.tmax = tmax;
  ray.any = any_hit;
  Traced traced;
  const Tracer::Log log = [&traced](const std::string& line) { traced.log.push_back(line); };
  traced.hit = tracer.trace(ray, traced.work, &log);
  return traced;
}

void bind_image(nb::module_& module) {
  nb::class_<Image>(module, "Image", "A memory image; offsets count bytes from its start.")
      .def_static("build", &build, nb::arg("format"), nb::arg("triangles"),
                  nb::arg("test") = "local",
                  "Tree and image of triangles, each ((x, y, z), (x, y, z), (x, y, z)).")
      .def_prop_ro(
          "bytes",
          [](const Image& image) { return nb::bytes(image.bytes().data(), image.bytes().size()); })
      .def_prop_ro("root", [](const Image& image) { return image.header().root; })
      .def_prop_ro("node_count", [](const Image& image) { return image.parts().node_count; })
      .def_prop_ro("stack_bound",
                   [](const Image& image) { return tree_bounds(image).value().stack; })
      .def_prop_ro("list_count", [](const Image& image) { return image.parts().list_count; })
      .def_prop_ro("triangle_count",
                   [](const Image& image) { return image.parts().triangle_count; })
      .def_prop_ro("node_offset", [](const Image& image) { return image.parts().node_offset; })
      .def_prop_ro("list_offset", [](const Image& image) { return image.parts().list_offset; })
      .def_prop_ro("record_offset",
                   [](const Image& image) { return image.parts().record_offset(); })
      .def_prop_ro("bary_offset", [](const Image& image) { return image.parts().bary_offset; })
      .def_prop_ro("box_lo", [](const Image& image) { return image.header().box_lo; })
      .def_prop_ro("box_hi", [](const Image& image) { return image.header().box_hi; });
}

void bind_tracer(nb::module_& module) {
  nb::class_<Traced>(module, "Traced", "A hit as bits, the work of its ray, a line a node visited.")
      .def_prop_ro("t", [](const Traced& traced) { return traced.hit.t; })
      .def_prop_ro("u", [](const Traced& traced) { return traced.hit.u; })
      .def_prop_ro("v", [](const Traced& traced) { return traced.hit.v; })
      .def_prop_ro("prim", [](const Traced& traced) { return traced.hit.prim; })
      .def_prop_ro("status",
                   [](const Traced& traced) { return static_cast<int>(traced.hit.status); })
      .def_prop_ro("hit_steps", [](const Traced& traced) { return traced.hit.steps; })
      .def_prop_ro("steps", [](const Traced& traced) { return traced.work.steps; })
      .def_prop_ro("leaves", [](const Traced& traced) { return traced.work.leaves; })
      .def_prop_ro("full_leaves", [](const Traced& traced) { return traced.work.full_leaves; })
      .def_prop_ro("restarts", [](const Traced& traced) { return traced.work.restarts; })
      .def_prop_ro("a_tests", [](const Traced& traced) { return traced.work.a_tests; })
      .def_prop_ro("b_tests", [](const Traced& traced) { return traced.work.b_tests; })
      .def_prop_ro("c_tests", [](const Traced& traced) { return traced.work.c_tests; })
      .def_ro("log", &Traced::log);
  nb::class_<Tracer>(module, "Tracer", "The model of the whole engine on one image.")
      .def_static(
          "create",
          [](const Image& image, int stack_depth, int watchdog_steps, bool interval_cull,
             int interval_guard, bool early_exit, bool restart, bool any_hit,
             const std::string& traversal) {
            return Tracer::create(
                image,
                {stack_depth, watchdog_steps, interval_cull, interval_guard, early_exit, restart,
                 static_cast<Traversal>(number_of(kTraversalNames, traversal)), any_hit});
          },
          nb::arg("image"), nb::arg("stack_depth") = 4, nb::arg("watchdog_steps") = 65535,
          nb::arg("interval_cull") = true, nb::arg("interval_guard") = 4,
          nb::arg("early_exit") = true, nb::arg("restart") = true, nb::arg("any_hit") = true,
          nb::arg("traversal") = "plain", nb::keep_alive<0, 1>())
      .def("trace", &trace, nb::arg("o"), nb::arg("d"), nb::arg("tmin"), nb::arg("tmax"),
           nb::arg("any_hit") = false);
}

}  // namespace

void bind_scene(nb::module_& module) {
  module.def(
      "corner_bytes", [](const Format& format) { return corner_bytes(format); }, nb::arg("format"),
      "Bytes of a packed record of Woop's test.");
  bind_image(module);
  bind_tracer(module);
}

}  // namespace ti
