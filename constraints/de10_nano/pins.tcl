# SPDX-License-Identifier: Apache-2.0
#
# For a top of the board (MODE=full) that calls its clock, reset and interrupt as ti_top_wrapper does:
# memory and streams end inside of it, there are not pins enough for them.

# FPGA_CLK1_50; KEY0, low when pressed; LED0.
foreach {port pin} {
  aclk    PIN_V11
  aresetn PIN_AH17
  irq     PIN_W15
} {
  set_location_assignment $pin -to $port
  set_instance_assignment -name IO_STANDARD "3.3-V LVTTL" -to $port
}
