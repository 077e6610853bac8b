# SPDX-License-Identifier: Apache-2.0
#
# Stands in for Vivado: its commands as scripts and constraints of this project use them.

ti_stand_in {
  create_project read_verilog synth_design opt_design place_design phys_opt_design route_design
  write_checkpoint report_timing_summary report_timing report_clock_interaction report_cdc report_bus_skew
  report_methodology report_drc set_bus_skew set_property create_pblock resize_pblock add_cells_to_pblock
}

# Constraints are recorded, and run once the design is there.
proc read_xdc {args} {
  ti_record read_xdc {*}$args
  uplevel #0 [list source [lindex $args end]]
}

proc report_utilization {args} {
  ti_record report_utilization {*}$args
  return {
| CLB LUTs                   |  1234 |     0 |          0 |    117120 |  1.05 |
|   LUT as Memory            |    56 |     0 |          0 |     57600 |  0.10 |
| CLB Registers              |  2345 |     0 |          0 |    234240 |  1.00 |
| Block RAM Tile             |  10.5 |     0 |          0 |       144 |  7.29 |
| URAM                       |     0 |     0 |          0 |        64 |  0.00 |
| DSPs                       |     4 |     0 |          0 |      1248 |  0.32 |
}
}

proc version {args} {
  return 2024.1
}
proc current_design {} {
  return ti
}
proc get_timing_paths {args} {
  ti_record get_timing_paths {*}$args
  return path
}
proc get_pblocks {args} {
  return {}
}

proc get_ports {args} {
  global ti_ports ti_inputs
  lassign [ti_options {-quiet -filter=} $args] option patterns
  set names {}
  foreach pattern [expr {[llength $patterns] ? [join $patterns] : "*"}] {
    set names [concat $names [ti_found get_ports $pattern [ti_match $pattern $ti_ports] [dict exists $option -quiet]]]
  }
  if {[dict exists $option -filter]} {
    if {![regexp {^DIRECTION == (IN|OUT)$} [dict get $option -filter] -> direction]} {
      error "the stand-in does not know this filter: [dict get $option -filter]"
    }
    set chosen {}
    foreach name $names {
      if {($name in $ti_inputs) == ($direction eq "IN")} {
        lappend chosen $name
      }
    }
    set names $chosen
  }
  return $names
}

proc get_cells {args} {
  global ti_cells ti_instances
  lassign [ti_options {-quiet -hierarchical -filter=} $args] option patterns
  set quiet [dict exists $option -quiet]
  set names {}
  if {[dict exists $option -filter]} {
    foreach term [split [string map {|| \n} [dict get $option -filter]] \n] {
      if {![regexp {^\s*NAME =~ (\S+)\s*$} $term -> pattern]} {
        error "the stand-in does not know this filter: $term"
      }
      set found [concat [ti_match $pattern $ti_cells] [ti_match $pattern $ti_instances]]
      set names [concat $names [ti_found get_cells $pattern $found $quiet]]
    }
    return $names
  }
  foreach pattern [join $patterns] {
    set found {}
    # A wildcard stays on its level of the hierarchy.
    foreach name [concat [ti_match $pattern $ti_cells] [ti_match $pattern $ti_instances]] {
      if {[llength [split $name /]] == [llength [split $pattern /]]} {
        lappend found $name
      }
    }
    set names [concat $names [ti_found get_cells $pattern $found $quiet]]
  }
  return $names
}

proc get_pins {args} {
  lassign [ti_options {-of_objects= -filter=} $args] option
  if {[dict get $option -filter] ne "REF_PIN_NAME == CLR"} {
    error "the stand-in does not know this filter: [dict get $option -filter]"
  }
  set names {}
  foreach cell [dict get $option -of_objects] {
    lappend names $cell/CLR
  }
  return $names
}

proc get_clocks {args} {
  global ti_periods ti_cell_clocks
  lassign [ti_options {-quiet -of_objects=} $args] option patterns
  if {[dict exists $option -of_objects]} {
    set names {}
    foreach cell [dict get $option -of_objects] {
      lappend names $ti_cell_clocks($cell)
    }
    return [lsort -unique $names]
  }
  set names {}
  foreach pattern $patterns {
    set names [concat $names \
      [ti_found get_clocks $pattern [ti_match $pattern [array names ti_periods]] [dict exists $option -quiet]]]
  }
  return $names
}

proc get_property {args} {
  global ti_periods
  lassign [ti_options -min $args] option rest
  lassign $rest property objects
  switch $property {
    PERIOD {
      set values {}
      foreach name $objects {
        lappend values $ti_periods($name)
      }
      return [lindex [lsort -real $values] 0]
    }
    SLACK {return 1.0}
  }
  error "the stand-in does not know this property: $property"
}
