# SPDX-License-Identifier: Apache-2.0
# The oscillator's 50 MHz, straight to the engine.
create_clock -name aclk -period 20.000 [get_ports aclk]
