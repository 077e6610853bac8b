# SPDX-License-Identifier: Apache-2.0
#
# What a project, as FuseSoC makes it, needs beyond files: out of context, and crossings behind synthesis,
# when registers have their names.
set_property -name {STEPS.SYNTH_DESIGN.ARGS.MORE OPTIONS} -value {-mode out_of_context} -objects [get_runs synth_1]
set_property used_in_synthesis false [get_files vivado_crossings.tcl]
