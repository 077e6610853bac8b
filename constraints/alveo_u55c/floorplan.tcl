# SPDX-License-Identifier: Apache-2.0
#
# A hint behind synthesis, by read_xdc -unmanaged: cores go round the three dies, so that none lies
# across two.  Memory ports leave toward SLR0, where the HBM is; a register slice a die, outside of the
# block, takes them there.
set ti_cores [get_cells -quiet -hierarchical -filter {NAME =~ *u_engine/gen_core[*].u_core}]
if {[llength $ti_cores] > 1} {
  foreach core $ti_cores {
    regexp {gen_core\[(\d+)\]\.u_core$} $core -> index
    set die SLR[expr {$index % 3}]
    if {![llength [get_pblocks -quiet ti_$die]]} {
      create_pblock ti_$die
      resize_pblock ti_$die -add $die
    }
    add_cells_to_pblock ti_$die [get_cells $core]
  }
}
