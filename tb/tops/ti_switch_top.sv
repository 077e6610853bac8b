// SPDX-License-Identifier: Apache-2.0

/// Arbiters and crossbars of several sizes side by side, for their tests.
///
/// Arbiter a has the `ArbiterIn[a]` inputs after those of the arbiters before it.  Crossbar x has
/// `XbarIn[x]` inputs and `XbarOut[x]` outputs, laid out in the same way.  A payload has 16 bits; in
/// a crossbar the top three of them say where the beat goes.
module ti_switch_top #(
  localparam int unsigned NumArbiters = 3,
  localparam int unsigned ArbiterIn[NumArbiters] = '{1, 2, 5},
  localparam int unsigned ArbiterInputs = 8,
  localparam int unsigned NumXbars = 4,
  localparam int unsigned XbarIn[NumXbars] = '{4, 3, 5, 1},
  localparam int unsigned XbarOut[NumXbars] = '{4, 5, 2, 1},
  localparam int unsigned XbarInputs = 13,
  localparam int unsigned XbarOutputs = 12
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic        in_valid_i[ArbiterInputs],
  output logic        in_ready_o[ArbiterInputs],
  output logic        in_lost_o [ArbiterInputs],
  input  logic [15:0] in_data_i [ArbiterInputs],

  output logic        out_valid_o[NumArbiters],
  input  logic        out_ready_i[NumArbiters],
  output logic [15:0] out_data_o [NumArbiters],

  input  logic        xbar_in_valid_i[XbarInputs],
  output logic        xbar_in_ready_o[XbarInputs],
  output logic        xbar_in_lost_o [XbarInputs],
  input  logic [15:0] xbar_in_data_i [XbarInputs],

  output logic        xbar_out_valid_o[XbarOutputs],
  input  logic        xbar_out_ready_i[XbarOutputs],
  output logic [15:0] xbar_out_data_o [XbarOutputs]
);

  typedef logic [15:0] payload_t;

  for (genvar a = 0; a < NumArbiters; a++) begin : gen_arbiter
    localparam int unsigned Num = ArbiterIn[a];
    localparam int unsigned First = (a == 0) ? 0 : (a == 1) ? 1 : 3;
    logic [Num-1:0] valid, ready, lost;
    payload_t data[Num];

    for (genvar i = 0; i < Num; i++) begin : gen_in
      assign valid[i]            = in_valid_i[First+i];
      assign data[i]             = in_data_i[First+i];
      assign in_ready_o[First+i] = ready[i];
      assign in_lost_o[First+i]  = lost[i];
    end

    ti_arbiter #(
      .payload_t(payload_t),
      .NumIn    (Num)
    ) u_arbiter (
      .clk_i,
      .rst_ni,
      .in_valid_i (valid),
      .in_ready_o (ready),
      .in_lost_o  (lost),
      .in_data_i  (data),
      .out_valid_o(out_valid_o[a]),
      .out_ready_i(out_ready_i[a]),
      .out_data_o (out_data_o[a])
    );
  end

  for (genvar x = 0; x < NumXbars; x++) begin : gen_xbar
    localparam int unsigned NumIn = XbarIn[x];
    localparam int unsigned NumOut = XbarOut[x];
    localparam int unsigned FirstIn = (x == 0) ? 0 : (x == 1) ? 4 : (x == 2) ? 7 : 12;
    localparam int unsigned FirstOut = (x == 0) ? 0 : (x == 1) ? 4 : (x == 2) ? 9 : 11;
    localparam int unsigned DestWidth = (NumOut > 1) ? $clog2(NumOut) : 1;
    logic [NumIn-1:0] in_valid, in_ready, in_lost;
    payload_t in_data[NumIn];
    logic [NumIn-1:0][DestWidth-1:0] in_dest;
    logic [NumOut-1:0] out_valid, out_ready;
    payload_t out_data[NumOut];

    for (genvar i = 0; i < NumIn; i++) begin : gen_in
      assign in_valid[i]                = xbar_in_valid_i[FirstIn+i];
      assign in_data[i]                 = xbar_in_data_i[FirstIn+i];
      assign in_dest[i]                 = xbar_in_data_i[FirstIn+i][13+:DestWidth];
      assign xbar_in_ready_o[FirstIn+i] = in_ready[i];
      assign xbar_in_lost_o[FirstIn+i]  = in_lost[i];
    end
    for (genvar o = 0; o < NumOut; o++) begin : gen_out
      assign xbar_out_valid_o[FirstOut+o] = out_valid[o];
      assign xbar_out_data_o[FirstOut+o]  = out_data[o];
      assign out_ready[o]                 = xbar_out_ready_i[FirstOut+o];
    end

    ti_xbar #(
      .payload_t(payload_t),
      .NumIn    (NumIn),
      .NumOut   (NumOut)
    ) u_xbar (
      .clk_i,
      .rst_ni,
      .in_valid_i (in_valid),
      .in_ready_o (in_ready),
      .in_lost_o  (in_lost),
      .in_data_i  (in_data),
      .in_dest_i  (in_dest),
      .out_valid_o(out_valid),
      .out_ready_i(out_ready),
      .out_data_o (out_data)
    );
  end

endmodule : ti_switch_top
