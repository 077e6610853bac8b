// SPDX-License-Identifier: Apache-2.0

/// Counts what became of the requests of a `ti_ra`; wraps at 2^48.
module ti_cache_counters (
  input logic clk_i,
  input logic rst_ni,

  input logic event_access_i,
  input logic event_hit_i,
  input logic event_merged_i,
  input logic event_miss_i,

  output ti_pkg::cache_counters_t counters_o
);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      counters_o <= '0;
    end else if (event_access_i) begin
      counters_o.accesses <= counters_o.accesses + 1'b1;
      if (event_hit_i) counters_o.hits <= counters_o.hits + 1'b1;
      if (event_merged_i) counters_o.merged <= counters_o.merged + 1'b1;
      if (event_miss_i) counters_o.misses <= counters_o.misses + 1'b1;
    end
  end

endmodule : ti_cache_counters
