// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_slot_pool` never hands out a slot that is taken, and has one to hand out whenever one is not: none is owned twice
/// and none leaks.  A slot that is given back with `Late` counts a cycle later.
module ti_slot_pool_formal #(
  parameter  int unsigned NumSlots  = 2,
  parameter  bit          Late      = 1'b0,
  localparam int unsigned SlotWidth = $clog2(NumSlots)
) (
  input logic                 clk_i,
  input logic                 rst_ni,
  input logic                 free_valid_o,
  input logic [SlotWidth-1:0] free_slot_o,
  input logic                 take_i,
  input logic                 give_i,
  input logic [SlotWidth-1:0] give_slot_i
);
  `TI_STARTS_IN_RESET

  // Owned by the caller, and on its way back.
  logic [NumSlots-1:0] owned_q, late_q;
  logic gave_q;  // at least once
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      owned_q <= '0;
      late_q  <= '0;
      gave_q  <= 1'b0;
    end else begin
      late_q <= '0;
      if (give_i) begin
        gave_q               <= 1'b1;
        owned_q[give_slot_i] <= 1'b0;
        late_q[give_slot_i]  <= Late;
      end
      if (take_i) owned_q[free_slot_o] <= 1'b1;
    end
  end

  `TI_ASSUME(GivesASlot, give_i -> 32'(give_slot_i) < NumSlots)

  `TI_ASSERT(HandsOutASlot, free_valid_o -> 32'(free_slot_o) < NumSlots)
  `TI_ASSERT(NeverOwnedTwice, free_valid_o -> !owned_q[free_slot_o] && !late_q[free_slot_o])
  `TI_ASSERT(NeverLeaked, free_valid_o == ((owned_q | late_q) != '1))
  `TI_COVER(AllAreOwnedAgain, owned_q == '1 && gave_q)
endmodule : ti_slot_pool_formal

bind ti_slot_pool ti_slot_pool_formal #(
  .NumSlots(NumSlots),
  .Late    (Late)
) u_formal (.*);
