// SPDX-License-Identifier: Apache-2.0
// Rays cover the picture in Morton order, leave surfaces on the right side, and are the same for
// the same seed.
#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vector_relational.hpp>
#include <set>
#include <stdexcept>
#include <utility>

#include "scene/aimed_rays.hpp"
#include "scene/random.hpp"
#include "scene/rays.hpp"
#include "test/support.hpp"

namespace {

using namespace ti;
using namespace ti::test;

/// Looks along -z; half the picture's height is 1 at distance 1.
Camera square_camera() {
  return {.eye = {1, 2, 3}, .target = {1, 2, -7}, .up = {0, 1, 0}, .fov_y_deg = 90.0F};
}

/// Where a ray of `square_camera` crosses the picture, in pixels.
glm::dvec2 pixel_of(const Ray& ray, int width, int height) {
  const double x = ray.d.x / -ray.d.z * height / width;
  const double y = ray.d.y / -ray.d.z;
  return {(x + 1) * 0.5 * width, (1 - y) * 0.5 * height};
}

std::uint64_t morton(std::uint32_t x, std::uint32_t y) {
  std::uint64_t code = 0;
  for (int bit = 0; bit < 16; ++bit) {
    code |= static_cast<std::uint64_t>(x >> bit & 1) << (2 * bit);
    code |= static_cast<std::uint64_t>(y >> bit & 1) << (2 * bit + 1);
  }
  return code;
}

/// Two triangles in the plane z = 0 that face +z, and one with no area.
Mesh square() {
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
          .triangles = {{0, 1, 2}, {0, 2, 3}, {0, 0, 1}},
          .material = {}};
}

/// Onto the first triangle, onto the back of the second, and past both.
std::vector<Ray> rays_down() {
  return {{.o = {0.6F, 0.2F, 5}, .d = {0, 0, -1}},
          {.o = {0.2F, 0.6F, -5}, .d = {0, 0, 2}},
          {.o = {9, 9, 5}, .d = {0, 0, -1}}};
}

std::vector<Hit> hits_down() {
  return {{.t = 5.0F, .u = 0.4F, .v = 0.2F, .prim = 0},
          {.t = 2.5F, .u = 0.2F, .v = 0.4F, .prim = 1},
          {}};
}

TEST_CASE("one ray a pixel goes through the centre of each pixel, in Morton order") {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 2}, {7, 5}, {5, 7}, {64, 1}, {33, 16}}) {
    const auto out = primary_rays(square_camera(), width, height, 1, 1);
    const auto pixels = static_cast<std::size_t>(width * height);
    REQUIRE(out.rays.size() == pixels);
    REQUIRE(out.index.size() == pixels);
    std::set<std::uint32_t> seen;
    std::uint64_t last = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::uint32_t x = out.index[i] % static_cast<std::uint32_t>(width);
      const std::uint32_t y = out.index[i] / static_cast<std::uint32_t>(width);
      REQUIRE(out.index[i] < pixels);
      CHECK(seen.insert(out.index[i]).second);
      if (i > 0) CHECK(morton(x, y) > last);
      last = morton(x, y);
      const glm::dvec2 p = pixel_of(out.rays[i], width, height);
      CHECK(p.x == doctest::Approx(x + 0.5).epsilon(1e-5));
      CHECK(p.y == doctest::Approx(y + 0.5).epsilon(1e-5));
      CHECK(glm::length(glm::dvec3(out.rays[i].d)) == doctest::Approx(1.0).epsilon(1e-6));
      CHECK(out.rays[i].o == glm::vec3(1, 2, 3));
      CHECK(out.rays[i].tmin == 0.0F);
      CHECK(std::isinf(out.rays[i].tmax));
      CHECK_FALSE(out.rays[i].any);
    }
  }
}

