// SPDX-License-Identifier: Apache-2.0

/// Writes the nodes that one ray visits, in the form of the model's log (`docs/step-log.md`).
///
/// Bound to every `ti_trv` of a simulation; silent unless started with +log_ray=NUMBER +log_file=PATH.
module ti_step_log (
  input logic clk_i,

  input logic                     start_i,
  input ti_pkg::trv_slot_t        new_slot_i,
  input logic              [31:0] ray_id_i,

  // What is compared.
  input ti_pkg::node_index_t index_i,
  input ti_kd_pkg::node_t    node_i,
  input ti_pkg::fp_t         t_i,
  input ti_pkg::fp_t         t_most_i,
  input ti_pkg::fp_t         tmax_i,

  // What is decided, `ti_fp_pkg::CmpLatency` cycles later.
  input logic                end_valid_i,
  input ti_pkg::trv_slot_t   end_slot_i,
  input logic                both_i,
  input ti_pkg::node_index_t next_node_i,
  input ti_pkg::node_index_t far_i
);

  localparam bit Padded = ti_config_pkg::Traversal == ti_config_pkg::TraversalPadded;

  typedef struct packed {
    ti_pkg::node_index_t index;
    ti_kd_pkg::node_t    node;
    ti_pkg::fp_t         t;
    ti_pkg::fp_t         t_most;
    ti_pkg::fp_t         tmax;
  } at_t;
  at_t at;
  ti_delay #(
    .payload_t(at_t),
    .Cycles   (ti_fp_pkg::CmpLatency)
  ) u_at (
    .clk_i,
    .rst_ni(1'b1),
    .data_i('{index: index_i, node: node_i, t: t_i, t_most: t_most_i, tmax: tmax_i}),
    .data_o(at)
  );

  bit on;
  bit here_q;  // the ray is at home in this unit
  ti_pkg::trv_slot_t slot_q;
  logic [31:0] wanted;
  string path;

  initial begin
    on = $value$plusargs("log_ray=%d", wanted) != 0 && $value$plusargs("log_file=%s", path) != 0;
  end

  always_ff @(posedge clk_i) begin
    if (on) begin
      if (start_i && ray_id_i == wanted) begin
        here_q <= 1'b1;
        slot_q <= new_slot_i;
      end else if (start_i && here_q && new_slot_i == slot_q) begin
        here_q <= 1'b0;
      end
    end
  end

  // No function: one would keep the simulation's code of the TRVs from being shared.
  always_ff @(posedge clk_i) begin
    if (on && end_valid_i && here_q && end_slot_i == slot_q) begin : write_visit
      int file;
      file = $fopen(path, "a");
      if (at.node.axis == 2'd3) begin
        $fdisplay(file, "node %0d leaf %0d exit %08x", at.index, at.node.link, at.tmax);
      end else begin
        $fwrite(file, "node %0d t %08x", at.index, at.t);
        if (Padded) $fwrite(file, " %08x", at.t_most);
        if (both_i) $fdisplay(file, " both");
        else if (next_node_i == far_i) $fdisplay(file, " far");
        else $fdisplay(file, " near");
      end
      $fclose(file);
    end
  end

endmodule : ti_step_log

bind ti_trv ti_step_log u_step_log (
  .clk_i,
  .start_i    (start),
  .new_slot_i (new_slot),
  .ray_id_i   (dispatch_data_i.ray_id),
  .index_i    (u_walk.end_index),
  .node_i     (u_walk.end_node),
  .t_i        (u_walk.end_t),
  .t_most_i   (u_walk.end_t_most),
  .tmax_i     (u_walk.tmax),
  .end_valid_i(end_valid),
  .end_slot_i (end_slot),
  .both_i     (u_walk.both),
  .next_node_i(next_node),
  .far_i      (u_walk.far_node)
);
