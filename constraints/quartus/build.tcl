# SPDX-License-Identifier: Apache-2.0
#
# Quartus Prime: a block that `make ip` wrote, from sources to a routed design and reports.
#
#   quartus_sh -t constraints/quartus/build.tcl folder=build/ip/tiny board=de10_nano out=OUT
#
#   folder=   what `make ip` wrote, and scripts/plain_verilog.py where board.tcl asks for it
#   board=    a folder beside this one
#   part=     another part of the same family
#   out=      folder for the project, reports and summary.json
#   mode=     ooc: ti_top_wrapper alone, its ports virtual pins; full: a top of the board, with its pins
#   top=      full: that module
#   sources=  full: its files, behind those of the block

source [file join [file dirname [file normalize [info script]]] .. common arguments.tcl]
array set option [ti_arguments $quartus(args) {
  folder "" board "" part "" out "" mode ooc top ti_top_wrapper sources ""
} {folder board out}]
set here [ti_board $option(board) quartus]
source [file join $here board.tcl]
if {$option(part) ne ""} {
  set part $option(part)
}
set common [file join $ti_constraints common]
lassign [ti_sources [file normalize $option(folder)] $list] folders files
foreach file $option(sources) {
  lappend files [file normalize $file]
}
file mkdir $option(out)
cd $option(out)

# --- Project ----------------------------------------------------------------------------------------

load_package flow
load_package report
project_new ti -overwrite
set_global_assignment -name FAMILY $family
set_global_assignment -name DEVICE $part
set_global_assignment -name TOP_LEVEL_ENTITY $option(top)
set_global_assignment -name PROJECT_OUTPUT_DIRECTORY output_files
set_global_assignment -name NUM_PARALLEL_PROCESSORS ALL
# Quartus does not define it by itself; without, assertions would be read.
set_global_assignment -name VERILOG_MACRO "SYNTHESIS=1"
foreach folder $folders {
  set_global_assignment -name SEARCH_PATH $folder
}
foreach file $files {
  if {[file extension $file] eq ".sv"} {
    set_global_assignment -name SYSTEMVERILOG_FILE $file
  } else {
    set_global_assignment -name VERILOG_FILE $file
  }
}
set_global_assignment -name SDC_FILE [file join $here clock.sdc]
if {$option(mode) eq "ooc"} {
  set_global_assignment -name SDC_FILE [file join $common quartus_ports.sdc]
  set_instance_assignment -name VIRTUAL_PIN ON -to *
  foreach clock {aclk axis*_aclk} {
    set_instance_assignment -name VIRTUAL_PIN OFF -to $clock
  }
} else {
  source [file join $here pins.tcl]
}
set_global_assignment -name SDC_FILE [file join $common quartus_crossings.sdc]
export_assignments

# --- Synthesis, place, route, timing ----------------------------------------------------------------

execute_flow -compile

# --- Summary ----------------------------------------------------------------------------------------

load_report
# The value beside a name in a panel of two columns, up to a slash; "" when there is none.
proc value {panel name} {
  for {set row 0} {$row < [get_number_of_rows -name $panel]} {incr row} {
    lassign [get_report_panel_row -name $panel -row $row] key text
    if {[string match $name $key]} {
      return [string map {, ""} [string trim [lindex [split $text /] 0]]]
    }
  }
  return ""
}
# The least clock over all corners.
set mhz ""
foreach panel [get_report_panel_names] {
  if {![string match "*Fmax Summary" $panel]} continue
  for {set row 1} {$row < [get_number_of_rows -name $panel]} {incr row} {
    lassign [get_report_panel_row -name $panel -row $row] clock restricted name
    set clock [lindex $clock 0]
    if {$name eq "aclk" && ($mhz eq "" || $clock < $mhz)} {
      set mhz $clock
    }
  }
}
set panel "Fitter||Fitter Summary"
set pairs [list \
  tool "Quartus Prime $quartus(version)" part $part board $option(board) mode $option(mode) \
  top $option(top) mhz $mhz \
  alm [value $panel "Logic utilization*"] \
  ff [value $panel "Total registers"] \
  ram_bits [value $panel "Total block memory bits"] \
  ram_blocks [value $panel "Total RAM Blocks"] \
  dsp [value $panel "Total DSP Blocks"]]
ti_json summary.json $pairs
foreach {key text} $pairs {
  puts "$key $text"
}
unload_report
project_close
