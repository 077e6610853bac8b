// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// Leaves leave `ti_trv_leaves` in the order in which they came, each once and unchanged, 2 cycles later or behind the
/// one before, with the operands of the ray that is in its slot; a leaf stays until it is taken.
module ti_trv_leaves_formal #(
  parameter int unsigned NumSlots = 2
) (
  input logic                  clk_i,
  input logic                  rst_ni,
  input ti_pkg::trv_index_t    index_i,
  input logic                  start_i,
  input ti_pkg::trv_slot_t     start_slot_i,
  input ti_pkg::ray_operands_t start_operands_i,
  input logic                  push_i,
  input ti_pkg::trv_slot_t     push_slot_i,
  input ti_pkg::list_index_t   push_first_i,
  input ti_pkg::tri_count_t    push_count_i,
  input ti_pkg::fp_t           push_tnear_i,
  input ti_pkg::fp_t           push_tfar_i,
  input logic                  leaf_valid_o,
  input logic                  leaf_ready_i,
  input ti_pkg::leaf_t         leaf_data_o
);
  `TI_STARTS_IN_RESET

  localparam int unsigned CountWidth = $clog2(NumSlots + 1);

  // Slots whose ray is on its walk, and those whose leaf waits here.
  logic take;
  logic [NumSlots-1:0] starts, pushes, leaves, here_q, waits_q, waited_q;
  assign take   = leaf_valid_o && leaf_ready_i;
  assign starts = start_i ? NumSlots'(1) << start_slot_i : '0;
  assign pushes = push_i ? NumSlots'(1) << push_slot_i : '0;
  assign leaves = take ? NumSlots'(1) << leaf_data_o.home.slot : '0;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      here_q   <= '0;
      waits_q  <= '0;
      waited_q <= '0;
    end else begin
      here_q   <= here_q | starts;
      waits_q  <= (waits_q & ~leaves) | pushes;
      waited_q <= waits_q & ~leaves;
    end
  end

  // One slot, whichever: its ray, its leaf, and leaves that leave before it.
  ti_pkg::trv_slot_t who;
  `TI_SYMBOL(who)
  ti_pkg::ray_operands_t operands_q;
  ti_pkg::leaf_t leaf_q;
  logic [CountWidth-1:0] inside_q, ahead_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) inside_q <= '0;
    else inside_q <= inside_q + CountWidth'(push_i) - CountWidth'(take);
    if (starts[who]) operands_q <= start_operands_i;
    if (pushes[who]) begin
      leaf_q <= '{
          home: '{trv: index_i, slot: push_slot_i},
          first: push_first_i,
          count: push_count_i,
          operands: operands_q,
          tnear: push_tnear_i,
          tfar: push_tfar_i
      };
      ahead_q <= inside_q - CountWidth'(take);
    end else if (take) begin
      ahead_q <= ahead_q - 1'b1;
    end
  end

  // A ray has a leaf out once (`ti_kd_walk`: it goes on when the leaf's tests are back), and another is given its slot
  // when it has retired (`ti_slot_pool`).
  `TI_ASSUME(LeafOfARay, (pushes & (waits_q | ~here_q | starts)) == '0)
  `TI_ASSUME(StartsBehindItsLeaf, (starts & waits_q) == '0)
  // The number of the unit.
  `TI_ASSUME(IndexStays, $past(rst_ni) -> $stable(index_i))

  `TI_ASSERT(OnlyWhoCame, leaf_valid_o -> waits_q[leaf_data_o.home.slot])
  `TI_ASSERT(InTheirOrder,
             waits_q[who] && leaf_valid_o -> (leaf_data_o.home.slot == who) == (ahead_q == '0))
  `TI_ASSERT(LeafOfItsRay, leaf_valid_o && leaf_data_o.home.slot == who -> leaf_data_o == leaf_q)
  `TI_ASSERT(WorksWhileOneWaits, waited_q != '0 -> leaf_valid_o)
  `TI_COVER(LeavesOneAfterTheOther, take && $past(take) && leaf_data_o.home.slot == who)
  `TI_COVER(WaitsBehindAnother, waits_q == '1 && ahead_q != '0 && !leaf_ready_i)
endmodule : ti_trv_leaves_formal

// What is moved and not looked at has one bit, repeated.
module ti_trv_leaves_top #(
  parameter int unsigned NumSlots = 2 ** $bits(ti_pkg::trv_slot_t)
) (
  input  logic               clk_i,
  input  logic               rst_ni,
  input  ti_pkg::trv_index_t index_i,
  input  logic               start_i,
  input  ti_pkg::trv_slot_t  start_slot_i,
  input  logic               operands_i,
  input  logic               push_i,
  input  ti_pkg::trv_slot_t  push_slot_i,
  input  logic               first_i,
  input  logic               count_i,
  input  logic               tnear_i,
  input  logic               tfar_i,
  output logic               leaf_valid_o,
  input  logic               leaf_ready_i,
  output ti_pkg::leaf_t      leaf_data_o
);
  ti_trv_leaves #(
    .NumSlots(NumSlots)
  ) u_unit (
    .start_operands_i({$bits(ti_pkg::ray_operands_t) {operands_i}}),
    .push_first_i    ({32{first_i}}),
    .push_count_i    ({16{count_i}}),
    .push_tnear_i    ({ti_num_pkg::FpWidth{tnear_i}}),
    .push_tfar_i     ({ti_num_pkg::FpWidth{tfar_i}}),
    .*
  );
endmodule : ti_trv_leaves_top

bind ti_trv_leaves ti_trv_leaves_formal #(.NumSlots(NumSlots)) u_formal (.*);
