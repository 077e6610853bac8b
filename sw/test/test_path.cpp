// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/vec.hpp"
#include "render/path.hpp"
#include "test/picture.hpp"

namespace ti {
namespace {

using test::add_box;
using test::add_quad;
using test::Picture;
using test::picture_of;

constexpr double kPi = 3.14159265358979323846;

Camera looking(const glm::vec3& eye, const glm::vec3& target, float degrees = 40.0F) {
  return {.eye = eye, .target = target, .up = {0.1F, 1.0F, 0.2F}, .fov_y_deg = degrees};
}

/// A room of one material with the camera inside.
Scene closed_room(const Material& walls) {
  Scene scene;
  scene.materials = {walls};
  add_box(scene, {-1, -1, -1}, {1, 1, 1}, 0);
  scene.camera = looking({0.3F, -0.2F, 0.4F}, {1, 0.7F, -1}, 100.0F);
  return scene;
}

/// A room with a light, and matt, glossy, mirror and glass bodies in it.
Scene still_life() {
  Scene scene;
  scene.materials = {
      {.name = "wall", .diffuse = {0.7F, 0.6F, 0.5F}},
      {.name = "lamp", .diffuse = glm::vec3(0.0F), .emission = {9.0F, 8.0F, 7.0F}},
      {.name = "mirror", .diffuse = glm::vec3(0.0F), .specular = glm::vec3(0.9F)},
      {.name = "glass", .diffuse = glm::vec3(0.0F), .transmission = glm::vec3(0.95F)},
      {.name = "gloss",
       .diffuse = {0.1F, 0.2F, 0.4F},
       .specular = glm::vec3(0.3F),
       .schlick = 1.0F,
       .roughness = 0.2F}};
  add_box(scene, {-2, -2, -2}, {2, 2, 2}, 0);
  add_quad(scene,
           {{{-0.5F, 1.9F, -0.5F}, {0.5F, 1.9F, -0.5F}, {0.5F, 1.9F, 0.5F}, {-0.5F, 1.9F, 0.5F}}},
           1);
  add_box(scene, {-1.5F, -2, -1.5F}, {-0.6F, -1, -0.6F}, 2);
  add_box(scene, {-0.3F, -1.9F, 0.2F}, {0.3F, -1.2F, 0.8F}, 3);
  add_box(scene, {0.5F, -2, -1.2F}, {1.4F, -0.8F, -0.4F}, 4);
  scene.lights = {{.name = "bulb", .position = {1.5F, 1.0F, 1.5F}, .intensity = glm::vec3(2.0F)},
                  {.name = "spot",
                   .kind = LightKind::Spot,
                   .position = {-1.5F, 1.5F, 1.5F},
                   .direction = glm::normalize(glm::vec3(1, -1, -1)),
                   .intensity = glm::vec3(4.0F),
                   .cos_inner = 0.95F,
                   .cos_outer = 0.8F}};
  scene.camera = looking({0.2F, -0.5F, 1.9F}, {0, -1, -1}, 70.0F);
  return scene;
}

void check_same(const Picture& a, const Picture& b) {
  REQUIRE(a.radiance.size() == b.radiance.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.radiance.size(); ++i)
    different += a.radiance[i] != b.radiance[i] ? 1 : 0;
  CHECK(different == 0);
}

TEST_CASE("paths: a white body in uniform light cannot be seen") {
  Scene scene;
  scene.background = glm::vec3(1.0F);
  scene.camera = looking({2, 3, 4}, {0, 0, 0}, 30.0F);
  add_box(scene, {-1, -1, -1}, {1, 1, 1}, 0);
  SUBCASE("matt") { scene.materials = {{.diffuse = glm::vec3(1.0F)}}; }
  SUBCASE("mirror") {
    scene.materials = {{.diffuse = glm::vec3(0.0F), .specular = glm::vec3(1.0F)}};
  }
  SUBCASE("glass without an index") {
    scene.materials = {{.diffuse = glm::vec3(0.0F), .transmission = glm::vec3(1.0F), .ior = 1.0F}};
  }
  const Picture picture = picture_of(scene, {.width = 24, .height = 16, .spp = 4}, "auto");
  for (const glm::vec3& c : picture.radiance) CHECK(c.x == doctest::Approx(1.0).epsilon(1e-6));
}

TEST_CASE("paths: each pixel shows what is in its place, rows from the top") {
  // Lamps of their own brightness, as a chessboard seen straight on.
  constexpr int kWidth = 7;
  constexpr int kHeight = 5;
  Scene scene;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto left = static_cast<float>(x);
      const auto low = static_cast<float>(kHeight - 1 - y);
      scene.materials.push_back(
          {.emission = {static_cast<float>(1 + x), static_cast<float>(1 + y), 1.0F}});
      add_quad(scene,
               {{{left, low, 0}, {left + 1, low, 0}, {left + 1, low + 1, 0}, {left, low + 1, 0}}},
               static_cast<std::uint16_t>(scene.materials.size() - 1));
    }
  }
  const float middle_x = 0.5F * kWidth;
  const float middle_y = 0.5F * kHeight;
  scene.camera = {
      .eye = {middle_x, middle_y, middle_y}, .target = {middle_x, middle_y, 0}, .fov_y_deg = 90.0F};
  for (const int spp : {1, 3}) {
    const Picture picture =
        picture_of(scene, {.width = kWidth, .height = kHeight, .spp = spp, .bounces = 0}, "auto");
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        CHECK(picture.radiance[static_cast<std::size_t>(y * kWidth + x)] ==
              glm::vec3(1 + x, 1 + y, 1));
      }
    }
  }
}

