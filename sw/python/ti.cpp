// SPDX-License-Identifier: Apache-2.0
//
// The Python module `ti`: scenes, rays, and engines that answer numpy arrays of rays in this
// process.
#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include <atomic>
#include <cstdlib>
#include <map>
#include <memory>

#include "base/error.hpp"
#include "engine/session.hpp"
#include "python/arrays.hpp"
#include "report/report.hpp"
#include "scene/geometry.hpp"
#include "scene/rays.hpp"

namespace ti {
namespace {

using namespace nb::literals;

std::vector<Hit> hits_of(const HitArray& hits, const PrimArray& prims) {
  if (hits.shape(0) != prims.shape(0)) throw Error("hits and prims must have the same length");
  std::vector<Hit> all(prims.shape(0));
  for (std::size_t i = 0; i < all.size(); ++i) {
    const float* f = hits.data() + 3 * i;
    all[i] = {.t = f[0], .u = f[1], .v = f[2], .prim = prims.data()[i]};
  }
  return all;
}

/// (E, M) as Python gives it, with "zero", "flush" and "woop" behind it where those are the modes
/// and the test.
ScaledFormat format_of(const nb::tuple& given, int scale) {
  Format format{0, 0};
  bool known = nb::len(given) >= 2 && nb::try_cast(given[0], format.exp_bits) &&
               nb::try_cast(given[1], format.frac_bits) && format.exp_bits >= 3 &&
               format.exp_bits <= 8 && format.frac_bits >= 2 && format.frac_bits <= 23;
  bool woop = false;
  for (std::size_t i = 2; known && i < nb::len(given); ++i) {
    const std::string word = nb::str(given[i]).c_str();
    known = word == "zero" || word == "flush" || word == "woop";
    woop = woop || word == "woop";
    format.modes.toward_zero = format.modes.toward_zero || word == "zero";
    format.modes.flush = format.modes.flush || word == "flush";
  }
  if (std::abs(scale) > kMostScale)
    throw Error("scale=" + std::to_string(scale) + ": give that of the engine (Engine.scale)");
  if (known) return {format, scale, woop};
  throw Error(std::string("format=") + nb::str(given).c_str() +
              ": give (E, M) of the engine, from (3, 2) to (8, 23), and \"zero\", \"flush\", "
              "\"woop\" behind it if it has them (Engine.format)");
}

nb::tuple tuple_of(const ScaledFormat& engine) {
  const Format& format = engine.numbers;
  nb::list words;
  words.append(format.exp_bits);
  words.append(format.frac_bits);
  if (format.modes.toward_zero) words.append("zero");
  if (format.modes.flush) words.append("flush");
  if (engine.by_area) words.append("woop");
  return nb::tuple(words);
}

/// Each element `times` times.
template <typename T>
std::vector<T> repeated(const std::vector<T>& elements, int times) {
  std::vector<T> all;
  for (const T& element : elements) all.insert(all.end(), static_cast<std::size_t>(times), element);
  return all;
}

EngineKind kind_of(const std::string& name) {
  const std::map<std::string, EngineKind> kinds{
      {"rtl", EngineKind::Rtl}, {"model", EngineKind::Model}, {"embree", EngineKind::Embree}};
  const auto found = kinds.find(name);
  if (found == kinds.end()) throw Error("engine=\"" + name + "\": there are rtl, model, embree");
  return found->second;
}

/// A scene and the file that it is from.
struct PyScene {
  std::filesystem::path path;
  Scene scene;
};

/// A wave with what a report says of it alone.
struct PyWave {
  Wave wave;
  std::string report;
};

/// A session that Python can interrupt.
class PyEngine {
 public:
  PyEngine(const PyScene& scene, RunOptions options) {
    options.scene = scene.path;
    options.stop = &stop_;
    options.rtl.progress = [this](std::uint64_t, std::uint64_t) {
      const nb::gil_scoped_acquire gil;
      if (PyErr_CheckSignals() != 0) stop_ = true;
    };
    const nb::gil_scoped_release release;
    session_ = std::make_unique<Session>(options, scene.scene);
    session_->require_triangles();
  }

