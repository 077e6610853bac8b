// SPDX-License-Identifier: Apache-2.0

// When registers with a reset see it, one choice for the whole design.
//
// With the key sync_reset of the configuration at the next clock edge, as block RAM and DSP registers of FPGAs
// want it: rst_ni must then be low for at least one edge of clk_i.  Without it at once (asynchronous, active
// low).  Either way its release must keep the setup and hold times of clk_i: the user's reset synchroniser sees
// to that.

`ifndef TI_RESET_SVH_
`define TI_RESET_SVH_

`include "ti_config.svh"

`ifdef TI_SYNC_RESET
`define TI_CLK_RST posedge clk_i
`else
`define TI_CLK_RST posedge clk_i or negedge rst_ni
`endif

`endif  // TI_RESET_SVH_
