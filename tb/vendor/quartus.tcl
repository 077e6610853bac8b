# SPDX-License-Identifier: Apache-2.0
#
# Stands in for Quartus Prime: its commands as scripts and constraints of this project use them.

array set quartus {version "Version 23.1std"}
set quartus(args) $argv

ti_stand_in {
  load_package project_new project_close set_global_assignment export_assignments
  execute_flow load_report unload_report set_net_delay set_max_skew derive_clock_uncertainty
}

# Assignments to pins name ports.
foreach command {set_location_assignment set_instance_assignment} {
  proc $command {args} "
    global ti_ports
    ti_record $command {*}\$args
    set at \[lsearch \$args -to\]
    ti_found $command \[lindex \$args \$at+1\] \[ti_match \[lindex \$args \$at+1\] \$ti_ports\] \[string match *\\\\** \$args\]
  "
}

# Panels of reports, by rows.
set ti_panels(Fitter||Fitter\ Summary) {
  {{Fitter Status} Successful}
  {{Logic utilization (in ALMs)} {12,345 / 41,910 ( 29 % )}}
  {{Total registers} 23456}
  {{Total block memory bits} {1,024 / 5,662,720 ( < 1 % )}}
  {{Total RAM Blocks} {7 / 553 ( 1 % )}}
  {{Total DSP Blocks} {8 / 112 ( 7 % )}}
}
set ti_panels(Timing\ Analyzer||Slow\ 1100mV\ 85C\ Model\ Fmax\ Summary) {
  {Fmax {Restricted Fmax} {Clock Name} Note}
  {{61.25 MHz} {61.25 MHz} aclk {}}
}
set ti_panels(Timing\ Analyzer||Slow\ 1100mV\ 0C\ Model\ Fmax\ Summary) {
  {Fmax {Restricted Fmax} {Clock Name} Note}
  {{62.5 MHz} {62.5 MHz} aclk {}}
  {{50.0 MHz} {50.0 MHz} axis00_aclk {}}
}
proc get_report_panel_names {} {
  global ti_panels
  return [array names ti_panels]
}
proc get_number_of_rows {-name panel} {
  global ti_panels
  return [llength $ti_panels($panel)]
}
proc get_report_panel_row {-name panel -row row} {
  global ti_panels
  return [lindex $ti_panels($panel) $row]
}

# Collections are lists here.
proc foreach_in_collection {variable collection body} {
  uplevel 1 [list foreach $variable $collection $body]
}
proc get_collection_size {collection} {
  return [llength $collection]
}
proc ti_query {command names words} {
  lassign [ti_options -nowarn $words] option patterns
  set found {}
  foreach pattern [join $patterns] {
    set found [concat $found [ti_found $command $pattern [ti_match $pattern $names] [dict exists $option -nowarn]]]
  }
  return $found
}
proc get_ports {args} {
  return [ti_query get_ports $::ti_ports $args]
}
proc get_registers {args} {
  return [ti_query get_registers $::ti_cells $args]
}
proc get_keepers {args} {
  return [ti_query get_keepers $::ti_cells $args]
}
proc get_clocks {args} {
  return [ti_query get_clocks [array names ::ti_periods] $args]
}
proc get_clock_info {-period clock} {
  return $::ti_periods($clock)
}
proc get_port_info {-name port} {
  return $port
}
proc all_inputs {} {
  return $::ti_inputs
}
proc all_outputs {} {
  set names {}
  foreach name $::ti_ports {
    if {$name ni $::ti_inputs} {
      lappend names $name
    }
  }
  return $names
}
