// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_read_timeout` takes a read for overdue no sooner than `Timeout` cycles after it was taken and no later than twice as many,
/// offers none but reads in flight, and leaves no overdue one aside.  A read that is given up stays so until its beat.  A
/// port is dead when a request has waited for `Timeout` cycles in which nothing moved, at the latest after twice as many,
/// and never before.
module ti_read_timeout_formal #(
  parameter  int unsigned Timeout  = 4,
  parameter  int unsigned NumReads = 2,
  localparam int unsigned IdWidth  = $clog2(NumReads)
) (
  input logic                clk_i,
  input logic                rst_ni,
  input logic                waiting_i,
  input logic                take_i,
  input logic [ IdWidth-1:0] take_id_i,
  input logic                beat_i,
  input logic [ IdWidth-1:0] beat_id_i,
  input logic [NumReads-1:0] outstanding_i,
  input logic [NumReads-1:0] given_up_o,
  input logic                overdue_valid_o,
  input logic [ IdWidth-1:0] overdue_id_o,
  input logic                overdue_taken_i,
  input logic                dead_o,
  input logic [NumReads-1:0] overdue_q
);
  `TI_STARTS_IN_RESET

  localparam int unsigned CountWidth = $clog2(2 * Timeout + 2);
  localparam logic [CountWidth-1:0] Most = '1;

  // What `ti_axi_read` does: it takes free ids, and gives up what is offered, between beats.
  logic [NumReads-1:0] flying_q, lost_q;
  `TI_ASSUME(OutstandingReadsAreKnown, outstanding_i == flying_q)
  `TI_ASSUME(TakesFreeIds, take_i -> !flying_q[take_id_i] && !lost_q[take_id_i])
  `TI_ASSUME(GivesUpWhatIsOffered, overdue_taken_i -> overdue_valid_o && !beat_i)
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      flying_q <= '0;
      lost_q   <= '0;
    end else begin
      if (take_i) flying_q[take_id_i] <= 1'b1;
      if (overdue_taken_i) begin
        flying_q[overdue_id_o] <= 1'b0;
        lost_q[overdue_id_o]   <= 1'b1;
      end
      if (beat_i) begin
        flying_q[beat_id_i] <= 1'b0;
        lost_q[beat_id_i]   <= 1'b0;
      end
    end
  end

  // Cycles since the read of one id, whichever, was taken; since something moved while a request waits; and in which the
  // id is overdue and neither it nor another is offered.
  logic [IdWidth-1:0] id;
  `TI_SYMBOL(id)
  logic [CountWidth-1:0] age_q, quiet_q;
  logic [IdWidth:0] aside_q;
  logic is_quiet;
  assign is_quiet = waiting_i && !take_i && !beat_i && !overdue_taken_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      age_q   <= '0;
      quiet_q <= '0;
      aside_q <= '0;
    end else begin
      age_q <= age_q + CountWidth'(age_q != Most);
      if (take_i && take_id_i == id) age_q <= '0;
      quiet_q <= is_quiet ? quiet_q + CountWidth'(quiet_q != Most) : '0;
      aside_q <= (overdue_q[id] && !overdue_q[overdue_id_o]) ? aside_q + 1'b1 : '0;
    end
  end

  `TI_ASSERT(GivenUpUntilItsBeat, given_up_o == lost_q)
  `TI_ASSERT(OnlyReadsInFlightAreOverdue, (overdue_q & ~flying_q) == '0)
  `TI_ASSERT(OverdueNoSooner, overdue_q[id] -> 32'(age_q) >= Timeout)
  `TI_ASSERT(OverdueNoLater, flying_q[id] && 32'(age_q) >= 2 * Timeout -> overdue_q[id])
  `TI_ASSERT(OffersTheOverdue, overdue_valid_o -> overdue_q[overdue_id_o])
  `TI_ASSERT(OffersUnlessItsBeatComes, overdue_q[overdue_id_o] && !beat_i -> overdue_valid_o)
  `TI_ASSERT(LeavesNoneAside, 32'(aside_q) < NumReads)
  `TI_ASSERT_NEXT(DeadNoSooner, !dead_o && (!is_quiet || 32'(quiet_q) < Timeout), !dead_o)
  `TI_ASSERT(DeadNoLater, 32'(quiet_q) >= 2 * Timeout -> dead_o)
  `TI_ASSERT_NEXT(DeadUntilReset, dead_o, dead_o)

  `TI_COVER(AllAreGivenUp, lost_q == '1)
  `TI_COVER(BeatInTheCycleOfTheOffer,
            overdue_q[overdue_id_o] && beat_i && beat_id_i == overdue_id_o)
  `TI_COVER(DeadWithReadsInFlight, dead_o && flying_q != '0)
endmodule : ti_read_timeout_formal

bind ti_read_timeout ti_read_timeout_formal #(
  .Timeout (Timeout),
  .NumReads(NumReads)
) u_formal (.*);