TEST_CASE("paths: an engine that stops leaves what its hits show, and no ray behind it") {
  Scene scene = still_life();
  const FilmSize size{.width = 16, .height = 16, .spp = 2};
  BuildStats stats;
  const Image image = build_image(scene.mesh, {}, stats);
  const auto model = Tracer::create(image, {});
  for (const std::size_t limit : {100U, 256U, 400U, 700U}) {
    std::size_t left = limit;
    bool stopped = false;
    const Plan plan = make_plan(scene, size, EffectRequest::of("auto"));
    PathTracer tracer(scene, {.width = 16, .height = 16, .spp = 2, .effects = plan.effects},
                      [&](std::span<const Ray> rays, std::span<const std::uint32_t>) {
                        REQUIRE(!stopped);
                        const std::size_t count = std::min(left, rays.size());
                        left -= count;
                        stopped = count < rays.size();
                        std::vector<Hit> hits;
                        for (const HitBits& bits : run_model(*model, rays.first(count)).hits)
                          hits.push_back(hit_of({}, bits));
                        return hits;
                      });
    Film film(16, 16);
    tracer.render(film);
    CHECK(tracer.stopped());
    std::uint64_t traced = 0;
    for (const std::uint64_t count : tracer.rays()) traced += count;
    CHECK(traced == limit);
    double sum = 0.0;
    for (const glm::vec3& c : film.radiance()) sum += c.x;
    CHECK(std::isfinite(sum));
    if (limit >= 400) CHECK(sum > 0.0);  // some shadow rays came back
  }
}

TEST_CASE("paths: glass in uniform light loses only the paths that are cut") {
  Scene scene;
  scene.background = glm::vec3(1.0F);
  scene.camera = looking({2, 3, 4}, {0, 0, 0}, 30.0F);
  add_box(scene, {-1, -1, -1}, {1, 1, 1}, 0);
  scene.materials = {{.diffuse = glm::vec3(0.0F), .transmission = glm::vec3(1.0F)}};
  const double mean =
      picture_of(scene, {.width = 24, .height = 16, .spp = 64, .bounces = 60}, "auto").mean().x;
  CHECK(mean < 1.0 + 1e-6);
  CHECK(mean > 0.97);
}

TEST_CASE("paths: in a closed room that shines everywhere light adds up as a geometric series") {
  // 1 + 1/2 + 1/4 + 1/8 + 1/16 for four scatterings.
  Material walls{.diffuse = glm::vec3(0.0F), .emission = glm::vec3(1.0F)};
  SUBCASE("mirror walls, exactly") {
    walls.specular = glm::vec3(0.5F);
    const Picture picture = picture_of(closed_room(walls), {.width = 16, .height = 16}, "auto");
    for (const glm::vec3& c : picture.radiance) CHECK(c.x == doctest::Approx(1.9375));
  }
  SUBCASE("matt walls, in the mean") {
    walls.diffuse = glm::vec3(0.5F);
    const Picture picture =
        picture_of(closed_room(walls), {.width = 32, .height = 32, .spp = 64}, "auto");
    CHECK(picture.mean().x == doctest::Approx(1.9375).epsilon(0.01));
  }
  SUBCASE("glossy walls, in the mean, whichever way the lamp is found") {
    walls.specular = glm::vec3(0.5F);
    walls.roughness = 0.5F;
    const FilmSize size{.width = 32, .height = 32, .spp = 64, .bounces = 1};
    const double both = picture_of(closed_room(walls), size, "auto").mean().x;
    const double by_light = picture_of(closed_room(walls), size, "auto-glossy").mean().x;
    CHECK(both == doctest::Approx(by_light).epsilon(0.02));
    // A surface this rough reflects 0.68 to 0.79 of the half that it does not absorb.
    CHECK(both < 1.0 + 0.5 * 0.79);
    CHECK(both > 1.0 + 0.5 * 0.67);
  }
}

