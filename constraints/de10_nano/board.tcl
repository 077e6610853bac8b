# SPDX-License-Identifier: Apache-2.0
set tool quartus
set family "Cyclone V"
set part 5CSEBA6U23I7
# Quartus Prime Standard and Lite do not read type parameters (docs/parts.md): Verilog-2001, by Yosys.
set list ti_top_wrapper_plain.f
