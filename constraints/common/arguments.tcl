# SPDX-License-Identifier: Apache-2.0
#
# What the build scripts of both tools share: arguments, what a board's folder holds, the list of files.

set ti_constraints [file dirname [file dirname [file normalize [info script]]]]

# Arguments KEY=VALUE over defaults; those without a default have to be given.
proc ti_arguments {words defaults needed} {
  array set option $defaults
  foreach word $words {
    if {![regexp {^([a-z]+)=(.*)$} $word -> key value] || ![info exists option($key)]} {
      error "'$word' is no argument; there are [lsort [array names option]], each as key=value"
    }
    set option($key) $value
  }
  foreach key $needed {
    if {$option($key) eq ""} {
      error "$key= is missing"
    }
  }
  if {$option(mode) ni {ooc full}} {
    error "mode is $option(mode), but must be ooc or full"
  }
  if {$option(mode) eq "full" && $option(top) eq "ti_top_wrapper"} {
    error "mode=full needs top= and sources=, a module that holds ti_top_wrapper: it has more ports than parts have pins"
  }
  return [array get option]
}

# The folder of a board, made for this tool.
proc ti_board {name tool} {
  global ti_constraints
  set folder [file join $ti_constraints $name]
  if {![file isfile [file join $folder board.tcl]]} {
    set boards {}
    foreach file [glob -directory $ti_constraints */board.tcl] {
      lappend boards [file tail [file dirname $file]]
    }
    error "$name: no such board; there are [lsort $boards]"
  }
  set wanted $tool
  source [file join $folder board.tcl]
  if {$tool ne $wanted} {
    error "$name: this board is for $tool, not $wanted"
  }
  return $folder
}

# Folders of headers and files of a block, as a list of it has them: {folders files}.
proc ti_sources {folder list} {
  set file [open [file join $folder $list]]
  set words [split [string trim [read $file]]]
  close $file
  set folders {}
  set files {}
  foreach word $words {
    if {[regexp {^\+incdir\+(.*)$} $word -> header]} {
      lappend folders [file join $folder $header]
    } else {
      lappend files [file join $folder $word]
    }
  }
  return [list $folders $files]
}

# One JSON object of numbers, and of words where a value is none; "" is null.
proc ti_json {path pairs} {
  set lines {}
  foreach {key value} $pairs {
    if {$value eq ""} {
      set value null
    } elseif {![string is double -strict $value]} {
      set value "\"[string map {\\ \\\\ \" \\\"} $value]\""
    }
    lappend lines "  \"$key\": $value"
  }
  set file [open $path w]
  puts $file "{\n[join $lines ",\n"]\n}"
  close $file
}
