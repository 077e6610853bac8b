# SPDX-License-Identifier: Apache-2.0
# The oscillator's 100 MHz, straight to the engine.
create_clock -name aclk -period 10.000 [get_ports aclk]
