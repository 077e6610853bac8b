// SPDX-License-Identifier: Apache-2.0

// Beats inside a unit that keeps their order, and one of them that is watched, whichever: how many leave before it.
// Included in a module that has `CountWidth`, a type `word_t`, `push` with what is pushed in `pushed`, and `pop`.

logic pick, watched_q, its_turn;
logic [CountWidth-1:0] inside_q, ahead_q;
word_t word_q;
always_ff @(posedge clk_i) begin
  if (!rst_ni) begin
    inside_q  <= '0;
    watched_q <= 1'b0;
  end else begin
    inside_q <= inside_q + CountWidth'(push) - CountWidth'(pop);
    if (!watched_q) watched_q <= push && pick;
    else if (pop && ahead_q == '0) watched_q <= 1'b0;
  end
end
always_ff @(posedge clk_i) begin
  if (!watched_q) begin
    ahead_q <= inside_q - CountWidth'(pop);
    word_q  <= pushed;
  end else if (pop) begin
    ahead_q <= ahead_q - 1'b1;
  end
end
assign its_turn = watched_q && ahead_q == '0;
`TI_ASSERT(WatchedIsInside, watched_q -> ahead_q < inside_q)