TEST_CASE("several rays a pixel stay inside it, one in each stratum") {
  for (const auto& [spp, columns] : {std::pair{2, 1}, {4, 2}, {6, 2}, {7, 1}, {16, 4}}) {
    const int width = 6;
    const int height = 3;
    const auto out = primary_rays(square_camera(), width, height, spp, 7);
    REQUIRE(out.rays.size() == static_cast<std::size_t>(width * height * spp));
    for (std::size_t i = 0; i < out.rays.size(); i += static_cast<std::size_t>(spp)) {
      std::set<int> strata;
      for (std::size_t k = i; k < i + static_cast<std::size_t>(spp); ++k) {
        CHECK(out.index[k] == out.index[i]);
        const glm::dvec2 p = pixel_of(out.rays[k], width, height);
        const double x = p.x - out.index[k] % width;
        const double y = p.y - out.index[k] / width;
        CHECK(x > -1e-5);
        CHECK(x < 1 + 1e-5);
        CHECK(y > -1e-5);
        CHECK(y < 1 + 1e-5);
        const int rows = spp / columns;
        strata.insert(static_cast<int>(x * columns) + columns * static_cast<int>(y * rows));
      }
      CHECK(strata.size() == static_cast<std::size_t>(spp));
    }
  }
}

TEST_CASE("a seed gives the same rays, another seed others") {
  const auto a = primary_rays(square_camera(), 8, 8, 4, 1);
  const auto b = primary_rays(square_camera(), 8, 8, 4, 1);
  const auto c = primary_rays(square_camera(), 8, 8, 4, 2);
  std::size_t same = 0;
  for (std::size_t i = 0; i < a.rays.size(); ++i) {
    CHECK(a.rays[i].d == b.rays[i].d);
    same += a.rays[i].d == c.rays[i].d ? 1 : 0;
  }
  CHECK(same == 0);
  const auto r1 = random_rays(square(), 100, 5);
  const auto r2 = random_rays(square(), 200, 5);
  for (std::size_t i = 0; i < r1.size(); ++i) {
    CHECK(r1[i].o == r2[i].o);
    CHECK(r1[i].d == r2[i].d);
  }
}

TEST_CASE("random numbers are these on every machine and with every compiler") {
  Random a(1, 0);
  CHECK(a.uniform() == 0x1.bb217c7e151eep-2);
  CHECK(a.uniform() == 0x1.b3d8ebf30869p-2);
  Random b(7, 123456789012);
  CHECK(b.disc() == glm::dvec2(-0x1.aaa68fa6d806cp-2, 0x1.bf6fe87a7f462p-1));
  CHECK(b.ball() == glm::dvec3(0x1.398429a1d5e9p-4, -0x1.87aaecbef63f8p-3, -0x1.dc13b152c82ep-5));
  CHECK(b.cosine({0, 0, -1}) ==
        glm::dvec3(-0x1.2615fd0aa24dp-2, 0x1.0e6df7a2f83b6p-1, -0x1.99222d667295cp-1));
}

TEST_CASE("a camera whose up is along the view still gives an upright frame") {
  Camera camera = square_camera();
  for (const glm::vec3 up : {glm::vec3(0, 0, 1), glm::vec3(0), glm::vec3(0, 0, -3)}) {
    camera.up = up;
    for (const Ray& ray : primary_rays(camera, 4, 4, 1, 1).rays) {
      CHECK(glm::length(ray.d) == doctest::Approx(1.0F));
    }
  }
}

TEST_CASE("pictures and cameras that cannot be are refused") {
  Camera camera = square_camera();
  check_error([&] { (void)primary_rays(camera, 0, 4, 1, 1); }, {"0x4"});
  check_error([&] { (void)primary_rays(camera, 4, -1, 1, 1); }, {"4x-1"});
  check_error([&] { (void)primary_rays(camera, 70000, 1, 1, 1); }, {"70000x1"});
  check_error([&] { (void)primary_rays(camera, 4, 4, 0, 1); }, {"0 rays a pixel"});
  check_error([&] { (void)primary_rays(camera, 16384, 16384, 1, 1); }, {"16384x16384", "2^26"});
  check_error([&] { (void)primary_rays(camera, 1024, 1024, 65, 1); }, {"SPP=65", "2^26"});
  camera.fov_y_deg = 180.0F;
  check_error([&] { (void)primary_rays(camera, 4, 4, 1, 1); }, {"180 degrees"});
  camera = square_camera();
  camera.target = camera.eye;
  check_error([&] { (void)primary_rays(camera, 4, 4, 1, 1); }, {"no direction"});
  camera.target.x = std::nanf("");
  check_error([&] { (void)primary_rays(camera, 4, 4, 1, 1); }, {"no direction"});
}

