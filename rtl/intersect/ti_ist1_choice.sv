// SPDX-License-Identifier: Apache-2.0

/// Which IST1 takes a test.  Combinational.
///
/// By hash, the triangle names the unit, so the private L1s hold different triangles; pairs stay together, as two plane
/// parts share a line of 64 bytes.  By slot, the ray does, so tests spread evenly and each L1 holds what all
/// need.  By spill, the triangle names the unit as long as that is not crowded, else the ray: hot triangles
/// get copies, cold ones do not.
module ti_ist1_choice #(
  /// Units, 1 or more.
  parameter int unsigned NumIst1 = 8,
  parameter ti_config_pkg::ist1_choice_e Choice = ti_config_pkg::Ist1Choice,
  localparam int unsigned IndexWidth = (NumIst1 > 1) ? $clog2(NumIst1) : 1
) (
  input  ti_pkg::record_t                  record_i,
  input  ti_pkg::home_t                    home_i,
  input  logic            [   NumIst1-1:0] crowded_i,  // the unit holds many tests
  output logic            [IndexWidth-1:0] index_o
);

  // The hash: bits 1 to 28 of the record folded onto ten.
  logic [28:1] pair;
  logic [ 9:0] folded;
  logic [IndexWidth-1:0] by_hash, by_slot;
  assign pair = record_i[28:1];
  assign folded = pair[10:1] ^ {pair[13:11], pair[20:14]} ^ {2'b00, pair[28:21]};
  assign by_hash = IndexWidth'(32'(folded) % NumIst1);
  // Rays of a tile have neighbouring slots, and TRVs that walk the same part of the scene neighbouring numbers.
  assign by_slot = IndexWidth'((32'(home_i.slot) + 32'(home_i.trv)) % NumIst1);

  always_comb begin
    unique case (Choice)
      ti_config_pkg::Ist1ChoiceHash: index_o = by_hash;
      ti_config_pkg::Ist1ChoiceSlot: index_o = by_slot;
      default: index_o = crowded_i[by_hash] ? by_slot : by_hash;
    endcase
  end

  logic unused;
  assign unused = record_i[0];

  if (NumIst1 < 1) begin : gen_check_num_ist1
    $error("ti_ist1_choice: NumIst1 must be 1 or more");
  end

endmodule : ti_ist1_choice
