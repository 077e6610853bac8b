// SPDX-License-Identifier: Apache-2.0

/// The small modules of `rtl/common` side by side, with payloads of 16 bits, for their tests.
///
/// Streams: [0] is a `ti_stage`, the others are a `ti_fifo` of `StreamDepth[i]`.  The `ti_queue` has
/// four entries.  `delayed_data_o[c]` is `data_i`, c cycles late.  Pool i has `PoolSlots[i]` slots; the last one
/// is late.
/// Round robin n - 1 has n requests.  RAM and `ti_regfile`, as memory and as registers, share address and writes.
module ti_common_top #(
  localparam int unsigned NumStreams = 6,
  localparam int unsigned StreamDepth[NumStreams] = '{1, 1, 2, 3, 8, 16},
  localparam int unsigned NumDelays = 8,
  localparam int unsigned NumPools = 4,
  localparam int unsigned PoolSlots[NumPools] = '{2, 5, 16, 6},
  localparam int unsigned NumRoundRobins = 6
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic        in_valid_i[NumStreams],
  output logic        in_ready_o[NumStreams],
  input  logic [15:0] in_data_i [NumStreams],

  output logic        out_valid_o[NumStreams],
  input  logic        out_ready_i[NumStreams],
  output logic [15:0] out_data_o [NumStreams],

  input logic        push_i,
  input logic [15:0] push_data_i,

  output logic        queue_valid_o,
  input  logic        queue_ready_i,
  output logic [15:0] queue_data_o,

  input  logic [15:0] data_i,
  output logic [15:0] delayed_data_o[NumDelays],

  input  logic        read_en_i,
  input  logic [ 2:0] read_addr_i,
  output logic [15:0] read_data_o,
  output logic [15:0] file_data_o [2],
  input  logic        write_en_i,
  input  logic [ 2:0] write_addr_i,
  input  logic [15:0] write_data_i,

  output logic       free_valid_o[NumPools],
  output logic [3:0] free_slot_o [NumPools],
  input  logic       take_i      [NumPools],
  input  logic       give_i      [NumPools],
  input  logic [3:0] give_slot_i [NumPools],

  input  logic [NumRoundRobins-1:0] request_i,
  input  logic [               2:0] from_i,
  output logic                      any_o    [NumRoundRobins],
  output logic [               2:0] index_o  [NumRoundRobins]
);

  typedef logic [15:0] payload_t;

  for (genvar i = 0; i < NumStreams; i++) begin : gen_stream
    if (i == 0) begin : gen_stage
      ti_stage #(
        .payload_t(payload_t)
      ) u_stage (
        .clk_i,
        .rst_ni,
        .in_valid_i (in_valid_i[i]),
        .in_ready_o (in_ready_o[i]),
        .in_data_i  (in_data_i[i]),
        .out_valid_o(out_valid_o[i]),
        .out_ready_i(out_ready_i[i]),
        .out_data_o (out_data_o[i])
      );
    end else begin : gen_fifo
      ti_fifo #(
        .payload_t(payload_t),
        .Depth    (StreamDepth[i])
      ) u_fifo (
        .clk_i,
        .rst_ni,
        .in_valid_i (in_valid_i[i]),
        .in_ready_o (in_ready_o[i]),
        .in_data_i  (in_data_i[i]),
        .out_valid_o(out_valid_o[i]),
        .out_ready_i(out_ready_i[i]),
        .out_data_o (out_data_o[i])
      );
    end
  end

  ti_queue #(
    .payload_t(payload_t),
    .Depth    (4)
  ) u_queue (
    .clk_i,
    .rst_ni,
    .push_i,
    .push_data_i,
    .out_valid_o(queue_valid_o),
    .out_ready_i(queue_ready_i),
    .out_data_o (queue_data_o)
  );

  for (genvar c = 0; c < NumDelays; c++) begin : gen_delay
    ti_delay #(
      .payload_t(payload_t),
      .Cycles   (c)
    ) u_delay (
      .clk_i,
      .rst_ni,
      .data_i,
      .data_o(delayed_data_o[c])
    );
  end

  ti_ram_1r1w #(
    .word_t(payload_t),
    .Depth (6)
  ) u_ram (
    .clk_i,
    .read_en_i,
    .read_addr_i,
    .read_data_o,
    .write_en_i,
    .write_addr_i,
    .write_data_i
  );

  for (genvar i = 0; i < 2; i++) begin : gen_file
    ti_regfile #(
      .word_t (payload_t),
      .Depth  (6),
      .RamBits((i == 0) ? 96 : 97)
    ) u_file (
      .clk_i,
      .read_addr_i,
      .read_data_o(file_data_o[i]),
      .write_en_i,
      .write_addr_i,
      .write_data_i
    );
  end

  for (genvar i = 0; i < NumPools; i++) begin : gen_pool
    localparam int unsigned SlotWidth = $clog2(PoolSlots[i]);
    logic [SlotWidth-1:0] free_slot;
    ti_slot_pool #(
      .NumSlots(PoolSlots[i]),
      .Late    (i == NumPools - 1)
    ) u_pool (
      .clk_i,
      .rst_ni,
      .free_valid_o(free_valid_o[i]),
      .free_slot_o (free_slot),
      .take_i      (take_i[i]),
      .give_i      (give_i[i]),
      .give_slot_i (give_slot_i[i][SlotWidth-1:0])
    );
    assign free_slot_o[i] = 4'(free_slot);
  end

  for (genvar n = 1; n <= NumRoundRobins; n++) begin : gen_round_robin
    localparam int unsigned IndexWidth = (n > 1) ? $clog2(n) : 1;
    logic [IndexWidth-1:0] index;
    ti_round_robin #(
      .Num(n)
    ) u_round_robin (
      .request_i(request_i[n-1:0]),
      .from_i   (from_i[IndexWidth-1:0]),
      .any_o    (any_o[n-1]),
      .index_o  (index)
    );
    assign index_o[n-1] = 3'(index);
  end

endmodule : ti_common_top