TEST_CASE("occlusion rays leave the hit on the side that the ray came from") {
  const auto out = ao_rays(square(), {}, rays_down(), hits_down(), 500, 0.25F, 3);
  REQUIRE(out.size() == 1000);
  double cosine = 0.0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double side = i < 500 ? 1.0 : -1.0;
    const Ray& ray = out[i];
    CHECK(ray.any);
    CHECK(ray.tmin == 0.0F);
    CHECK(ray.tmax == 0.25F);
    CHECK(glm::length(ray.d) == doctest::Approx(1.0F).epsilon(1e-6));
    CHECK(side * ray.d.z > 0.0);
    CHECK(ray.o.x == doctest::Approx(i < 500 ? 0.6F : 0.2F));
    CHECK(ray.o.y == doctest::Approx(i < 500 ? 0.2F : 0.6F));
    CHECK(side * ray.o.z > 0.0);
    CHECK(side * ray.o.z < 1e-6);
    cosine += side * ray.d.z / 1000;
  }
  CHECK(cosine == doctest::Approx(2.0 / 3.0).epsilon(0.05));  // the mean of a cosine distribution
  CHECK(ao_rays(square(), {}, rays_down(), hits_down(), 0, 0.25F, 3).empty());
}

TEST_CASE("diffuse rays are closest-hit rays, one a hit") {
  const auto out = diffuse_rays(square(), {}, rays_down(), hits_down(), 3);
  REQUIRE(out.size() == 2);
  for (const Ray& ray : out) {
    CHECK_FALSE(ray.any);
    CHECK(std::isinf(ray.tmax));
  }
  CHECK(out[0].d.z > 0.0F);
  CHECK(out[1].d.z < 0.0F);
}

TEST_CASE("shadow rays end just short of their light") {
  const std::vector<glm::vec3> lights{{3, 4, 2}, {0, 0, -8}};
  const auto out = shadow_rays(square(), {}, rays_down(), hits_down(), lights);
  REQUIRE(out.size() == 4);
  for (std::size_t i = 0; i < out.size(); ++i) {
    CHECK(out[i].any);
    CHECK(out[i].tmax > 0.99F);
    CHECK(out[i].tmax < 1.0F);
    const glm::vec3 end = out[i].o + out[i].d;
    CHECK(glm::distance(end, lights[i % 2]) < 1e-5F);
  }
  CHECK(shadow_rays(square(), {}, rays_down(), hits_down(), {}).empty());
}

TEST_CASE("a light at the origin of its shadow ray gives a valid ray of no length") {
  const Ray at = shadow_rays(square(), {}, rays_down(), hits_down(), std::vector<glm::vec3>(1))[0];
  const std::vector<glm::vec3> lights{at.o};
  const Ray ray = shadow_rays(square(), {}, rays_down(), hits_down(), lights)[0];
  CHECK(ray.d == glm::vec3(0, 0, 1));
  CHECK(ray.tmax == 0.0F);
}

TEST_CASE("a hit of a triangle without area still gives finite rays") {
  const std::vector<Ray> rays{{.o = {0.5F, 0, 5}, .d = {0, 0, -1}}};
  const std::vector<Hit> hits{{.t = 5.0F, .u = 0.0F, .v = 0.5F, .prim = 2}};
  const auto out = diffuse_rays(square(), {}, rays, hits, 1);
  REQUIRE(out.size() == 1);
  CHECK(out[0].d.z > 0.0F);
  CHECK(out[0].o.z > 0.0F);
}

TEST_CASE("a hit of a triangle that the mesh does not have is not followed") {
  const std::vector<Ray> rays(1);
  const std::vector<Hit> hits{{.t = 1.0F, .prim = 3}};
  CHECK_THROWS_AS((void)diffuse_rays(square(), {}, rays, hits, 1), std::out_of_range);
}

