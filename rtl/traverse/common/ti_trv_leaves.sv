// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Leaves on their way out of a TRV: which slot has reached which leaf, joined with the operands of its tests.
///
/// A push is always taken, as a slot stands here at most once.  2 cycles from push to output, one
/// leaf a cycle.
module ti_trv_leaves #(
  parameter int unsigned NumSlots = 8
) (
  input logic clk_i,
  input logic rst_ni,
  input ti_pkg::trv_index_t index_i,  // of the unit

  // A ray takes a slot.
  input logic                  start_i,
  input ti_pkg::trv_slot_t     start_slot_i,
  input ti_pkg::ray_operands_t start_operands_i,

  input logic                push_i,
  input ti_pkg::trv_slot_t   push_slot_i,
  input ti_pkg::list_index_t push_first_i,
  input ti_pkg::tri_count_t  push_count_i,
  input ti_pkg::fp_t         push_tnear_i,
  input ti_pkg::fp_t         push_tfar_i,

  output logic          leaf_valid_o,
  input  logic          leaf_ready_i,
  output ti_pkg::leaf_t leaf_data_o
);

  typedef struct packed {
    ti_pkg::trv_slot_t   slot;
    ti_pkg::list_index_t first;
    ti_pkg::tri_count_t  count;
    ti_pkg::fp_t         tnear;
    ti_pkg::fp_t         tfar;
  } leaf_wait_t;

  logic waits, take, valid_q;
  leaf_wait_t first_waiting, leaf_q;
  ti_pkg::ray_operands_t operands;

  ti_queue #(
    .payload_t(leaf_wait_t),
    .Depth    (NumSlots)
  ) u_queue (
    .clk_i,
    .rst_ni,
    .push_i,
    .push_data_i(
    '{
        slot: push_slot_i,
        first: push_first_i,
        count: push_count_i,
        tnear: push_tnear_i,
        tfar: push_tfar_i
    }
    ),
    .out_valid_o(waits),
    .out_ready_i(take),
    .out_data_o(first_waiting)
  );

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(ti_pkg::ray_operands_t)
  ) u_operands (
    .clk_i,
    .read_en_i   (waits && take),
    .read_addr_i (first_waiting.slot),
    .read_data_o (operands),
    .write_en_i  (start_i),
    .write_addr_i(start_slot_i),
    .write_data_i(start_operands_i)
  );

  assign take = !valid_q || leaf_ready_i;
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) valid_q <= 1'b0;
    else if (take) valid_q <= waits;
  end
  always_ff @(posedge clk_i) if (take) leaf_q <= first_waiting;

  assign leaf_valid_o = valid_q;
  assign leaf_data_o = '{
          home: '{trv: index_i, slot: leaf_q.slot},
          first: leaf_q.first,
          count: leaf_q.count,
          operands: operands,
          tnear: leaf_q.tnear,
          tfar: leaf_q.tfar
      };

  `TI_ASSERT_NEXT(OutHeldUntilTaken, leaf_valid_o && !leaf_ready_i, leaf_valid_o && $stable
                  (leaf_data_o))
  `TI_ASSERT_KNOWN(LeafValidKnown, leaf_valid_o)

endmodule : ti_trv_leaves
