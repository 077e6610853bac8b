# SPDX-License-Identifier: Apache-2.0
#
# For Vivado: what crosses from clock to clock in ti_top with stream_clock=own; nothing to do without.
# Behind synthesis, by read_xdc -unmanaged; works wherever the block stands in a design.  Clocks must
# not be declared asynchronous as groups: that would take precedence over the bounds below.
#
# The synchronisers carry ASYNC_REG in the RTL (ti_sync).

set ti_fifos [get_cells -quiet -hierarchical -filter {NAME =~ *.gen_own_clock.u_in || NAME =~ *.gen_own_clock.u_out}]
set ti_resets [get_cells -quiet -hierarchical -filter {NAME =~ *.gen_own_clock.u_reset/stage_q_reg[*]}]

if {[llength [get_ports -quiet axis*_aclk]] && (![llength $ti_fifos] || ![llength $ti_resets])} {
  error "streams have clocks of their own, but the queues between clocks were not found"
}

# A path within the period of the faster clock, whatever the phases.
proc ti_bound {from to} {
  set periods {}
  foreach cells [list $from $to] {
    lappend periods [get_property -min PERIOD [get_clocks -of_objects $cells]]
  }
  set period [lindex [lsort -real $periods] 0]
  set_max_delay -datapath_only $period -from $from -to $to
  return $period
}

foreach fifo $ti_fifos {
  # Pointers in Gray code: at most one bit of a word is on its way at a time.
  foreach {from to} {
    u_write/gray_q_reg[*] u_read/u_write/stage_q_reg[*]
    u_read/gray_q_reg[*]  u_write/u_read/stage_q_reg[*]
  } {
    set from [get_cells $fifo/$from]
    set to [get_cells $fifo/$to]
    set_bus_skew [ti_bound $from $to] -from $from -to $to
  }
  # An entry has been still for as long as its pointer took.
  ti_bound [get_cells $fifo/mem_q_reg*] [get_cells $fifo/out_data_o_reg*]
}

# A stream's reset is asserted at once; its synchroniser releases it.
if {[llength $ti_resets]} {
  set_false_path -to [get_pins -of_objects $ti_resets -filter {REF_PIN_NAME == CLR}]
}
