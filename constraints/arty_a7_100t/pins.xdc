# SPDX-License-Identifier: Apache-2.0
#
# For a top of the board (MODE=full) that calls its clock, reset and interrupt as ti_top_wrapper does:
# memory and streams end inside of it, there are not pins enough for them.

# Oscillator of 100 MHz; the button RESET, low when pressed; LED LD4.
set_property -dict {PACKAGE_PIN E3 IOSTANDARD LVCMOS33} [get_ports aclk]
set_property -dict {PACKAGE_PIN C2 IOSTANDARD LVCMOS33} [get_ports aresetn]
set_property -dict {PACKAGE_PIN H5 IOSTANDARD LVCMOS33} [get_ports irq]

# A button and an LED have no clock: the top puts a synchroniser behind the button.
set_false_path -from [get_ports aresetn]
set_false_path -to [get_ports irq]

set_property CFGBVS VCCO [current_design]
set_property CONFIG_VOLTAGE 3.3 [current_design]
