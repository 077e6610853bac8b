# SPDX-License-Identifier: Apache-2.0
#
# What the stand-ins of vendors' tools share.  A command that only acts is recorded, a line of JSON each;
# a query is answered from ti_ports, ti_inputs, ti_cells, ti_instances and ti_cell_clocks.  What
# matches nothing is an error, unless the script allows for it.

proc ti_quote {text} {
  return "\"[string map {\\ \\\\ \" \\\" \n \\n \t \\t} $text]\""
}

proc ti_record {args} {
  set words {}
  foreach word $args {
    lappend words [ti_quote $word]
  }
  puts "RECORD \[[join $words ,]\]"
}

# Commands that are recorded and answer nothing.
proc ti_stand_in {names} {
  foreach name $names {
    proc $name {args} "ti_record $name {*}\$args"
  }
}

# Vendors' patterns know * and ?, and take brackets as they are.
proc ti_match {pattern names} {
  if {![regexp {[*?]} $pattern]} {
    return [lsearch -all -inline -exact $names $pattern]
  }
  set pattern [string map {\\ \\\\ \[ \\\[ \] \\\]} $pattern]
  return [lsearch -all -inline -glob $names $pattern]
}

# Arguments without the options that are given: {set of options, rest}; an option with a value is name=.
proc ti_options {known words} {
  set option {}
  set rest {}
  for {set i 0} {$i < [llength $words]} {incr i} {
    set word [lindex $words $i]
    if {"$word=" in $known} {
      dict set option $word [lindex $words [incr i]]
    } elseif {$word in $known} {
      dict set option $word 1
    } elseif {[string match -* $word] && ![string is double $word]} {
      error "$word: the stand-in knows no such option"
    } else {
      lappend rest $word
    }
  }
  return [list $option $rest]
}

# Names, of which a script that is not quiet expects one at least.
proc ti_found {command pattern names quiet} {
  if {![llength $names] && !$quiet} {
    error "$command $pattern: matches nothing"
  }
  return $names
}

# Clocks: name and period.
array set ti_periods {}
proc create_clock {args} {
  global ti_periods
  ti_record create_clock {*}$args
  lassign [ti_options {-name= -period=} $args] option ports
  set ti_periods([dict get $option -name]) [dict get $option -period]
}

set ti_actions {
  set_false_path set_input_delay set_output_delay set_max_delay set_min_delay
}
ti_stand_in $ti_actions
