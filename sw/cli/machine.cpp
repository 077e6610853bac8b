// SPDX-License-Identifier: Apache-2.0
#include "cli/machine.hpp"

#include <fmt/core.h>

#include "cli/summary.hpp"
#include "io/file.hpp"

namespace ti {

int machine(Arguments& arguments) {
  arguments.keys = arguments.run.out;
  arguments.run.out = arguments.keys.parent_path();
  arguments.run.engine = EngineKind::Model;
  arguments.run.truth = false;
  arguments.progress = false;
  return render(arguments);
}

int write_keys(const Arguments& arguments, const Session& session, const Plan& plan) {
  const Config& base = session.options().config;
  const MachineFacts facts = machine_facts(session.image(), session.options().rtl);
  const std::string set = make_machine_plan(facts, plan, base).set();
  write_file(arguments.keys, set + "\n");
  fmt::print("auto: {} with {}\n", base.name, set.empty() ? "nothing changed" : set);
  return kGood;
}

MachinePlan machine_plan_of(const Arguments& arguments, const Session& session, const Plan& plan) {
  const bool given = !arguments.base_file.empty();
  const Config& built = session.options().config;
  const Config base = given ? load_config(arguments.base_file) : built;
  const MachineFacts facts = machine_facts(session.image(), session.options().rtl);
  MachinePlan machine_plan = make_machine_plan(facts, plan, base);
  if (given) print_machine_plan(machine_plan, base, built);
  if (const auto effect = any_hit_effect(plan))
    session.require_any_hit(fmt::format("rays of {}", name_of(*effect)));
  return machine_plan;
}

}  // namespace ti
