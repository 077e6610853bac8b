// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"

/// A `ti_fifo` whose writer never has to ask: it is as deep as there are beats in the world.
///
/// For queues of slots, where a slot stands in at most one place of one queue.  A push into a full
/// queue is a fault of the design, which the assertion reports.
module ti_queue #(
  parameter type payload_t = logic,
  parameter int unsigned Depth = 2
) (
  input logic clk_i,
  input logic rst_ni,

  input logic     push_i,
  input payload_t push_data_i,

  output logic     out_valid_o,
  input  logic     out_ready_i,
  output payload_t out_data_o
);

  logic room;

  ti_fifo #(
    .payload_t(payload_t),
    .Depth    (Depth)
  ) u_fifo (
    .clk_i,
    .rst_ni,
    .in_valid_i(push_i),
    .in_ready_o(room),
    .in_data_i (push_data_i),
    .out_valid_o,
    .out_ready_i,
    .out_data_o
  );

  if (Depth < 1) begin : gen_check_depth
    $error("ti_queue: Depth must be 1 or more");
  end

  `TI_ASSERT(NeverOverflows, push_i -> room)
  `TI_ASSERT_KNOWN(OutValidKnown, out_valid_o)
`ifdef SYNTHESIS
  logic unused_room;
  assign unused_room = room;
`endif

endmodule : ti_queue
