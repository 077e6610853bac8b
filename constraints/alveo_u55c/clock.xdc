# SPDX-License-Identifier: Apache-2.0
# 300 MHz, the kernel clock that the platforms of the card offer first; out of context only.
create_clock -name aclk -period 3.333 [get_ports aclk]
