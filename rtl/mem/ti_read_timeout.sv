// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Which reads have waited too long for their answer, and whether a memory answers at all.
///
/// A read is overdue `Timeout` to 2 `Timeout` cycles after it was taken, and some cycles later if others are too: one is
/// offered at a time.  One that is given up keeps its id until its beat comes after all, so that this beat answers no
/// later read.  `dead_o`: a request has waited for `Timeout` cycles in which nothing was taken, came or was given up, as
/// when no id is left or the memory takes no address; it stays until reset.  No output depends on an input of its cycle
/// but `overdue_valid_o`, which is down in the cycle of the read's own beat.
module ti_read_timeout #(
  /// Cycles, 1 or more; more than a read and the answers before it may take.
  parameter  int unsigned Timeout  = 1024,
  /// Ids, a power of two.
  parameter  int unsigned NumReads = 2,
  localparam int unsigned IdWidth  = $clog2(NumReads)
) (
  input logic clk_i,
  input logic rst_ni,

  input logic                waiting_i,     // a request waits
  input logic                take_i,        // one is taken
  input logic [ IdWidth-1:0] take_id_i,
  input logic                beat_i,        // a beat comes, asked for or not
  input logic [ IdWidth-1:0] beat_id_i,
  input logic [NumReads-1:0] outstanding_i,

  output logic [NumReads-1:0] given_up_o,
  output logic                overdue_valid_o,
  output logic [ IdWidth-1:0] overdue_id_o,
  input  logic                overdue_taken_i,  // it is given up
  output logic                dead_o
);

  localparam int unsigned CountWidth = (Timeout > 1) ? $clog2(Timeout) : 1;

  logic [CountWidth-1:0] count_q;
  logic tick, moves, stuck_q;
  logic [NumReads-1:0] aged_q, overdue_q;  // in flight at the last tick, and at the one before

  assign tick            = count_q == CountWidth'(Timeout - 1);
  assign moves           = take_i || beat_i || overdue_taken_i;
  assign overdue_valid_o = overdue_q[overdue_id_o] && !(beat_i && beat_id_i == overdue_id_o);

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      count_q      <= '0;
      aged_q       <= '0;
      overdue_q    <= '0;
      given_up_o   <= '0;
      overdue_id_o <= '0;
      stuck_q      <= 1'b0;
      dead_o       <= 1'b0;
    end else begin
      count_q <= tick ? '0 : count_q + 1'b1;
      if (tick) begin
        aged_q    <= outstanding_i;
        overdue_q <= overdue_q | (outstanding_i & aged_q);
      end
      if (take_i) begin
        aged_q[take_id_i]    <= 1'b0;
        overdue_q[take_id_i] <= 1'b0;
      end
      if (overdue_taken_i) begin
        aged_q[overdue_id_o]     <= 1'b0;
        overdue_q[overdue_id_o]  <= 1'b0;
        given_up_o[overdue_id_o] <= 1'b1;
      end
      if (beat_i) begin
        aged_q[beat_id_i]     <= 1'b0;
        overdue_q[beat_id_i]  <= 1'b0;
        given_up_o[beat_id_i] <= 1'b0;
      end
      if (!overdue_q[overdue_id_o]) overdue_id_o <= overdue_id_o + 1'b1;

      stuck_q <= waiting_i && !moves && (stuck_q || tick);
      if (tick && stuck_q && waiting_i && !moves) dead_o <= 1'b1;
    end
  end

  if (Timeout < 1) begin : gen_check_timeout
    $error("ti_read_timeout: Timeout must be 1 or more");
  end
  if (NumReads < 2 || NumReads != 1 << IdWidth) begin : gen_check_num_reads
    $error("ti_read_timeout: NumReads must be a power of two, 2 or more");
  end

  `TI_ASSERT(GivesUpWhatIsOverdue,
             overdue_taken_i -> overdue_valid_o && outstanding_i[overdue_id_o])
  `TI_ASSERT(TakesNoIdThatIsGivenUp, take_i -> !given_up_o[take_id_i])
  `TI_COVER(GivenUp, overdue_taken_i)
  `TI_COVER(CameAfterAll, beat_i && given_up_o[beat_id_i])
  `TI_COVER(Dead, dead_o)

endmodule : ti_read_timeout