  PyWave trace(const RayArray& array, bool any_hit) {
    const std::vector<Ray> rays = rays_of(array, any_hit);
    PyWave traced;
    {
      const nb::gil_scoped_release release;
      traced.wave = session_->trace(rays);
    }
    if (stop_.exchange(false)) throw nb::python_error();
    Report report;
    report.request.command = "wave";
    report.add(traced.wave);
    traced.report = to_json(report, *session_);
    return traced;
  }

  [[nodiscard]] nb::tuple format() const { return tuple_of(session_->format()); }
  [[nodiscard]] int scale() const { return session_->format().scale; }

 private:
  std::atomic<bool> stop_{false};
  std::unique_ptr<Session> session_;
};

void bind_scene(nb::module_& module) {
  nb::class_<PyScene>(module, "Scene", "A mesh with its camera, materials and lights.")
      .def(
          "__init__",
          [](PyScene* self, const std::filesystem::path& path) {
            new (self) PyScene{path, load_scene(path)};
          },
          "path"_a, "Loads glTF, OBJ, PLY or .ply.zst.  Raises ValueError with one sentence.")
      .def_prop_ro("name", [](const PyScene& s) { return s.scene.name; })
      .def_prop_ro("triangles", [](const PyScene& s) { return s.scene.mesh.triangles.size(); })
      .def_prop_ro(
          "diagonal",
          [](const PyScene& s) {
            const auto bounds = bounds_of(s.scene.mesh);
            return bounds ? bounds->diagonal() : 0.0;
          },
          "Of the box of the mesh, in scene units.")
      .def(
          "image",
          [](const PyScene& s, const std::filesystem::path& config) {
            RunOptions options;
            options.config = load_config(config);
            options.scene = s.path;
            return scene_image_of(s.scene, options).image;
          },
          "config"_a, "The memory image for a machine of that config.json.")
      .def(
          "primary_rays",
          [](const PyScene& s, int width, int height, int spp, std::uint64_t seed) {
            const PrimaryRays primary = primary_rays(s.scene.camera, width, height, spp, seed);
            return nb::make_tuple(array_of_rays(primary.rays), array_of(primary.index));
          },
          "width"_a, "height"_a, "spp"_a = 1, "seed"_a = 1,
          "Camera rays, float32 [N,8] in Morton order, and the pixel y * width + x of each.")
      .def(
          "random_rays",
          [](const PyScene& s, std::size_t count, std::uint64_t seed) {
            return array_of_rays(random_rays(s.scene.mesh, count, seed));
          },
          "count"_a, "seed"_a = 1, "Rays around the mesh in all directions, float32 [N,8].")
      .def(
          "ao_rays",
          [](const PyScene& s, const RayArray& rays, const HitArray& hits, const PrimArray& prims,
             int samples, float radius, std::uint64_t seed, const nb::tuple& format, int scale) {
            return array_of_rays(ao_rays(s.scene.mesh, format_of(format, scale), rays_of(rays),
                                         hits_of(hits, prims), samples, radius, seed));
          },
          "rays"_a, "hits"_a, "prims"_a, "samples"_a, "radius"_a, "seed"_a = 1, nb::kw_only(),
          "format"_a, "scale"_a = 0,
          "`samples` cosine-distributed rays of length `radius` from each hit, float32 [N,8], for\n"
          "engines of `format` that have the scene times 2^`scale` (`Engine.format`, "
          "`Engine.scale`).")
      .def(
          "diffuse_rays",
          [](const PyScene& s, const RayArray& rays, const HitArray& hits, const PrimArray& prims,
             int samples, std::uint64_t seed, const nb::tuple& format, int scale) {
            return array_of_rays(diffuse_rays(s.scene.mesh, format_of(format, scale),
                                              repeated(rays_of(rays), samples),
                                              repeated(hits_of(hits, prims), samples), seed));
          },
          "rays"_a, "hits"_a, "prims"_a, "samples"_a = 1, "seed"_a = 1, nb::kw_only(), "format"_a,
          "scale"_a = 0,
          "`samples` cosine-distributed rays without an end from each hit, float32 [N,8], for\n"
          "engines of `format` that have the scene times 2^`scale` (`Engine.format`, "
          "`Engine.scale`).");
}

void bind_wave(nb::module_& module) {
  nb::class_<PyWave> wave(module, "Wave", "Rays that were traced together.");
  bind_hits(wave, [](const PyWave& w) -> const std::vector<Hit>& { return w.wave.hits; });
  wave.def_prop_ro(
          "tests", [](const PyWave& w) { return array_of(w.wave.tests); }, nb::rv_policy::move,
          "uint32 [N]: triangles tested; empty unless the model ran beside the engine.")
      .def_prop_ro(
          "answered", [](const PyWave& w) { return array_of(w.wave.answered); },
          nb::rv_policy::move, "uint64 [N]: cycles to each answer; empty but for the RTL.")
      .def_prop_ro(
          "good", [](const PyWave& w) { return w.wave.good(); },
          "Whether nothing was lost, doubled, unexplained or unlike the model.")
      .def_prop_ro(
          "report",
          [](const PyWave& w) { return nb::module_::import_("json").attr("loads")(w.report); },
          "What report.json would say of this wave alone, as a dict.");
}

void bind_engine(nb::module_& module) {
  nb::class_<PyEngine>(module, "Engine",
                       "A scene with its tree and one engine; caches stay warm between waves.")
      .def(
          "__init__",
          [](PyEngine* self, const PyScene& scene, const std::filesystem::path& config,
             const std::string& engine, const std::filesystem::path& library, bool lock_step,
             bool truth, bool tests, const std::string& memory, int memory_latency,
             double memory_bytes_per_cycle, std::uint64_t stall_seed) {
            RunOptions options;
            options.config = load_config(config);
            options.engine = kind_of(engine);
            options.library = library;
            options.lock_step = lock_step;
            options.truth = truth;
            options.tests = tests;
            options.rtl.memory = memory_kind(memory);
            options.rtl.memory_latency = memory_latency;
            options.rtl.memory_bytes_per_cycle = memory_bytes_per_cycle;
            options.rtl.stall_seed = stall_seed;
            new (self) PyEngine(scene, options);
          },
          "scene"_a, "config"_a, "engine"_a = "model", nb::kw_only(), "library"_a = "",
          "lock_step"_a = true, "truth"_a = false, "tests"_a = false, "memory"_a = "fixed",
          "memory_latency"_a = 100, "memory_bytes_per_cycle"_a = 64.0, "stall_seed"_a = 0,
          "config: a config.json.  library: the libti_rtl.so of `make engine`, for "
          "engine=\"rtl\".\n"
          "lock_step compares the RTL with the model, truth all hits with Embree; tests counts\n"
          "the triangle tests of each ray.  memory: \"ideal\", \"fixed\" with its latency in "
          "cycles\n"
          "and bandwidth, or \"dram\".")
      .def_prop_ro("format", &PyEngine::format,
                   "(E, M): exponent and fraction bits of its numbers; behind them \"zero\" and "
                   "\"flush\" where it rounds toward zero or flushes subnormals, \"woop\" where it "
                   "has that test.")
      .def_prop_ro("scale", &PyEngine::scale,
                   "The engine has places and t times 2^scale; rays and hits are in scene units.")
      .def("trace", &PyEngine::trace, "rays"_a, "any_hit"_a = false,
           "Traces float32 [N,8]: origin xyz, tmin, direction xyz, tmax; gives a Wave.");
}

}  // namespace

NB_MODULE(ti, module) {
  module.doc() =
      "Ray tracing engines in this process: the bit-exact model, the RTL under Verilator, Embree.";
  nb::register_exception_translator([](const std::exception_ptr& p, void*) {
    try {
      std::rethrow_exception(p);
    } catch (const Error& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    }
  });
  module.attr("commit") = commit();
  bind_scene(module);
  bind_wave(module);
  bind_engine(module);
  bind_device(module);
}

}  // namespace ti
