// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The free list of a unit's slots.
///
/// `free_valid_o` says that slot `free_slot_o` may be taken with `take_i`; `give_i` brings one back and is
/// always accepted.  After reset the slots come out in ascending order.
module ti_slot_pool #(
  /// Slots, 2 or more.
  parameter  int unsigned NumSlots  = 2,
  /// A slot that is given is free a cycle later, and the path from `give_i` ends at a register.
  parameter  bit          Late      = 1'b0,
  localparam int unsigned SlotWidth = $clog2(NumSlots)
) (
  input logic clk_i,
  input logic rst_ni,

  output logic                 free_valid_o,
  output logic [SlotWidth-1:0] free_slot_o,
  input  logic                 take_i,

  input logic                 give_i,
  input logic [SlotWidth-1:0] give_slot_i
);

  logic [SlotWidth:0] fresh_q;  // slots handed out for the first time
  logic fresh, queue_valid, take_old;
  logic [SlotWidth-1:0] queue_slot;

  assign fresh        = fresh_q < (SlotWidth + 1)'(NumSlots);
  assign free_valid_o = fresh || queue_valid;
  assign free_slot_o  = fresh ? fresh_q[SlotWidth-1:0] : queue_slot;
  assign take_old     = take_i && !fresh;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) fresh_q <= '0;
    else if (take_i && fresh) fresh_q <= fresh_q + 1'b1;
  end

  logic given;
  logic [SlotWidth-1:0] given_slot;
  if (!Late) begin : gen_at_once
    assign given      = give_i;
    assign given_slot = give_slot_i;
  end else begin : gen_late
    always_ff @(`TI_CLK_RST) begin
      if (!rst_ni) given <= 1'b0;
      else given <= give_i;
    end
    always_ff @(posedge clk_i) given_slot <= give_slot_i;
  end

  ti_queue #(
    .payload_t(logic [SlotWidth-1:0]),
    .Depth    (NumSlots)
  ) u_queue (
    .clk_i,
    .rst_ni,
    .push_i     (given),
    .push_data_i(given_slot),
    .out_valid_o(queue_valid),
    .out_ready_i(take_old),
    .out_data_o (queue_slot)
  );

  if (NumSlots < 2) begin : gen_check_num_slots
    $error("ti_slot_pool: NumSlots must be 2 or more");
  end

`ifndef SYNTHESIS
  logic [NumSlots-1:0] taken_q;
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      taken_q <= '0;
    end else begin
      if (give_i) taken_q[give_slot_i] <= 1'b0;
      if (take_i) taken_q[free_slot_o] <= 1'b1;
    end
  end
  `TI_ASSERT(GivesOnlyTaken, give_i -> taken_q[give_slot_i])
`endif
  `TI_ASSERT(TakesOnlyFree, take_i -> free_valid_o)
  `TI_ASSERT_KNOWN(FreeValidKnown, free_valid_o)

endmodule : ti_slot_pool
