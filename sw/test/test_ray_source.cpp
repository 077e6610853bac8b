// SPDX-License-Identifier: Apache-2.0
// RAYS= is a file or one of the kinds; what is made for an engine is in its number format.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <memory>

#include "accel/build.hpp"
#include "base/limits.hpp"
#include "cli/ray_source.hpp"
#include "scene/aimed_rays.hpp"
#include "support.hpp"
#include "tree_walk.hpp"

namespace {

using namespace ti;
using test::check_error;

TEST_CASE("the text of RAYS= is a file, or a kind and a count") {
  CHECK(parse_ray_source("rays.npy").file == "rays.npy");
  CHECK(parse_ray_source("C:7").file == "C:7");
  CHECK(parse_ray_source("./ao:7").file == "./ao:7");
  const RaySource source = parse_ray_source("diffuse:67108864");
  CHECK(source.file.empty());
  CHECK(source.kind == "diffuse");
  CHECK(source.count == kMaxRays);
  check_error([] { (void)parse_ray_source(""); }, {"RAYS="});
  check_error([] { (void)parse_ray_source("reflection:10"); },
              {"`reflection`", "random, inside, primary, ao, uniform, diffuse, shadow"});
  for (const char* text : {"ao:", "ao:0", "ao:-1", "ao:1x", "ao:67108865", "random:1000000000",
                           "random:99999999999999999999"}) {
    check_error([text] { (void)parse_ray_source(text); }, {text, "1 to 67108864"});
  }
}

TEST_CASE("secondary rays start at numbers of the engine's format") {
  Scene scene;
  scene.mesh = soup(60, 0.8F, 5);
  scene.materials.resize(1);
  scene.camera = {.eye = {0.5F, 0.5F, 3.0F}, .target = glm::vec3(0.5F)};
  scene.lights = {{.position = {3.0F, 4.0F, 5.0F}}};
  BuildOptions options;
  options.format = {7, 16};
  BuildStats stats;
  const Image image = build_image(scene.mesh, options, stats);
  const auto model = Tracer::create(image, {});
  for (const char* kind : {"ao", "diffuse", "shadow", "secondary"}) {
    CAPTURE(kind);
    const auto rays =
        make_rays({.file = {}, .kind = kind, .count = 500}, scene, *model, options.format, 1);
    REQUIRE(rays.size() > 100);
    for (const Ray& ray : rays) {
      for (int axis = 0; axis < 3; ++axis) {
        CHECK(round_to(options.format, ray.o[axis]) == double{ray.o[axis]});
      }
    }
  }
}

TEST_CASE("aimed rays point at what they are named for, one by one or all at once") {
  Scene scene;
  scene.mesh = soup(60, 0.8F, 5);
  BuildStats stats;
  const Image image = build_image(scene.mesh, {}, stats);
  const auto model = Tracer::create(image, {});
  for (const Aim aim : {Aim::Edges, Aim::Vertices, Aim::Grazing, Aim::Far}) {
    const char* kind = kAimNames[static_cast<std::size_t>(aim)];
    CAPTURE(kind);
    const auto rays = make_rays({.file = {}, .kind = kind, .count = 200}, scene, *model, {}, 9);
    REQUIRE(rays.size() == 200);
    const AimedRays one(scene.mesh, aim, 9);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      CHECK(rays[i].o == one(i).o);
      CHECK(rays[i].d == one(i).d);
      if (aim != Aim::Vertices) continue;
      const glm::vec3 end = rays[i].o + rays[i].d;
      CHECK(std::any_of(scene.mesh.vertices.begin(), scene.mesh.vertices.end(), [&](const auto& p) {
        return std::abs(p.x - end.x) + std::abs(p.y - end.y) + std::abs(p.z - end.z) < 1e-5F;
      }));
    }
  }
  scene.mesh = {};
  test::check_error(
      [&] { (void)make_rays({.file = {}, .kind = "edges", .count = 5}, scene, *model, {}, 1); },
      {"edges:5", "it has no triangle"});
}

}  // namespace
