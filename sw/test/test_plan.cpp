// SPDX-License-Identifier: Apache-2.0
// Each rule of the plan has a scene that just calls for the effect and one that just does not.
#include <algorithm>

#include "base/error.hpp"
#include "render/plan.hpp"
#include "test/picture.hpp"

namespace ti {
namespace {

/// A floor of the first material and a body of the second.
Scene scene_of(const Material& body) {
  Scene scene;
  scene.materials = {{.name = "floor", .diffuse = glm::vec3(0.0F)}, body};
  test::add_quad(scene, {{{-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}}}, 0);
  test::add_box(scene, {0, 1, 0}, {1, 2, 1}, 1);
  scene.lights = {{.name = "bulb", .position = {0, 5, 0}}};
  return scene;
}

const Decision& decision(const Plan& plan, Effect effect) {
  return *std::find_if(plan.decisions.begin(), plan.decisions.end(),
                       [effect](const Decision& d) { return d.effect == effect; });
}

Plan plan_of(const Scene& scene, const std::string& effects = "auto", int bounces = 4) {
  return make_plan(scene, {.width = 10, .height = 10, .spp = 2, .bounces = bounces},
                   EffectRequest::of(effects));
}

TEST_CASE("plan: shadows of lights without an area, where there is one that is not black") {
  Scene scene = scene_of({.name = "body"});
  const Plan plan = plan_of(scene);
  CHECK(plan.has(Effect::Shadows));
  CHECK(decision(plan, Effect::Shadows).reason.find("bulb") != std::string::npos);
  CHECK(decision(plan, Effect::Shadows).rays > 0);
  scene.lights[0].intensity = glm::vec3(0.0F);
  CHECK(!plan_of(scene).has(Effect::Shadows));
  scene.lights.clear();
  CHECK(!plan_of(scene).has(Effect::Shadows));
}

TEST_CASE("plan: soft shadows, where a triangle emits") {
  const Material lamp{.name = "lamp", .emission = glm::vec3(1.0F)};
  Scene scene = scene_of(lamp);
  CHECK(plan_of(scene).has(Effect::SoftShadows));
  CHECK(decision(plan_of(scene), Effect::SoftShadows).reason.find("lamp") != std::string::npos);
  scene.mesh.material.assign(scene.mesh.material.size(), 0);  // no triangle has it
  CHECK(!plan_of(scene).has(Effect::SoftShadows));
}

TEST_CASE("plan: motion, where there is more than one frame and something moves in them") {
  const Scene scene = scene_of({.name = "body"});
  const auto with = [&scene](int frames, const Motion& motion, const char* effects = "auto") {
    return make_plan(scene, {.width = 10, .height = 10, .frames = frames},
                     EffectRequest::of(effects), motion);
  };
  CHECK(with(2, {.triangles = 7}).has(Effect::Motion));
  CHECK(decision(with(2, {.triangles = 7}), Effect::Motion).reason.find("7 triangles") !=
        std::string::npos);
  CHECK(with(2, {.camera = true}).has(Effect::Motion));
  CHECK(with(2, {.lights = true}).has(Effect::Motion));
  CHECK(!with(2, {}).has(Effect::Motion));
  CHECK(!with(1, {.triangles = 7}).has(Effect::Motion));
  CHECK(!with(2, {.triangles = 7}, "auto-motion").has(Effect::Motion));
  CHECK(with(2, {.triangles = 7}).primary == 2 * with(1, {}).primary);
}

TEST_CASE("plan: dim paths end, where there is a second sample and light that scatters") {
  Scene scene = scene_of({.name = "body"});
  const auto ends = [&scene](const FilmSize& film, const char* effects = "auto") {
    return make_plan(scene, film, EffectRequest::of(effects)).ends_dim_paths;
  };
  CHECK(ends({.spp = 2}));
  CHECK(!ends({.spp = 1}));
  CHECK(!ends({.spp = 2, .bounces = 0}));
  CHECK(!ends({.spp = 2, .frames = 2}));
  CHECK(!ends({.spp = 2}, "all"));
  CHECK(!ends({.spp = 2}, "auto+dim-paths"));
  scene.lights.clear();  // lit from the eye
  CHECK(!ends({.spp = 2}));
}

TEST_CASE("plan: rays of a lobe, where a triangle has it") {
  struct Case {
    Effect effect;
    Material with;
  };
  const Material black{.name = "body", .diffuse = glm::vec3(0.0F)};
  const auto changed = [&black](auto change) {
    Material m = black;
    change(m);
    return m;
  };
  for (const Case& c :
       {Case{Effect::Interreflection, changed([](Material& m) { m.diffuse.y = 1e-3F; })},
        Case{Effect::Glossy,
             changed([](Material& m) { m.specular.z = 1e-3F, m.roughness = 0.1F; })},
        Case{Effect::Mirror, changed([](Material& m) { m.specular.x = 1e-3F; })},
        Case{Effect::Glass, changed([](Material& m) { m.transmission.x = 1e-3F; })}}) {
    Scene scene = scene_of(c.with);
    CHECK(plan_of(scene).has(c.effect));
    CHECK(decision(plan_of(scene), c.effect).reason.find("body") != std::string::npos);
    CHECK(!plan_of(scene_of(black)).has(c.effect));
    // In no triangle's reach.
    Scene unused = scene;
    unused.mesh.material.assign(scene.mesh.material.size(), 0);
    CHECK(!plan_of(unused).has(c.effect));
    // With one scattering a ray adds only what it meets that emits.
    CHECK(!plan_of(scene, "auto", 1).has(c.effect));
    scene.background.x = 0.1F;
    CHECK(plan_of(scene, "auto", 1).has(c.effect));
    CHECK(!plan_of(scene, "auto", 0).has(c.effect));
    // A light at the eye ends at the first surface.
    scene.background.x = 0.0F;
    scene.lights.clear();
    CHECK(!plan_of(scene).has(c.effect));
  }
}

TEST_CASE("plan: lens samples, where the camera has an aperture") {
  Scene scene = scene_of({});
  CHECK(!plan_of(scene).has(Effect::Lens));
  scene.camera.aperture = 0.01F;
  CHECK(plan_of(scene).has(Effect::Lens));
}

TEST_CASE("plan: a request adds and removes, and says so") {
  const Scene scene = scene_of({.name = "body", .specular = glm::vec3(0.3F)});
  CHECK(plan_of(scene).has(Effect::Mirror));
  CHECK(!plan_of(scene, "auto-mirror").has(Effect::Mirror));
  CHECK(decision(plan_of(scene, "auto-mirror"), Effect::Mirror).bound == "the picture lacks it");
  CHECK(plan_of(scene, "auto-mirror").has(Effect::Shadows));
  CHECK(plan_of(scene, "none").effects.none());
  CHECK(plan_of(scene, "none").rays() == 200);
  CHECK(plan_of(scene, "none+mirror").has(Effect::Mirror));
  CHECK(plan_of(scene, "mirror").effects == plan_of(scene, "none+mirror").effects);
  CHECK(plan_of(scene, "all").everything);
  CHECK(plan_of(scene, "all").has(Effect::Glass));
  CHECK(!plan_of(scene, "all").has(Effect::AmbientOcclusion));
  CHECK(!plan_of(scene, "all").has(Effect::Roulette));
  CHECK(plan_of(scene, "ao").rays() == 400);
  CHECK(plan_of(scene, "auto-soft-shadows+roulette").has(Effect::Roulette));
}

TEST_CASE("plan: a word that is no effect is refused by name") {
  for (const char* text :
       {"glow", "auto+glow", "auto-", "autoglossy", "", "auto-soft", "all+-ao"}) {
    CAPTURE(text);
    try {
      (void)EffectRequest::of(text);
      FAIL("was taken");
    } catch (const Error& error) {
      CHECK(std::string(error.what()).find("EFFECTS=") == 0);
    }
  }
}

}  // namespace
}  // namespace ti
