# SPDX-License-Identifier: Apache-2.0
#
# What a project needs beyond files: ports are virtual pins, and assertions are left out, since Quartus does
# not define SYNTHESIS by itself.
set_global_assignment -name VERILOG_MACRO "SYNTHESIS=1"
set_instance_assignment -name VIRTUAL_PIN ON -to *
foreach clock {aclk axis*_aclk} {
  set_instance_assignment -name VIRTUAL_PIN OFF -to $clock
}
