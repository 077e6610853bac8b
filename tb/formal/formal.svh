// SPDX-License-Identifier: Apache-2.0

// What every file of properties begins with.  Each is bound to its module, so that it sees inside; ports that
// nothing drives are free, another value in each cycle.

`ifndef TI_FORMAL_SVH_
`define TI_FORMAL_SVH_

`include "ti_assert.svh"

// Once in reset, and from then on in it whenever it likes.
`define TI_STARTS_IN_RESET                                        \
    logic began_q = 1'b0;                                           \
    always_ff @(posedge clk_i) began_q <= 1'b1;                     \
    StartsInReset: assume property (@(posedge clk_i) (began_q || !rst_ni));

`define TI_ASSUME(name_, prop_) \
    name_: assume property (@(posedge clk_i) disable iff (!rst_ni) (prop_));

// A value that is free but never changes.
`define TI_SYMBOL(name_) \
    name_``Held: assume property (@(posedge clk_i) (!began_q || $stable(name_)));

`endif  // TI_FORMAL_SVH_
