# SPDX-License-Identifier: Apache-2.0
#
# For Quartus: ports of ti_top_wrapper that meet no pin (virtual pins).  Behind the create_clock of
# `aclk` in the board's file.
#
# A port may use TI_IO_SHARE of the period of its clock outside of the block on either side, as a
# register next to it and the way there would.

set TI_IO_SHARE 0.4
set ti_period [get_clock_info -period [get_clocks aclk]]

# With stream_clock=own, each stream has a clock, here as fast as aclk.
foreach_in_collection port [get_ports -nowarn axis*_aclk] {
  set name [get_port_info -name $port]
  create_clock -name $name -period $ti_period [get_ports $name]
}

derive_clock_uncertainty

# The clock of a port that is not a clock.
proc ti_clock_of {name} {
  if {[regexp {^[sm](\d+)_axis_} $name -> stream] &&
      [get_collection_size [get_clocks -nowarn axis${stream}_aclk]]} {
    return axis${stream}_aclk
  }
  return aclk
}

foreach direction {input output} ports [list [all_inputs] [all_outputs]] {
  array unset ti_group
  foreach_in_collection port $ports {
    set name [get_port_info -name $port]
    if {![string match *aclk $name]} {
      lappend ti_group([ti_clock_of $name]) $name
    }
  }
  foreach {clock names} [array get ti_group] {
    set period [get_clock_info -period [get_clocks $clock]]
    set_${direction}_delay -clock $clock [expr {$TI_IO_SHARE * $period}] [get_ports $names]
  }
}
