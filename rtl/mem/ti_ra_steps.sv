// SPDX-License-Identifier: Apache-2.0

/// Steps of a look-up in a `ti_ra`: its tags are read, with `Compare` compared in a cycle of their own, and it is decided.
///
/// Latency 1 cycle, 2 with `Compare`, one more with `Wait`: a queue of two in front, where the path from `decided_i` ends.
/// One a cycle.  `read_en_o` is up as the tags of `read_o` are read.  A look-up stands at `decide` until `decided_i`;
/// `compare_en_o` is up as the one that is compared takes its place, or as nothing stands there.
module ti_ra_steps #(
  parameter type lookup_t = logic,
  parameter bit  Compare  = 1'b0,
  parameter bit  Wait     = 1'b0
) (
  input  logic clk_i,
  input  logic rst_ni,
  output logic empty_o,

  input  logic    look_valid_i,
  output logic    look_ready_o,
  input  lookup_t look_i,

  output logic    read_en_o,
  output lookup_t read_o,

  output logic    compare_en_o,
  output lookup_t compare_o,

  output logic    decide_valid_o,
  input  logic    decided_i,
  output lookup_t decide_o
);

  logic read_valid, read_ready, waiting, compare_valid, compared;

  if (!Wait) begin : gen_at_once
    assign read_valid   = look_valid_i;
    assign look_ready_o = read_ready;
    assign read_o       = look_i;
    assign waiting      = 1'b0;
  end else begin : gen_wait
    ti_fifo #(
      .payload_t(lookup_t),
      .Depth    (2)
    ) u_wait (
      .clk_i,
      .rst_ni,
      .in_valid_i (look_valid_i),
      .in_ready_o (look_ready_o),
      .in_data_i  (look_i),
      .out_valid_o(read_valid),
      .out_ready_i(read_ready),
      .out_data_o (read_o)
    );
    assign waiting = read_valid;
  end
  assign read_en_o = read_valid && read_ready;

  if (!Compare) begin : gen_together
    assign compare_o     = read_o;
    assign compare_valid = read_valid;
    assign read_ready    = compare_en_o;
    assign compared      = 1'b0;
  end else begin : gen_compare
    ti_stage #(
      .payload_t(lookup_t)
    ) u_compare (
      .clk_i,
      .rst_ni,
      .in_valid_i (read_valid),
      .in_ready_o (read_ready),
      .in_data_i  (read_o),
      .out_valid_o(compare_valid),
      .out_ready_i(compare_en_o),
      .out_data_o (compare_o)
    );
    assign compared = compare_valid;
  end

  ti_stage #(
    .payload_t(lookup_t)
  ) u_decide (
    .clk_i,
    .rst_ni,
    .in_valid_i (compare_valid),
    .in_ready_o (compare_en_o),
    .in_data_i  (compare_o),
    .out_valid_o(decide_valid_o),
    .out_ready_i(decided_i),
    .out_data_o (decide_o)
  );

  assign empty_o = !waiting && !compared && !decide_valid_o;

endmodule : ti_ra_steps
