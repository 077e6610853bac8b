# SPDX-License-Identifier: Apache-2.0
#
# For Quartus: what crosses from clock to clock in ti_top with stream_clock=own; nothing to do without.
# Works wherever the block stands in a design.  Clocks must not be declared asynchronous as groups.
#
# Standard Edition has no bound of a data path without its clocks, so, as Intel does for its own queues,
# relation of the clocks is loosened, and nets and skew are bound by the period of the faster clock.
#
# The synchronisers carry SYNCHRONIZER_IDENTIFICATION in the RTL (ti_sync).

proc ti_loosen {from to} {
  set_max_delay -from $from -to $to 100
  set_min_delay -from $from -to $to -100
  set_net_delay -from $from -to $to -max -get_value_from_clock_period min_clock_period -value_multiplier 0.8
}

foreach queue {u_in u_out} {
  for {set s 0} {1} {incr s} {
    set path "*gen_stream\[$s\].gen_own_clock.$queue|"
    if {![get_collection_size [get_registers -nowarn ${path}u_write|gray_q\[*\]]]} break

    # Pointers in Gray code: at most one bit of a word is on its way at a time.
    foreach {from to} {
      u_write|gray_q[*] u_read|u_write|stage_q[*]
      u_read|gray_q[*]  u_write|u_read|stage_q[*]
    } {
      set from [get_registers $path$from]
      set to [get_registers $path$to]
      ti_loosen $from $to
      set_max_skew -from $from -to $to -get_skew_value_from_clock_period min_clock_period \
        -skew_value_multiplier 0.8
    }
    # An entry has been still for as long as its pointer took.
    ti_loosen [get_keepers ${path}mem_q*] [get_registers ${path}out_data_o*]
  }
}

# A stream's reset is asserted at once; its synchroniser releases it.
if {[get_collection_size [get_registers -nowarn *gen_own_clock.u_reset|stage_q*]]} {
  set_false_path -from [get_ports aresetn] -to [get_registers *gen_own_clock.u_reset|stage_q*]
}
