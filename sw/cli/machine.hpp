// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cli/commands.hpp"
#include "render/machine_plan.hpp"

namespace ti {

/// Writes the keys that a plan calls for on the ground of the configuration of `session`; the exit
/// status.
int write_keys(const Arguments& arguments, const Session& session, const Plan& plan);

/// What the plan calls for, printed when a base was named. Throws `Error` for a machine that
/// cannot trace the rays of the plan.
[[nodiscard]] MachinePlan machine_plan_of(const Arguments& arguments, const Session& session,
                                          const Plan& plan);

}  // namespace ti