TEST_CASE("paths: a floor under a square lamp is as bright as the formula says") {
  // Irradiance on the axis of a square of half side a at distance h, radiance 1 (Lambert):
  // E = 4 a / sqrt(a^2 + h^2) * atan(a / sqrt(a^2 + h^2)).
  Scene scene;
  scene.materials = {{.diffuse = glm::vec3(0.8F)},
                     {.diffuse = glm::vec3(0.0F), .emission = glm::vec3(1.0F)}};
  add_quad(scene, {{{-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}}}, 0);
  add_quad(scene, {{{-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}}}, 1);
  scene.camera = looking({3, 1, 0}, {0, 0, 0}, 0.5F);
  const double side = std::sqrt(1.0 + 4.0);
  const double expected = 0.8 / kPi * 4.0 / side * std::atan(1.0 / side);
  for (const char* effects : {"auto", "all"}) {
    const Picture picture = picture_of(scene, {.width = 8, .height = 8, .spp = 256}, effects);
    CHECK(picture.mean().x == doctest::Approx(expected).epsilon(0.005));
  }
}

TEST_CASE("paths: a light that lies on a wall shines from there") {
  Scene scene;
  scene.materials = {{.diffuse = glm::vec3(1.0F)}};
  add_quad(scene, {{{-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}}}, 0);
  scene.lights = {{.position = {0.0F, 1.7F, 0.0F}, .intensity = glm::vec3(1.0F)}};
  scene.camera = looking({3, 1, 0}, {0, 0, 0}, 20.0F);
  const FilmSize size{.width = 16, .height = 16, .spp = 1, .bounces = 1};
  const Picture open = picture_of(scene, size, "auto");
  add_quad(scene, {{{-9, 1.7F, -9}, {9, 1.7F, -9}, {9, 1.7F, 9}, {-9, 1.7F, 9}}}, 0);
  check_same(picture_of(scene, size, "auto"), open);
  CHECK(open.mean().x == doctest::Approx(1.0 / (1.7 * 1.7) / kPi).epsilon(0.1));
}

TEST_CASE("paths: what a plan leaves out changes no bit of the picture") {
  Scene scene = still_life();
  SUBCASE("all kinds of lights and surfaces") {}
  SUBCASE("one scattering") {}
  SUBCASE("a lamp alone") { scene.lights.clear(); }
  SUBCASE("a bulb alone") { scene.materials[1].emission = glm::vec3(0.0F); }
  SUBCASE("a sky") {
    scene.background = {0.2F, 0.3F, 0.5F};
    scene.mesh.triangles.erase(scene.mesh.triangles.begin() + 6, scene.mesh.triangles.begin() + 8);
    scene.mesh.material.erase(scene.mesh.material.begin() + 6, scene.mesh.material.begin() + 8);
  }
  SUBCASE("no light at all") {
    scene.lights.clear();
    scene.materials[1].emission = glm::vec3(0.0F);
  }
  SUBCASE("matt surfaces") {
    for (std::size_t m = 2; m < scene.materials.size(); ++m)
      scene.materials[m] = scene.materials[0];
  }
  for (const int bounces : {0, 1, 2, 5}) {
    const FilmSize size{.width = 16, .height = 12, .spp = 2, .bounces = bounces};
    const Picture some = picture_of(scene, size, "auto");
    const Picture all = picture_of(scene, size, "all");
    check_same(some, all);
    for (std::size_t kind = 0; kind < kRayKinds; ++kind) CHECK(some.rays[kind] <= all.rays[kind]);
    for (const Picture& picture : {some, all}) {
      std::uint64_t traced = 0;
      for (const std::uint64_t count : picture.rays) traced += count;
      CHECK(traced <= picture.plan.rays());
    }
  }
}

TEST_CASE("paths: a scene lit from the eye costs its primary rays, to the ray") {
  Scene scene = still_life();
  scene.lights.clear();
  scene.materials[1].emission = glm::vec3(0.0F);
  const Picture picture = picture_of(scene, {.width = 16, .height = 12, .spp = 3}, "auto");
  CHECK(picture.count(RayKind::Primary) == 16 * 12 * 3);
  std::uint64_t all = 0;
  for (const std::uint64_t count : picture.rays) all += count;
  CHECK(all == 16 * 12 * 3);
  CHECK(picture.mean().x > 0.05);
}

