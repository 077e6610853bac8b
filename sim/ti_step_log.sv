// SPDX-License-Identifier: Apache-2.0

/// Writes the nodes that one ray visits, in the form of the model's log (`docs/step-log.md`).
///
/// Bound to every `ti_trv` of a simulation; silent unless started with +log_ray=NUMBER +log_file=PATH.
module ti_step_log (
  input logic clk_i,

  input logic                     start,
  input ti_pkg::trv_slot_t        new_slot,
  input logic              [31:0] ray_id,

  input logic                end_valid,
  input ti_pkg::trv_slot_t   end_slot,
  input ti_pkg::node_index_t end_index,
  input ti_pkg::node_t       end_node,
  input ti_pkg::fp_t         end_t,
  input ti_pkg::fp_t         tmax,
  input logic                push,
  input ti_pkg::node_index_t next_node,
  input ti_pkg::node_index_t far
);

  bit on;
  bit here;  // the ray is at home in this unit
  ti_pkg::trv_slot_t slot;
  logic [31:0] wanted;
  string path, side;
  int file;

  initial begin
    on = $value$plusargs("log_ray=%d", wanted) != 0 && $value$plusargs("log_file=%s", path) != 0;
  end

  always_ff @(posedge clk_i) begin
    if (on) begin
      if (start && ray_id == wanted) begin
        here <= 1'b1;
        slot <= new_slot;
      end else if (start && here && new_slot == slot) begin
        here <= 1'b0;
      end
      if (end_valid && here && end_slot == slot) begin
        file = $fopen(path, "a");
        if (end_node.axis == 2'd3) begin
          $fdisplay(file, "node %0d leaf %0d exit %08x", end_index, end_node.link, tmax);
        end else begin
          side = "near";
          if (push) side = "both";
          else if (next_node == far) side = "far";
          $fdisplay(file, "node %0d t %08x %s", end_index, end_t, side);
        end
        $fclose(file);
      end
    end
  end

endmodule : ti_step_log

bind ti_trv ti_step_log u_step_log (
  .clk_i,
  .start,
  .new_slot,
  .ray_id(dispatch_data_i.ray.ray_id),
  .end_valid,
  .end_slot,
  .end_index,
  .end_node,
  .end_t,
  .tmax  (state.interval.tmax),
  .push,
  .next_node,
  .far
);
