// SPDX-License-Identifier: Apache-2.0
//
// The driver of a `ti_top` in Python: verilated, or on a board.
#include "host/device.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/set.h>
#include <nanobind/stl/string.h>

#include <array>
#include <bit>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "engine/engine.hpp"
#include "host/uio_link.hpp"
#include "python/arrays.hpp"
#include "scene/scaling.hpp"

namespace ti {
namespace {

using namespace nb::literals;

/// Bits of IRQ_STATUS and IRQ_ENABLE, the lowest first.
constexpr std::array<const char*, 4> kInterrupts{"invalid_ray", "memory_error", "watchdog",
                                                 "drained"};

std::uint32_t bits_of(const std::set<std::string>& names) {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < kInterrupts.size(); ++i)
    bits |= static_cast<std::uint32_t>(names.count(kInterrupts[i])) << i;
  if (static_cast<std::size_t>(std::popcount(bits)) != names.size())
    throw Error("there are the interrupts invalid_ray, memory_error, watchdog, drained");
  return bits;
}

struct PyHits {
  std::vector<Hit> hits;
};

/// A link with its driver, and what is known of the scene that it has.
class PyDevice {
 public:
  explicit PyDevice(std::unique_ptr<host::Link> link) : link_(std::move(link)), device_(*link_) {}

  [[nodiscard]] host::Device& device() { return device_; }

  void load(const Image& image) {
    const nb::gil_scoped_release release;
    scale_.reset();
    device_.load(image);
    scale_ = image.header().scale;
  }

  PyHits trace(const RayArray& array, bool any_hit) {
    if (!scale_) throw Error("the device has no scene yet; load an image first");
    std::vector<Ray> rays = rays_of(array, any_hit);
    const nb::gil_scoped_release release;
    for (Ray& ray : rays) ray = scaled(ray, *scale_);
    PyHits hits;
    for (const HitBits& bits : device_.trace(rays))
      hits.hits.push_back(scaled(hit_of(device_.machine().format, bits), -*scale_));
    return hits;
  }

 private:
  std::unique_ptr<host::Link> link_;
  host::Device device_;
  std::optional<int> scale_;
};

std::unique_ptr<host::Link> link_of(const std::filesystem::path& library,
                                    const std::filesystem::path& board, std::size_t memory_bytes) {
  if (library.empty() == board.empty())
    throw Error("a device is one of two: give library=, of make top-engine, or board=");
  if (library.empty()) return std::make_unique<host::UioLink>(host::load_board(board));
  return load_rtl_link(library, memory_bytes, {});
}

nb::dict identity_of(const host::Machine& machine) {
  nb::dict dict;
  dict["digest"] = machine.digest;
  dict["format"] = nb::make_tuple(machine.format.exp_bits, machine.format.frac_bits);
  dict["rounding"] = machine.format.modes.toward_zero ? "zero" : "nearest";
  dict["subnormals"] = machine.format.modes.flush ? "flush" : "keep";
  dict["cores"] = machine.cores;
  dict["streams"] = machine.streams;
  dict["triangle_test"] = test_name(test_kind(machine.triangle_test));
  dict["any_hit"] = machine.any_hit;
  dict["counters"] = machine.counters;
  dict["snapshot"] = machine.snapshot;
  dict["line_bytes"] = machine.line_bytes;
  dict["addr_bits"] = machine.addr_bits;
  return dict;
}

nb::dict counters_of(const host::Tally& tally) {
  nb::dict dict;
  dict["rays"] = tally.rays;
  dict["hits"] = tally.hits;
  dict["invalid_rays"] = tally.invalid_rays;
  dict["memory_errors"] = tally.memory_errors;
  dict["watchdogs"] = tally.watchdogs;
  return dict;
}

}  // namespace

void bind_device(nb::module_& module) {
  nb::class_<Image>(module, "Image", "A memory image of a scene, for a device.")
      .def(
          "__init__",
          [](Image* self, const std::filesystem::path& path) {
            new (self) Image(Image::load(path));
          },
          "path"_a, "Loads what `make image` wrote.")
      .def_prop_ro("bytes", [](const Image& image) { return image.bytes().size(); });

  nb::class_<PyHits> hits(module, "Hits", "What a device answered, in the order of the rays.");
  bind_hits(hits, [](const PyHits& h) -> const std::vector<Hit>& { return h.hits; });
  hits.def_prop_ro(
      "status",
      [](const PyHits& h) {
        return array_of_each<std::uint8_t>(
            h.hits, [](const Hit& hit) { return static_cast<std::uint8_t>(hit.status); });
      },
      nb::rv_policy::move, "uint8 [N]: 0 ok, 1 invalid ray, 2 memory error, 3 watchdog.");

  nb::class_<PyDevice>(module, "Device", "The driver of one ti_top, verilated or on a board.")
      .def(
          "__init__",
          [](PyDevice* self, const std::filesystem::path& library,
             const std::filesystem::path& board, std::size_t memory_bytes) {
            new (self) PyDevice(link_of(library, board, memory_bytes));
          },
          nb::kw_only(), "library"_a = "", "board"_a = "", "memory_bytes"_a = std::size_t{1} << 26U,
          "library: the libti_rtl.so of `make top-engine`, with so much memory behind it.\n"
          "board: the file that says where the devices of a board are.")
      .def(
          "identify", [](PyDevice& d) { return identity_of(d.device().machine()); },
          "What its registers say of the machine, as a dict.")
      .def("load", &PyDevice::load, "image"_a,
           "Drains, puts the image into its memory, and flushes all caches.")
      .def("trace", &PyDevice::trace, "rays"_a, "any_hit"_a = false,
           "Traces float32 [N,8]: origin xyz, tmin, direction xyz, tmax; gives Hits.")
      .def(
          "counters", [](PyDevice& d) { return counters_of(d.device().tally()); },
          "Rays, hits and errors since the reset, as a dict.")
      .def(
          "counter",
          [](PyDevice& d, int core, int unit, int event) {
            return d.device().counter(core, unit, event);
          },
          "core"_a, "unit"_a, "event"_a,
          "A counter of a unit, of the last snapshot where the machine has them.")
      .def(
          "snapshot", [](PyDevice& d) { d.device().snapshot(); },
          "Takes all counters of all units at once.")
      .def(
          "irq_status",
          [](PyDevice& d) {
            const std::uint32_t bits = d.device().irq_status();
            std::set<std::string> names;
            for (std::size_t i = 0; i < kInterrupts.size(); ++i)
              if ((bits >> i & 1U) != 0) names.insert(kInterrupts[i]);
            return names;
          },
          "Set of what has happened: invalid_ray, memory_error, watchdog, drained.")
      .def(
          "clear_irq",
          [](PyDevice& d, const std::set<std::string>& names) {
            d.device().clear_irq(bits_of(names));
          },
          "names"_a)
      .def(
          "enable_irq",
          [](PyDevice& d, const std::set<std::string>& names) {
            d.device().enable_irq(bits_of(names));
          },
          "names"_a, "Only these raise the interrupt.")
      .def(
          "drain", [](PyDevice& d) { d.device().drain(); },
          "Waits until all rays are out; the next trace takes rays again.")
      .def("flush", [](PyDevice& d) { d.device().flush(); }, "Forgets all lines of all caches.");
}

}  // namespace ti