TEST_CASE("paths: a point light costs a shadow ray for each hit that it can reach") {
  Scene scene;
  scene.materials = {{.diffuse = glm::vec3(0.5F)}};
  add_quad(scene, {{{-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}}}, 0);
  scene.camera = looking({3, 1, 0}, {0, 0, 0}, 20.0F);
  scene.lights = {{.position = {0, 2, 0}}, {.position = {0, -2, 0}}};
  const FilmSize size{.width = 16, .height = 16, .spp = 1, .bounces = 1};
  const Picture picture = picture_of(scene, size, "auto");
  CHECK(picture.count(RayKind::Shadow) == 256);  // of the light above; the other is behind
  CHECK(picture_of(scene, size, "all").count(RayKind::Shadow) == 2 * 256);
  CHECK(picture_of(scene, size, "none").count(RayKind::Shadow) == 0);
  CHECK(picture.count(RayKind::Diffuse) == 0);
}

TEST_CASE("paths: a camera inside glass and one in a corner see numbers") {
  Scene scene = still_life();
  for (const glm::vec3& eye : {glm::vec3(0, -1.5F, 0.5F), glm::vec3(-1.999F, -1.999F, 1.999F)}) {
    scene.camera = looking(eye, {0.4F, 0, -1}, 120.0F);
    for (const glm::vec3& c :
         picture_of(scene, {.width = 16, .height = 16, .spp = 2}, "auto").radiance)
      CHECK(finite(c));
  }
}

TEST_CASE("paths: ambient occlusion is the share of directions that are open") {
  Scene scene;
  scene.materials = {{.diffuse = glm::vec3(0.2F)}};
  add_quad(scene, {{{-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}}}, 0);
  scene.camera = looking({3, 1, 0}, {0, 0, 0}, 10.0F);
  const Picture open = picture_of(scene, {.width = 8, .height = 8, .spp = 4}, "ao");
  for (const glm::vec3& c : open.radiance) CHECK(c == glm::vec3(1.0F));
  CHECK(open.count(RayKind::Occlusion) == 8 * 8 * 4);
  // A wall as far away as the rays are long, and a tenth of it.
  add_quad(scene, {{{-9, 0.1F, -9}, {9, 0.1F, -9}, {9, 0.1F, 9}, {-9, 0.1F, 9}}}, 0);
  scene.camera = looking({0, 0.05F, 0}, {0, 0, 0.001F}, 60.0F);
  const double share = picture_of(scene, {.width = 16, .height = 16, .spp = 64}, "ao").mean().x;
  // Rays of length 1 whose cosine is below 0.1 pass under it: 0.1^2 by cosine-distributed rays.
  CHECK(share == doctest::Approx(0.01).epsilon(0.2));
}

TEST_CASE("paths: dim paths that end at random change no mean") {
  Scene scene = still_life();
  scene.materials[3] = scene.materials[0];  // no caustics, whose noise would hide it
  scene.materials[2] = scene.materials[0];
  const FilmSize size{.width = 24, .height = 24, .spp = 64, .bounces = 6};
  const Picture whole = picture_of(scene, size, "auto");
  const Picture ended = picture_of(scene, size, "auto+roulette");
  CHECK(ended.mean().y == doctest::Approx(whole.mean().y).epsilon(0.01));
  CHECK(ended.count(RayKind::Diffuse) < whole.count(RayKind::Diffuse) * 9 / 10);
}

TEST_CASE("paths: a lens blurs what is not in its focus") {
  Scene scene;
  scene.materials = {{.diffuse = glm::vec3(0.0F), .emission = glm::vec3(1.0F)}};
  add_quad(scene, {{{-9, -9, 0}, {0, -9, 0}, {0, 9, 0}, {-9, 9, 0}}}, 0);  // an edge at x = 0
  scene.camera = {.eye = {0, 0, 4}, .target = {0, 0, 0}, .fov_y_deg = 20.0F};
  const auto grey = [&scene] {
    const Picture picture = picture_of(scene, {.width = 33, .height = 33, .spp = 64}, "auto");
    int count = 0;
    for (const glm::vec3& c : picture.radiance) count += c.x > 0.02F && c.x < 0.98F ? 1 : 0;
    return count;
  };
  const int sharp = grey();
  scene.camera.aperture = 0.5F;
  CHECK(grey() == sharp);  // in focus, at the target
  scene.camera.focus_distance = 2.0F;
  // An edge at twice the focus is blurred over the aperture, a third of the picture.
  CHECK(grey() > sharp + 33 * 6);
}

}  // namespace
}  // namespace ti
