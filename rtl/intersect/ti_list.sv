// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// LIST: reads the triangle numbers of a leaf and sends one test for each.
///
/// A leaf lives in a slot; the slots are served in turn, one list entry a cycle in all.  From a leaf taken to its
/// first test 3 cycles and `lookup_stages` with the line in the L1.  All tests of a leaf go out as fast as they are read;
/// they need not wait for one another.  When memory answers with an error, or the entry lies beyond
/// `num_list_i` or names a triangle beyond `num_records_i`, one return token accounts for all tests that the
/// leaf still had to send.  The caller guarantees `leaf.count` >= 1.
module ti_list #(
  parameter int unsigned NumSlots = 4,
  parameter int unsigned Rows = 2,
  parameter int unsigned CacheBytes = 512,
  parameter int unsigned Ways = 2
) (
  input  logic                clk_i,
  input  logic                rst_ni,
  input  logic                flush_i,       // forget all lines; only while idle
  output logic                idle_o,        // no leaf inside, nothing on its way
  input  ti_mem_pkg::addr_t   list_base_i,   // a multiple of 4
  input  ti_pkg::list_index_t num_list_i,    // entries
  input  ti_pkg::record_t     num_records_i, // triangles

  input  logic          leaf_valid_i,
  output logic          leaf_ready_o,
  input  ti_pkg::leaf_t leaf_data_i,

  output logic                    test_valid_o,
  input  logic                    test_ready_i,
  output ti_intersect_pkg::test_t test_data_o,

  output logic            return_valid_o,
  input  logic            return_ready_i,
  output ti_pkg::return_t return_data_o,

  output logic                  line_req_valid_o,
  input  logic                  line_req_ready_i,
  output ti_mem_pkg::line_req_t line_req_data_o,

  input  logic                  line_rsp_valid_i,
  output logic                  line_rsp_ready_o,
  input  ti_mem_pkg::line_rsp_t line_rsp_data_i,

  output ti_count_pkg::list_events_t events_o  // `room` where an output waits
);

  localparam int unsigned SlotWidth = $clog2(NumSlots);
  typedef logic [SlotWidth-1:0] slot_t;

  // Slots: what the tests of the leaf share, the entry that is read next, and how many are left from it on.
  typedef struct packed {
    ti_pkg::home_t         home;
    ti_pkg::ray_operands_t operands;
    ti_pkg::fp_t           tnear;
    ti_pkg::fp_t           tfar;
  } shared_t;
  typedef struct packed {
    ti_pkg::list_index_t position;
    ti_pkg::tri_count_t  count;
  } left_t;
  localparam int unsigned WordWidth = ti_mem_pkg::AddrWidth - 2;
  typedef logic [WordWidth-1:0] word_addr_t;

  logic slot_free, take, again, write, done, step;
  slot_t new_slot, rsp_slot, answer_slot_q;
  left_t left, left_next;  // of the slot that is answered, and as it is written
  left_t answer_left_q;  // the entry after the answer's, and how many there were with it
  word_addr_t next_word;

  assign leaf_ready_o = slot_free && !again;
  assign take         = leaf_valid_i && leaf_ready_o;
  assign write        = again || (leaf_valid_i && slot_free);  // either

  ti_slot_pool #(
    .NumSlots(NumSlots),
    .Late    (ti_config_pkg::LookupStages > 4)
  ) u_pool (
    .clk_i,
    .rst_ni,
    .free_valid_o(slot_free),
    .free_slot_o (new_slot),
    .take_i      (take),
    .give_i      (done),
    .give_slot_i (answer_slot_q)
  );

  // Whoever has ids left stands in this queue once; a leaf that goes on comes before a new one.
  logic next_valid, next_ready;
  slot_t next_slot;

  ti_queue #(
    .payload_t(slot_t),
    .Depth    (NumSlots)
  ) u_next (
    .clk_i,
    .rst_ni,
    .push_i     (write),
    .push_data_i(again ? answer_slot_q : new_slot),
    .out_valid_o(next_valid),
    .out_ready_i(next_ready),
    .out_data_o (next_slot)
  );

  // A leaf that is taken or goes on; its entry's address is made here, to be there when its turn comes.
  slot_t write_slot;
  word_addr_t list_word, again_word, first_word;
  assign list_word = word_addr_t'(list_base_i >> 2);
  assign again_word = list_word + word_addr_t'(answer_left_q.position);
  assign first_word = list_word + word_addr_t'(leaf_data_i.first);
  assign write_slot = again ? answer_slot_q : new_slot;
  assign left_next = again ?
      '{position: answer_left_q.position, count: answer_left_q.count - 1'b1} :
      '{position: leaf_data_i.first, count: leaf_data_i.count};
  ti_regfile #(
    .Depth (NumSlots),
    .word_t(left_t)
  ) u_left (
    .clk_i,
    .read_addr_i (rsp_slot),
    .read_data_o (left),
    .write_en_i  (write),
    .write_addr_i(write_slot),
    .write_data_i(left_next)
  );
  ti_regfile #(
    .Depth (NumSlots),
    .word_t(word_addr_t)
  ) u_words (
    .clk_i,
    .read_addr_i (next_slot),
    .read_data_o (next_word),
    .write_en_i  (write),
    .write_addr_i(write_slot),
    .write_data_i(again ? again_word : first_word)
  );

  logic rsp_valid, rsp_ready, rsp_error;
  logic [31:0] rsp_id;
  logic ra_idle, ra_waits;
  ti_count_pkg::cache_events_t cache_events;

  ti_ra #(
    .NumSlots  (NumSlots),
    .Rows      (Rows),
    .ElemBytes (4),
    .CacheBytes(CacheBytes),
    .Ways      (Ways),
    .Mode      (ti_config_pkg::RayAccumulation)
  ) u_ra (
    .clk_i,
    .rst_ni,
    .flush_i,
    .idle_o     (ra_idle),
    .waits_o    (ra_waits),
    .req_valid_i(next_valid),
    .req_ready_o(next_ready),
    .req_slot_i (next_slot),
    .req_addr_i ({next_word, 2'b00}),
    .rsp_valid_o(rsp_valid),
    .rsp_ready_i(rsp_ready),
    .rsp_slot_o (rsp_slot),
    .rsp_elem_o (rsp_id),
    .rsp_error_o(rsp_error),
    .line_req_valid_o,
    .line_req_ready_i,
    .line_req_data_o,
    .line_rsp_valid_i,
    .line_rsp_ready_o,
    .line_rsp_data_i,
    .events_o   (cache_events)
  );

  // The answer beside the slot's shared operands.
  logic answer_valid_q, answer_error_q, answer_last_q, answer_taken;
  ti_pkg::record_t answer_record_q;
  shared_t shared;

  assign rsp_ready = !answer_valid_q || answer_taken;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) answer_valid_q <= 1'b0;
    else if (rsp_ready) answer_valid_q <= rsp_valid;
  end

  always_ff @(posedge clk_i) begin
    if (rsp_valid && rsp_ready) begin
      answer_slot_q   <= rsp_slot;
      answer_record_q <= ti_pkg::record_t'(rsp_id);
      answer_error_q  <= rsp_error || left.position >= num_list_i || rsp_id >= 32'(num_records_i);
      answer_last_q   <= left.count == 16'd1;
      answer_left_q   <= '{position: left.position + 1'b1, count: left.count};
    end
  end

  ti_ram_1r1w #(
    .Depth (NumSlots),
    .word_t(shared_t)
  ) u_shared (
    .clk_i,
    .read_en_i(rsp_valid && rsp_ready),
    .read_addr_i(rsp_slot),
    .read_data_o(shared),
    .write_en_i(take),
    .write_addr_i(new_slot),
    .write_data_i(
    '{
        home: leaf_data_i.home,
        operands: leaf_data_i.operands,
        tnear: leaf_data_i.tnear,
        tfar: leaf_data_i.tfar
    }
    )
  );

  assign test_valid_o = answer_valid_q && !answer_error_q;
  assign test_data_o = '{
          home: shared.home,
          record: answer_record_q,
          operands: shared.operands,
          tnear: shared.tnear,
          tfar: shared.tfar
      };

  assign return_valid_o = answer_valid_q && answer_error_q;
  always_comb begin
    return_data_o       = '0;
    return_data_o.home  = shared.home;
    return_data_o.count = answer_left_q.count;
    return_data_o.error = 1'b1;
  end

  assign step         = test_valid_o && test_ready_i;
  assign answer_taken = step || (return_valid_o && return_ready_i);
  assign again        = step && !answer_last_q;
  assign done         = answer_taken && !again;

  // What happens, for counting.
  logic [SlotWidth:0] inside_q;  // leaves
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) inside_q <= '0;
    else if (take != done) inside_q <= take ? inside_q + 1'b1 : inside_q - 1'b1;
  end
  assign idle_o = inside_q == '0 && ra_idle;

  always_comb begin
    events_o.activity = '0;
    if (step) events_o.activity.works = 1'b1;
    else if (answer_valid_q && !answer_taken) events_o.activity.room = 1'b1;
    else if (ra_waits) events_o.activity.memory = 1'b1;
    else if (inside_q != '0) events_o.activity.latency = 1'b1;
    else events_o.activity.empty = 1'b1;

    events_o.ids   = step;
    events_o.cache = cache_events;
  end

  `TI_ASSERT(LeafHasTriangles, leaf_valid_i -> leaf_data_i.count != '0)
  `TI_ASSERT_NEXT(TestHeldUntilTaken, test_valid_o && !test_ready_i, test_valid_o && $stable
                  (test_data_o))
  `TI_ASSERT_NEXT(ReturnHeldUntilTaken, return_valid_o && !return_ready_i,
                  return_valid_o && $stable(return_data_o))
  `TI_ASSERT_KNOWN(LeafReadyKnown, leaf_ready_o)
  `TI_ASSERT_KNOWN(TestValidKnown, test_valid_o)
  `TI_ASSERT_KNOWN(ReturnValidKnown, return_valid_o)
  `TI_ASSERT_KNOWN(LineReqValidKnown, line_req_valid_o)
  `TI_ASSERT_KNOWN(LineRspReadyKnown, line_rsp_ready_o)

endmodule : ti_list
