# SPDX-License-Identifier: Apache-2.0
#
# For Vivado: ports of ti_top_wrapper that meet no pin, out of context.  Behind the create_clock of
# `aclk` in the board's file; before synthesis, by read_xdc -unmanaged.
#
# A port may use TI_IO_SHARE of the period of its clock outside of the block on either side, as a
# register next to it and the way there would.

set TI_IO_SHARE 0.4

# With stream_clock=own, each stream has a clock; where the board's file makes none, it is as fast as aclk.
foreach port [get_ports -quiet axis*_aclk] {
  if {![llength [get_clocks -quiet $port]]} {
    create_clock -name $port -period [get_property PERIOD [get_clocks aclk]] $port
  }
}

# The clock of a port that is not a clock.
proc ti_clock_of {port} {
  if {[regexp {^[sm](\d+)_axis_} $port -> stream] && [llength [get_clocks -quiet axis${stream}_aclk]]} {
    return axis${stream}_aclk
  }
  return aclk
}

foreach direction {IN OUT} command {set_input_delay set_output_delay} {
  array unset ti_group
  foreach port [get_ports -filter "DIRECTION == $direction"] {
    if {![string match *aclk $port]} {
      lappend ti_group([ti_clock_of $port]) $port
    }
  }
  foreach {clock ports} [array get ti_group] {
    set period [get_property PERIOD [get_clocks $clock]]
    $command -clock $clock [expr {$TI_IO_SHARE * $period}] [get_ports $ports]
  }
}
