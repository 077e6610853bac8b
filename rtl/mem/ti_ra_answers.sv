// SPDX-License-Identifier: Apache-2.0

/// Answers of a `ti_ra`: the element of a word that has been read, on its way out.
///
/// Latency 0, the word as the L1 gives it.  From `LookupStages` 3 on answers wait in a queue of two, where the path from
/// `rsp_ready_i` ends; from 4 on the word is registered first, as a block RAM gives it late, before the element is chosen.
/// One a cycle, in order.
module ti_ra_answers #(
  parameter int unsigned SlotWidth = 3,
  parameter int unsigned WordBytes = 64,
  /// Bytes of an element, WordBytes or a part of it.
  parameter int unsigned ElemBytes = 8,
  parameter int unsigned LookupStages = 1,
  localparam int unsigned Parts = WordBytes / ((ElemBytes > 0) ? ElemBytes : 1),
  localparam int unsigned PartWidth = (Parts > 1) ? $clog2(Parts) : 1
) (
  input  logic clk_i,
  input  logic rst_ni,
  output logic idle_o,  // no answer inside

  // A word that has been read, and which element of it.
  input  logic                   read_valid_i,
  output logic                   read_ready_o,
  input  logic [  SlotWidth-1:0] read_slot_i,
  input  logic                   read_error_i,
  input  logic [  PartWidth-1:0] read_part_i,
  input  logic [8*WordBytes-1:0] read_word_i,

  output logic                   rsp_valid_o,
  input  logic                   rsp_ready_i,
  output logic [  SlotWidth-1:0] rsp_slot_o,
  output logic [8*ElemBytes-1:0] rsp_elem_o,
  output logic                   rsp_error_o
);

  typedef struct packed {
    logic [SlotWidth-1:0]   slot;
    logic                   error;
    logic [PartWidth-1:0]   part;
    logic [8*WordBytes-1:0] word;
  } read_t;

  typedef struct packed {
    logic [SlotWidth-1:0]   slot;
    logic                   error;
    logic [8*ElemBytes-1:0] elem;
  } answer_t;

  read_t in, read;
  answer_t answer;
  logic read_valid, read_ready;
  assign in = '{slot: read_slot_i, error: read_error_i, part: read_part_i, word: read_word_i};

  if (LookupStages < 4) begin : gen_at_once
    assign read_valid   = read_valid_i;
    assign read_ready_o = read_ready;
    assign read         = in;
  end else begin : gen_word
    ti_stage #(
      .payload_t(read_t)
    ) u_word (
      .clk_i,
      .rst_ni,
      .in_valid_i (read_valid_i),
      .in_ready_o (read_ready_o),
      .in_data_i  (in),
      .out_valid_o(read_valid),
      .out_ready_i(read_ready),
      .out_data_o (read)
    );
  end

  always_comb begin
    answer.slot  = read.slot;
    answer.error = read.error;
    answer.elem  = read.word[(32'(read.part)*ElemBytes*8)+:ElemBytes*8];
  end

  if (LookupStages < 3) begin : gen_no_queue
    logic unused;
    assign unused                                = clk_i & rst_ni;
    assign rsp_valid_o                           = read_valid;
    assign read_ready                            = rsp_ready_i;
    assign {rsp_slot_o, rsp_error_o, rsp_elem_o} = answer;
  end else begin : gen_queue
    ti_fifo #(
      .payload_t(answer_t),
      .Depth    (2)
    ) u_answers (
      .clk_i,
      .rst_ni,
      .in_valid_i (read_valid),
      .in_ready_o (read_ready),
      .in_data_i  (answer),
      .out_valid_o(rsp_valid_o),
      .out_ready_i(rsp_ready_i),
      .out_data_o ({rsp_slot_o, rsp_error_o, rsp_elem_o})
    );
  end
  assign idle_o = !read_valid && !rsp_valid_o;

  if (SlotWidth < 1) begin : gen_check_slot_width
    $error("ti_ra_answers: SlotWidth must be 1 or more");
  end
  if (LookupStages < 1 || LookupStages > 5) begin : gen_check_lookup_stages
    $error("ti_ra_answers: LookupStages must be 1 to 5");
  end
  if (Parts * ElemBytes != WordBytes || (Parts & (Parts - 1)) != 0) begin : gen_check_elem_bytes
    $error("ti_ra_answers: ElemBytes must divide WordBytes into a power of two");
  end

endmodule : ti_ra_answers