TEST_CASE("random rays start in a ball of 1.2 radii and go everywhere") {
  const auto out = random_rays(square(), 20000, 9);
  REQUIRE(out.size() == 20000);
  const double radius = 1.2 * std::sqrt(2.0) / 2;
  glm::dvec3 origin(0.0);
  glm::dvec3 direction(0.0);
  double farthest = 0.0;
  std::size_t inner = 0;
  for (const Ray& ray : out) {
    const glm::dvec3 o = glm::dvec3(ray.o) - glm::dvec3(0.5, 0.5, 0);
    farthest = std::max(farthest, glm::length(o));
    inner += glm::length(o) < radius / 2 ? 1 : 0;
    origin += o / 20000.0;
    direction += glm::dvec3(ray.d) / 20000.0;
    CHECK(glm::length(ray.d) == doctest::Approx(1.0F).epsilon(1e-6));
  }
  CHECK(farthest <= radius * 1.000001);
  CHECK(farthest > radius * 0.99);
  CHECK(glm::length(origin) < 0.03);
  CHECK(glm::length(direction) < 0.03);
  CHECK(static_cast<double>(inner) / 20000 == doctest::Approx(0.125).epsilon(0.1));
  CHECK(random_rays(Mesh{}, 10, 1).size() == 10);
  CHECK(random_rays(square(), 0, 1).empty());
}

TEST_CASE("inside rays start in the box of the mesh, all over it") {
  Mesh mesh = square();
  mesh.vertices.push_back({0, 0, 2});
  mesh.triangles.push_back({0, 1, 4});
  glm::dvec3 mean(0.0);
  for (const Ray& ray : inside_rays(mesh, 20000, 3)) {
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(ray.o[axis] >= 0.0F);
      CHECK(ray.o[axis] <= (axis == 2 ? 2.0F : 1.0F));
    }
    mean += glm::dvec3(ray.o) / 20000.0;
  }
  CHECK(glm::length(mean - glm::dvec3(0.5, 0.5, 1.0)) < 0.02);
  CHECK(inside_rays(mesh, 0, 3).empty());
}

TEST_CASE("random rays of a mesh with broken vertices are finite") {
  Mesh mesh = square();
  mesh.vertices.push_back({std::nanf(""), 0, 0});
  mesh.vertices.push_back({std::numeric_limits<float>::infinity(), 0, 0});
  mesh.triangles.push_back({0, 1, 4});
  mesh.triangles.push_back({0, 1, 5});
  for (const Ray& ray : random_rays(mesh, 100, 1)) {
    CHECK(glm::length(ray.o) < 3.0F);
  }
}

TEST_CASE("light comes from lights that have a place and from the middle of what emits") {
  Scene scene;
  scene.mesh.vertices = {{0, 0, 0}, {3, 0, 0}, {0, 0, 3}, {0, 3, 0}, {3, 3, 0}, {0, 3, 3}};
  scene.mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  scene.mesh.material = {0, 1};
  scene.materials = {{}, {.emission = glm::vec3(4.0F)}};
  scene.lights = {{.position = {1, 2, 3}}, {.kind = LightKind::Directional}};
  const auto places = light_places(scene);
  REQUIRE(places.size() == 2);
  CHECK(places[0] == glm::vec3(1, 2, 3));
  CHECK(places[1].x == doctest::Approx(1.0F).epsilon(0.01));
  CHECK(places[1].z == doctest::Approx(1.0F).epsilon(0.01));
  CHECK(places[1].y < 3.0F);
  CHECK(places[1].y > 2.98F);
}

TEST_CASE("powers of two do without the library, to three units in the last place") {
  for (int i = -4000; i <= 4000; ++i) {
    const double x = i / 256.0 + 1e-5 * i;
    const double want = std::exp2(x);
    REQUIRE(std::abs(portable_exp2(x) - want) <= 3 * 0x1p-52 * want);
  }
  for (int i = -1000; i < 1000; ++i) REQUIRE(portable_exp2(i) == std::ldexp(1.0, i));
}

TEST_CASE("aimed rays are the same on every machine") {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0.25F}, {0, 1, 0.5F}, {0.75F, 0.5F, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {0, 2, 3}};
  std::uint64_t sum = 14695981039346656037U;  // FNV-1a of all words
  for (std::size_t aim = 0; aim < kAimNames.size(); ++aim) {
    const AimedRays rays(mesh, static_cast<Aim>(aim), 1);
    for (std::uint64_t i = 0; i < 1000; ++i) {
      const Ray ray = rays(i);
      for (const float x : {ray.o.x, ray.o.y, ray.o.z, ray.d.x, ray.d.y, ray.d.z})
        sum = (sum ^ std::bit_cast<std::uint32_t>(x)) * 1099511628211U;
    }
  }
  CHECK(sum == 7819709566003286987U);
}

}  // namespace
