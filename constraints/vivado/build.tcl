# SPDX-License-Identifier: Apache-2.0
#
# Vivado, without a project: a block that `make ip` wrote, from sources to a routed design and reports.
#
#   vivado -mode batch -source constraints/vivado/build.tcl -tclargs folder=build/ip/tiny board=kv260 out=OUT
#
#   folder=   what `make ip` wrote
#   board=    a folder beside this one
#   part=     another part than the board's
#   out=      folder for checkpoints, reports and summary.json
#   mode=     ooc: ti_top_wrapper alone, out of context; full: a top of the board, with its pins
#   top=      full: that module
#   sources=  full: its files, behind those of the block

source [file join [file dirname [file normalize [info script]]] .. common arguments.tcl]
array set option [ti_arguments $argv {
  folder "" board "" part "" out "" mode ooc top ti_top_wrapper sources ""
} {folder board out}]
set here [ti_board $option(board) vivado]
source [file join $here board.tcl]
if {$option(part) ne ""} {
  set part $option(part)
}
set common [file join $ti_constraints common]
file mkdir $option(out)
proc out {name} {
  global option
  return [file join $option(out) $name]
}

# --- Sources and constraints of ports ---------------------------------------------------------------

create_project -in_memory -part $part
lassign [ti_sources $option(folder) ti_top_wrapper.f] folders files
foreach file [concat $files $option(sources)] {
  if {[file extension $file] eq ".sv"} {
    read_verilog -sv $file
  } else {
    read_verilog $file
  }
}
if {$option(mode) eq "ooc"} {
  read_xdc [file join $here clock.xdc]
  read_xdc -unmanaged [file join $common vivado_ports.tcl]
  set how {-mode out_of_context}
} else {
  foreach name {clock.xdc pins.xdc} {
    read_xdc [file join $here $name]
  }
  set how {}
}

# --- Synthesis, place, route ------------------------------------------------------------------------

synth_design -top $option(top) -part $part {*}$how -include_dirs $folders -verilog_define SYNTHESIS
read_xdc -unmanaged [file join $common vivado_crossings.tcl]
set floorplan [file join $here floorplan.tcl]
if {[file isfile $floorplan]} {
  read_xdc -unmanaged $floorplan
}
write_checkpoint -force [out synth.dcp]
report_utilization -hierarchical -file [out synth_utilization.rpt]

opt_design
place_design
phys_opt_design
route_design
write_checkpoint -force [out route.dcp]

# --- Reports ----------------------------------------------------------------------------------------

report_timing_summary -file [out timing_summary.rpt]
report_timing -max_paths 10 -nworst 1 -unique_pins -sort_by group -file [out timing.rpt]
report_utilization -file [out utilization.rpt]
report_utilization -hierarchical -file [out utilization_hierarchical.rpt]
report_clock_interaction -file [out clock_interaction.rpt]
report_cdc -details -file [out cdc.rpt]
report_bus_skew -file [out bus_skew.rpt]
report_methodology -file [out methodology.rpt]
report_drc -file [out drc.rpt]

# Used sites of the first row of the report that has one of these names; they differ by family.
proc used {report args} {
  foreach name $args {
    if {[regexp "\\|\\s*$name\\*?\\s*\\|\\s*(\[\\d.\]+)" $report -> count]} {
      return $count
    }
  }
  return ""
}
set report [report_utilization -return_string]
set period [get_property PERIOD [get_clocks aclk]]
set setup [get_property SLACK [get_timing_paths -setup -max_paths 1 -group aclk]]
set hold [get_property SLACK [get_timing_paths -hold -max_paths 1]]
set pairs [list \
  tool "Vivado [version -short]" part $part board $option(board) mode $option(mode) top $option(top) \
  period_ns $period setup_slack_ns $setup hold_slack_ns $hold \
  mhz [format %.1f [expr {1000.0 / ($period - $setup)}]] \
  lut [used $report "CLB LUTs" "Slice LUTs"] \
  lut_ram [used $report "LUT as Memory"] \
  ff [used $report "CLB Registers" "Slice Registers"] \
  bram [used $report "Block RAM Tile"] \
  uram [used $report "URAM"] \
  dsp [used $report "DSPs"]]
ti_json [out summary.json] $pairs
foreach {key value} $pairs {
  puts "$key $value"
}
