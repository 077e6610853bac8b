// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "engine/engine.hpp"
#include "host/link.hpp"

namespace ti {
namespace {

using nlohmann::json;

constexpr const char* kCure = "build it by `make engine CONFIG=...`";

const RtlPlugin& plugin_of(const std::filesystem::path& path) {
  const std::string file = path.string();
  if (!std::filesystem::is_regular_file(path))
    throw Error(fmt::format("{}: there is no library of the RTL; {}", file, kCure));
  // Never unloaded: what it throws lives in it.
  void* library =
      dlopen(std::filesystem::absolute(path).c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  const auto* plugin =
      library ? static_cast<const RtlPlugin*>(dlsym(library, "ti_rtl_plugin")) : nullptr;
  if (plugin == nullptr || plugin->interface != RtlPlugin::kInterface) {
    throw Error(fmt::format("{}: this is no library of the RTL for this program; {}", file, kCure));
  }
  return *plugin;
}

}  // namespace

const char* name_of(MemoryKind kind) {
  switch (kind) {
    case MemoryKind::Ideal:
      return "ideal";
    case MemoryKind::Fixed:
      return "fixed";
    case MemoryKind::Dram:
      return "dram";
  }
  return "";
}

MemoryKind memory_kind(const std::string& name) {
  for (const MemoryKind kind : {MemoryKind::Ideal, MemoryKind::Fixed, MemoryKind::Dram}) {
    if (name == name_of(kind)) return kind;
  }
  throw Error(fmt::format("MEM={}: no such memory; there are ideal, fixed, dram", name));
}

std::unique_ptr<Engine> load_rtl_engine(const std::filesystem::path& path, const Image& image,
                                        const Config& config, const RtlOptions& options) {
  const RtlPlugin& plugin = plugin_of(path);
  const json built = json::parse(plugin.config);
  const json wanted = json::parse(config.json);
  for (const auto& [key, value] : built.items()) {
    if (wanted.value(key, json()) != value) {
      throw Error(fmt::format(
          "{}: it was built for another configuration than {}, with {} {} and not {}; {}",
          path.string(), config.name, key, value.dump(), wanted.value(key, json()).dump(), kCure));
    }
  }
  if (!(image.format() == config.format)) {
    throw Error(fmt::format("the image has the number format {}, the RTL {}: build the image again",
                            name_of(image.format()), name_of(config.format)));
  }
  RtlOptions complete = options;
  complete.clock_mhz = config.clock_mhz;
  return std::unique_ptr<Engine>(plugin.make(image, complete));
}

std::unique_ptr<host::Link> load_rtl_link(const std::filesystem::path& path, std::size_t bytes,
                                          const RtlOptions& options) {
  const RtlPlugin& plugin = plugin_of(path);
  if (plugin.make_link == nullptr) {
    throw Error(fmt::format(
        "{}: the library has no registers and streams; build one by `make top-engine CONFIG=...`",
        path.string()));
  }
  return std::unique_ptr<host::Link>(plugin.make_link(bytes, options));
}

}  // namespace ti
