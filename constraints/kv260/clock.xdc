# SPDX-License-Identifier: Apache-2.0
#
# pl_clk0 of the processing system, asked for 200 MHz.  Out of context only: in a block design the
# clock comes with the processing system, and this file stays out.
create_clock -name aclk -period 5.000 [get_ports aclk]
