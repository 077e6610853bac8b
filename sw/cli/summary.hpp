// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "report/report.hpp"

namespace ti {

/// Prints what people want to know of the scene and its tree.
void print_tree(const Session& session);

/// Prints what is simulated of a picture, what is not, and why.
void print_plan(const Plan& plan);

/// Prints a line of a frame of an animation.
void print_frame(const FrameReport& frame);

/// Prints what a picture calls for on the ground of `base`; `built` is the machine that traces.
void print_machine_plan(const MachinePlan& plan, const Config& base, const Config& built);

/// Prints what people read of a run.
void print_summary(const Report& report, const Session& session);

}  // namespace ti
