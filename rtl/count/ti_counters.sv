// SPDX-License-Identifier: Apache-2.0

`include "ti_reset.svh"

/// The counters of one unit: how often each of its events was 1 while `run_i` was.
///
/// `count_o` is the counter `index_i`, 1 cycle after it was asked for; an index beyond the last reads 0.  Counters
/// are zero after reset and wrap at 2^`Width`.  With `ti_config_pkg::Counters` 0 nothing is built and 0 is read.
/// With `ti_config_pkg::CounterSnapshot` what is read is a second rank of registers, which takes all counts in a
/// cycle in which `snapshot_i` is 1, the events before that cycle in them; it is zero after reset too.
/// The numbers of the events are those of `ti_count_pkg`.
module ti_counters #(
  /// Events, 1 or more.
  parameter  int unsigned Num   = 1,
  localparam int unsigned Width = $bits(ti_count_pkg::count_t)
) (
  input logic clk_i,
  input logic rst_ni,

  input logic           run_i,
  input logic           snapshot_i,
  input logic [Num-1:0] events_i,

  input  ti_count_pkg::event_index_t index_i,
  output ti_count_pkg::count_t       count_o
);

  if (ti_config_pkg::Counters != 0) begin : gen_counters
    logic [Width-1:0] counts[Num];
    for (genvar e = 0; e < Num; e++) begin : gen_event
      logic [Width-1:0] count_q;
      always_ff @(`TI_CLK_RST) begin
        if (!rst_ni) count_q <= '0;
        else if (run_i && events_i[e]) count_q <= count_q + 1'b1;
      end
      if (ti_config_pkg::CounterSnapshot != 0) begin : gen_copy
        logic [Width-1:0] copy_q;
        always_ff @(`TI_CLK_RST) begin
          if (!rst_ni) copy_q <= '0;
          else if (snapshot_i) copy_q <= count_q;
        end
        assign counts[e] = copy_q;
      end else begin : gen_live
        assign counts[e] = count_q;
      end
    end
    if (ti_config_pkg::CounterSnapshot == 0) begin : gen_no_copy
      logic unused_snapshot;
      assign unused_snapshot = snapshot_i;
    end

    always_ff @(posedge clk_i) begin
      count_o <= '0;
      for (int unsigned e = 0; e < Num; e++) begin
        if (32'(index_i) == e) count_o <= counts[e];
      end
    end
  end else begin : gen_none
    logic unused;
    assign unused  = clk_i & rst_ni & run_i & snapshot_i & (|events_i) & (|index_i);
    assign count_o = '0;
  end

  if (Num < 1) begin : gen_check_num
    $error("ti_counters: Num must be 1 or more");
  end

endmodule : ti_counters
