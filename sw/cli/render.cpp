// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <cstdio>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "cli/traced_run.hpp"
#include "io/file.hpp"
#include "io/png.hpp"
#include "render/heat_map.hpp"
#include "render/shade.hpp"
#include "scene/rays.hpp"

namespace ti {
namespace {

struct Size {
  int width, height;
};

Size parse_size(const std::string& text) {
  int width = 0;
  int height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 1 ||
      height < 1 || width > kMaxSide || height > kMaxSide) {
    throw Error(
        fmt::format("SIZE={}: give a size as WIDTHxHEIGHT, each from 1 to {}, such as 256x256",
                    text, kMaxSide));
  }
  return {width, height};
}

/// Adds a picture of a count a pixel.
void add_heat_map(Files& files, const char* what, const std::vector<std::uint64_t>& per_pixel,
                  int spp, const Size& size) {
  HeatMap map = heat_map(per_pixel, spp, size.width, size.height);
  fmt::print("{0}.png: {0} a ray, from 0 (dark) to {1:.0f} and more (bright)\n", what, map.top);
  files.add(fmt::format("{}.png", what), std::move(map.png));
}

}  // namespace

int render(Arguments& arguments) {
  const Size size = parse_size(arguments.size);
  check_folder(arguments.run.out);
  if (arguments.effects != "none") {
    throw Error(fmt::format("EFFECTS={}: only EFFECTS=none (primary rays) is there so far",
                            arguments.effects));
  }
  if (arguments.spp < 1 || arguments.spp > 4096)
    throw Error(fmt::format("SPP={}: give 1 to 4096", arguments.spp));
  check_ray_count(fmt::format("SIZE={} SPP={}", arguments.size, arguments.spp),
                  static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height),
                  static_cast<std::uint64_t>(arguments.spp));
  arguments.run.tests = true;
  const std::size_t pixel_count =
      static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  Progress progress(pixel_count * static_cast<std::size_t>(arguments.spp));
  Session session = start(arguments, progress);
  const auto primary =
      primary_rays(session.scene().camera, size.width, size.height, arguments.spp, arguments.seed);
  Report report{.request = {.command = "render",
                            .rays = {},
                            .size = {{size.width, size.height}},
                            .spp = arguments.spp,
                            .effects = arguments.effects,
                            .seed = arguments.seed},
                .total = {},
                .waves = {}};
  trace_waves(session, primary.rays, arguments.waves, report);

  const Wave& wave = report.total;
  const auto rays = std::span(primary.rays).first(wave.hits.size());
  const auto colours = shade(session.scene(), rays, wave.hits);
  std::vector<glm::vec3> pixels(pixel_count);
  std::vector<std::uint64_t> steps(pixel_count);
  std::vector<std::uint64_t> tests(pixel_count);
  for (std::size_t i = 0; i < colours.size(); ++i) {
    pixels[primary.index[i]] += colours[i] / static_cast<float>(arguments.spp);
    steps[primary.index[i]] += wave.hits[i].steps;
    if (!wave.tests.empty()) tests[primary.index[i]] += wave.tests[i];
  }
  Files files(arguments);
  files.add("image.png", png_of(pixels, size.width, size.height));
  if (arguments.run.engine != EngineKind::Embree) {
    add_heat_map(files, "steps", steps, arguments.spp, size);
    add_heat_map(files, "tests", tests, arguments.spp, size);
  }
  files.add_dump(arguments, primary.rays, wave, false);
  return finish(report, session, files);
}

}  // namespace ti
