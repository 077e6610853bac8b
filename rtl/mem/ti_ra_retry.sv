// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Who is looked up in a `ti_ra` without rows of rays: a request or, from a queue with a place a slot, a ray that
/// looks again.  They take turns, one a cycle; a ray pushed in one cycle can be looked up in the next.
///
/// A ray that is refused when it looks again, having neither its line nor a row, keeps requests out: those inside
/// become fewer until it has a row.
module ti_ra_retry #(
  parameter int unsigned NumSlots = 8,
  parameter type lookup_t = logic,
  localparam int unsigned SlotWidth = $clog2(NumSlots)
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic    req_valid_i,
  output logic    req_ready_o,
  input  lookup_t req_data_i,

  output logic    look_valid_o,
  input  logic    look_ready_i,
  output lookup_t look_data_o,

  input logic                    again_i,       // it looks again
  input lookup_t                 again_data_i,
  input logic                    refused_i,     // and not for the first time
  input logic                    done_i,        // the look-up of this slot is decided
  input logic    [SlotWidth-1:0] slot_i,

  output logic waits_o  // a ray is in the queue
);

  logic req_first_q, closed_q, look_go, req_go, retry_valid;
  logic [SlotWidth-1:0] closed_slot_q;
  lookup_t retry;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) closed_q <= 1'b0;
    else if (refused_i) closed_q <= 1'b1;
    else if (done_i && slot_i == closed_slot_q) closed_q <= 1'b0;
  end
  always_ff @(posedge clk_i) if (refused_i && !closed_q) closed_slot_q <= slot_i;

  ti_queue #(
    .payload_t(lookup_t),
    .Depth    (NumSlots)
  ) u_again (
    .clk_i,
    .rst_ni,
    .push_i     (again_i),
    .push_data_i(again_data_i),
    .out_valid_o(retry_valid),
    .out_ready_i(look_ready_i && !req_go),
    .out_data_o (retry)
  );

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) req_first_q <= 1'b0;
    else if (look_go) req_first_q <= !req_go;
  end

  assign req_ready_o  = look_ready_i && !closed_q && (req_first_q || !retry_valid);
  assign req_go       = req_valid_i && req_ready_o;
  assign look_valid_o = retry_valid || (req_valid_i && !closed_q);
  assign look_go      = look_valid_o && look_ready_i;
  assign look_data_o  = req_go ? req_data_i : retry;
  assign waits_o      = retry_valid;

  if (NumSlots < 2) begin : gen_check_num_slots
    $error("ti_ra_retry: NumSlots must be 2 or more");
  end

  `TI_ASSERT_KNOWN(ReqReadyKnown, req_ready_o)
  `TI_ASSERT_KNOWN(LookValidKnown, look_valid_o)

endmodule : ti_ra_retry
