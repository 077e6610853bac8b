// SPDX-License-Identifier: Apache-2.0
// Each rule of the machine plan has facts that just call for a key and facts that just do not.
#include <doctest/doctest.h>

#include <algorithm>

#include "render/machine_plan.hpp"
#include "test/picture.hpp"

namespace ti {
namespace {

/// A machine with an L2 of each kind.
Config base() {
  Config config;
  config.trv_l2_bytes = config.list_l2_bytes = config.ist1_l2_bytes = 1 << 17;
  return config;
}

/// A tree for a stack of four, and an image that no L1 holds.
MachineFacts facts() {
  MachineFacts f;
  f.bounds = TreeBounds{.stack = 4, .nodes = 40000, .steps = 100000};
  f.parts.node_count = f.parts.list_count = f.parts.triangle_count = 40000;
  f.extent = 10.0;
  return f;
}

/// A plan of these effects with a ray for each.
Plan plan_with(std::initializer_list<Effect> effects) {
  Plan plan;
  for (const Effect effect : effects)
    plan.decisions.push_back({.effect = effect, .on = true, .rays = 1});
  return plan;
}

MachineDecision decision(const MachineFacts& f, const std::string& what,
                         const Config& config = base(), const Plan& plan = {}) {
  const MachinePlan made = make_machine_plan(f, plan, config);
  return *std::find_if(made.decisions.begin(), made.decisions.end(),
                       [&what](const MachineDecision& d) { return d.what == what; });
}

TEST_CASE("machine plan: any-hit rays, where an effect traces one") {
  for (const Effect effect : {Effect::Shadows, Effect::SoftShadows, Effect::AmbientOcclusion}) {
    Plan plan = plan_with({Effect::Mirror, effect});
    CHECK(decision(facts(), "any-hit rays", base(), plan).on);
    CHECK(decision(facts(), "any-hit rays", base(), plan).set.empty());
    plan.decisions[1].rays = 0;  // it is on, and no ray is traced for it
    CHECK(decision(facts(), "any-hit rays", base(), plan).set == "any_hit=false");
    plan.decisions[1].rays = 1;
    plan.decisions[1].on = false;
    CHECK(!decision(facts(), "any-hit rays", base(), plan).on);
  }
  const Plan lobes = plan_with(
      {Effect::Interreflection, Effect::Glossy, Effect::Mirror, Effect::Glass, Effect::Lens});
  CHECK(decision(facts(), "any-hit rays", base(), lobes).set == "any_hit=false");
}

TEST_CASE("machine plan: the plans of pictures say which rays end at any hit") {
  Scene scene;
  scene.materials = {{.name = "floor"}};
  test::add_quad(scene, {{{-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}}}, 0);
  const auto first = [&scene](const std::string& effects) {
    return any_hit_effect(make_plan(scene, {}, EffectRequest::of(effects)));
  };
  CHECK(!first("auto"));  // lit from the eye
  CHECK(!first("all"));
  CHECK(first("ao") == Effect::AmbientOcclusion);
  scene.lights = {{.name = "bulb", .position = {0, 5, 0}}};
  CHECK(first("auto") == Effect::Shadows);
  CHECK(!first("none"));
  CHECK(!first("auto-shadows"));
  scene.lights.clear();
  scene.materials[0].emission = glm::vec3(1.0F);
  CHECK(first("auto") == Effect::SoftShadows);
}

TEST_CASE("machine plan: no restarts, where the stack of the base has room for every entry") {
  MachineFacts f = facts();
  CHECK(decision(f, "restarts").set == "restart=false stack_depth=4");
  CHECK(!decision(f, "restarts").on);
  f.bounds->stack = 3;
  CHECK(decision(f, "restarts").set == "restart=false stack_depth=3");
  f.bounds->stack = 5;
  CHECK(decision(f, "restarts").set.empty());
  CHECK(decision(f, "restarts").on);
  f.bounds.reset();
  CHECK(decision(f, "restarts").on);
}

TEST_CASE("machine plan: a smaller watchdog, where that saves a bit and ends no ray") {
  MachineFacts f = facts();
  f.bounds->nodes = 32767;
  CHECK(decision(f, "watchdog").set == "watchdog_steps=32767");
  f.bounds->nodes = 32768;  // as many bits as the base has
  CHECK(decision(f, "watchdog").set.empty());
  f.bounds->nodes = 100;
  f.bounds->stack = 5;  // rays restart
  CHECK(decision(f, "watchdog").set.empty());
  f.bounds->steps = 200;
  CHECK(decision(f, "watchdog").set == "watchdog_steps=255");  // as many bits
  f.bounds.reset();
  CHECK(decision(f, "watchdog").set.empty());
}

TEST_CASE("machine plan: no L2 of a kind of unit, where each of its L1s holds what it reads") {
  MachineFacts f = facts();
  f.parts.node_count = 1024;  // 8 bytes each, in 8192
  CHECK(decision(f, "L2 of trv").set == "trv_l2_bytes=0");
  CHECK(decision(f, "L2 of trv").cycles == 128U * 24 * 101);
  f.parts.node_count = 1025;
  CHECK(decision(f, "L2 of trv").set.empty());
  CHECK(decision(f, "L2 of trv").cycles == 0);

  f.parts.list_count = 1024;  // 4 bytes each, in 4096
  CHECK(decision(f, "L2 of list").set == "list_l2_bytes=0");
  f.parts.list_count = 1025;
  CHECK(decision(f, "L2 of list").set.empty());

  // 16384 bytes in 4 ways of 64 sets: plane parts may take three lines of a set, the others one.
  f.parts.triangle_count = 256;
  CHECK(decision(f, "L2 of ist1").set == "ist1_l2_bytes=0");
  f.parts.triangle_count = 257;  // the bytes fit, and the lines of a set do not
  CHECK(decision(f, "L2 of ist1").set.empty());

  Config none = base();
  none.trv_l2_bytes = 0;
  f.parts.node_count = 1;
  CHECK(decision(f, "L2 of trv", none).set.empty());
}

TEST_CASE("machine plan: memory counts for cold misses alone, where the caches hold the image") {
  MachineFacts f = facts();
  f.parts.node_count = 16384;  // 128 KB, the L2
  f.parts.list_count = 1024;   // 4 KB, the L1
  f.parts.triangle_count = 256;
  CHECK(!decision(f, "timing of memory").on);
  f.parts.node_count = 16385;
  CHECK(decision(f, "timing of memory").on);
}

TEST_CASE("machine plan: rescaling is told where the image is scaled, and changes no hit") {
  MachineFacts f = facts();
  f.extent = 1e19;
  CHECK(!decision(f, "rescaling").on);
  CHECK(decision(f, "rescaling").bound.find("no hit") != std::string::npos);
  f.scale = -27;
  CHECK(decision(f, "rescaling").on);
  CHECK(decision(f, "rescaling").reason.find("2^-27") != std::string::npos);
  CHECK(decision(f, "rescaling").bound.find("no hit") != std::string::npos);
  CHECK(decision(f, "rescaling").set.empty());
}

TEST_CASE("machine plan: keys of decisions are joined as SET= has them") {
  MachineFacts f = facts();
  f.bounds->nodes = 50;
  f.parts = {};
  CHECK(make_machine_plan(f, {}, base()).set() ==
        "any_hit=false restart=false stack_depth=4 watchdog_steps=63 trv_l2_bytes=0 "
        "list_l2_bytes=0 ist1_l2_bytes=0");
  CHECK(make_machine_plan({}, plan_with({Effect::Shadows}), Config{}).set().empty());
}

}  // namespace
}  // namespace ti
