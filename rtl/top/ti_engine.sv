// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// The traversal and intersection engine: rays in, hits out, one AXI4 read port a core.
///
/// `NumCores` cores trace rays of one scene.  Every ray that goes in comes out exactly once, at the stream of the same
/// number; hits come in any order and carry the ray's number.  A stream moves a ray and a hit a cycle and serves
/// NumCores / NumStreams cores, in tiles (`ti_core_deal`).  The taker of hits must not wait for rays to be accepted.
/// All inputs but the reset go into registers and all outputs come from them.
///
/// `scene_i` is taken over in each cycle in which `idle_o` is 1, so it may change at any time and holds for rays
/// accepted after the engine has been idle.  A new scene at the addresses of an old one needs a flush: while
/// `flush_i` is 1 no ray is accepted, and lines are forgotten in the cycle after each idle one, so before a ray can ask for any; hold
/// it until `idle_o` is 1.
///
/// Reset: see `ti_axi_read` on reads in flight.
///
/// Counters count while `count_run_i` is 1; `count_o` is counter `count_event_i` of unit `count_unit_i` of core
/// `count_core_i` (`ti_count_pkg`), 2 cycles after it was asked for.  With `ti_config_pkg::CounterSnapshot` it is what
/// the counter was at the last `snapshot_i`, of all units in the same cycle.
module ti_engine #(
  localparam int unsigned NumCores = ti_config_pkg::Cores,
  localparam int unsigned NumStreams = ti_config_pkg::Streams,
  localparam int unsigned CoreIndexWidth = (NumCores > 1) ? $clog2(NumCores) : 1,
  localparam int unsigned AxiIdWidth = (ti_config_pkg::MaxReads > 1) ? $clog2(
      ti_config_pkg::MaxReads
  ) : 1
) (
  input  logic           clk_i,
  input  logic           rst_ni,
  input  logic           flush_i,
  output logic           idle_o,   // no ray inside
  input  ti_pkg::scene_t scene_i,

  input  logic         [NumStreams-1:0] ray_valid_i,
  output logic         [NumStreams-1:0] ray_ready_o,
  input  ti_pkg::ray_t                  ray_data_i [NumStreams],

  output logic         [NumStreams-1:0] hit_valid_o,
  input  logic         [NumStreams-1:0] hit_ready_i,
  output ti_pkg::hit_t                  hit_data_o [NumStreams],

  // Core c has the element c of each.
  output logic              [  NumCores-1:0] m_axi_arvalid,
  input  logic              [  NumCores-1:0] m_axi_arready,
  output logic              [AxiIdWidth-1:0] m_axi_arid   [NumCores],
  output ti_mem_pkg::addr_t                  m_axi_araddr [NumCores],
  output logic              [           7:0] m_axi_arlen  [NumCores],
  output logic              [           2:0] m_axi_arsize [NumCores],
  output logic              [           1:0] m_axi_arburst[NumCores],
  output logic              [  NumCores-1:0] m_axi_arlock,
  output logic              [           3:0] m_axi_arcache[NumCores],
  output logic              [           2:0] m_axi_arprot [NumCores],
  output logic              [           3:0] m_axi_arqos  [NumCores],
  input  logic              [  NumCores-1:0] m_axi_rvalid,
  output logic              [  NumCores-1:0] m_axi_rready,
  input  logic              [AxiIdWidth-1:0] m_axi_rid    [NumCores],
  input  ti_mem_pkg::line_t                  m_axi_rdata  [NumCores],
  input  logic              [           1:0] m_axi_rresp  [NumCores],
  input  logic              [  NumCores-1:0] m_axi_rlast,

  input  logic                                            count_run_i,
  input  logic                                            snapshot_i,
  input  logic                       [CoreIndexWidth-1:0] count_core_i,
  input  ti_count_pkg::unit_index_t                       count_unit_i,
  input  ti_count_pkg::event_index_t                      count_event_i,
  output ti_count_pkg::count_t                            count_o
);

  localparam int unsigned NumPorts = ti_mem_pkg::NumPorts;
  localparam int unsigned NumL2Banks = (ti_mem_pkg::NumBanks > 0) ? ti_mem_pkg::NumBanks : 1;

  localparam int unsigned BankIndexWidth = (ti_mem_pkg::NumBanks > 0) ? $clog2(
      ti_mem_pkg::NumBanks + 1
  ) : 1;

  // Streams, each of the cores from s * CoresEach on.
  localparam int unsigned CoresEach = NumCores / NumStreams;
  logic [NumStreams-1:0] take, give, deal_ready;
  logic flush_q;
  logic [NumCores-1:0] core_ray_valid, core_ray_ready, core_hit_valid, core_hit_ready;
  logic [NumCores-1:0] core_idle, core_hit_lost;
  ti_pkg::ray_t core_ray[NumCores];
  ti_pkg::hit_t core_hit[NumCores];

  for (genvar s = 0; s < NumStreams; s++) begin : gen_stream
    ti_pkg::ray_t ray[CoresEach];
    ti_pkg::hit_t hit[CoresEach];
    for (genvar c = 0; c < CoresEach; c++) begin : gen_core
      assign core_ray[s*CoresEach+c] = ray[c];
      assign hit[c] = core_hit[s*CoresEach+c];
    end

    ti_core_deal #(
      .NumCores(CoresEach),
      .Tile    (ti_config_pkg::CoreTile)
    ) u_deal (
      .clk_i,
      .rst_ni,
      .ray_valid_i (ray_valid_i[s] && !flush_q),
      .ray_ready_o (deal_ready[s]),
      .ray_data_i  (ray_data_i[s]),
      .core_valid_o(core_ray_valid[s*CoresEach+:CoresEach]),
      .core_ready_i(core_ray_ready[s*CoresEach+:CoresEach]),
      .core_data_o (ray)
    );

    ti_arbiter #(
      .payload_t(ti_pkg::hit_t),
      .NumIn    (CoresEach)
    ) u_hits (
      .clk_i,
      .rst_ni,
      .in_valid_i (core_hit_valid[s*CoresEach+:CoresEach]),
      .in_ready_o (core_hit_ready[s*CoresEach+:CoresEach]),
      .in_lost_o  (core_hit_lost[s*CoresEach+:CoresEach]),
      .in_data_i  (hit),
      .out_valid_o(hit_valid_o[s]),
      .out_ready_i(hit_ready_i[s]),
      .out_data_o (hit_data_o[s])
    );

    `TI_ASSERT_NEXT(OutHeldUntilTaken, hit_valid_o[s] && !hit_ready_i[s], hit_valid_o[s] && $stable(
                    hit_data_o[s]))
  end

  // Rays inside, those in queues included.
  logic [31:0] inside_q, inside_next;
  logic forget_q, idle;
  ti_pkg::scene_t scene_q;

  assign ray_ready_o = flush_q ? '0 : deal_ready;
  assign take        = ray_valid_i & ray_ready_o;
  assign give        = hit_valid_o & hit_ready_i;
  assign idle        = inside_q == '0;
  assign idle_o      = idle;

  always_comb begin
    inside_next = inside_q;
    for (int unsigned s = 0; s < NumStreams; s++) begin
      if (take[s] != give[s]) inside_next = take[s] ? inside_next + 1'b1 : inside_next - 1'b1;
    end
  end
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      flush_q  <= 1'b0;
      forget_q <= 1'b0;
      inside_q <= '0;
    end else begin
      flush_q  <= flush_i;
      forget_q <= flush_q && idle;
      inside_q <= inside_next;
    end
  end
  always_ff @(posedge clk_i) if (idle) scene_q <= scene_i;

  // Counters.
  logic count_run_q, snapshot_q;
  logic [CoreIndexWidth-1:0] count_core_q, count_core_q2;
  ti_count_pkg::unit_index_t count_unit_q, count_unit_q2;
  ti_count_pkg::event_index_t count_event_q;
  ti_count_pkg::count_t core_count[NumCores];
  ti_count_pkg::count_t memory_count[NumCores];

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      count_run_q <= 1'b0;
      snapshot_q  <= 1'b0;
    end else begin
      count_run_q <= count_run_i;
      snapshot_q  <= snapshot_i;
    end
  end
  always_ff @(posedge clk_i) begin
    count_core_q  <= count_core_i;
    count_core_q2 <= count_core_q;
    count_unit_q  <= count_unit_i;
    count_unit_q2 <= count_unit_q;
    count_event_q <= count_event_i;
  end
  assign count_o = (32'(count_unit_q2) >= ti_count_pkg::UnitTrvL2) ? memory_count[count_core_q2] :
      core_count[count_core_q2];

  for (genvar c = 0; c < NumCores; c++) begin : gen_core
    logic [NumPorts-1:0] line_req_valid, line_req_ready, line_rsp_valid, line_rsp_ready;
    ti_mem_pkg::line_req_t line_req[NumPorts];
    ti_mem_pkg::line_rsp_t line_rsp[NumPorts];
    ti_count_pkg::axi_events_t axi_events;
    ti_count_pkg::l2_events_t l2_events[NumL2Banks];
    logic memory_idle;

    ti_core u_core (
      .clk_i,
      .rst_ni,
      .flush_i         (forget_q),
      .idle_o          (core_idle[c]),
      .scene_i         (scene_q),
      .ray_valid_i     (core_ray_valid[c]),
      .ray_ready_o     (core_ray_ready[c]),
      .ray_data_i      (core_ray[c]),
      .hit_valid_o     (core_hit_valid[c]),
      .hit_ready_i     (core_hit_ready[c]),
      .hit_data_o      (core_hit[c]),
      .line_req_valid_o(line_req_valid),
      .line_req_ready_i(line_req_ready),
      .line_req_data_o (line_req),
      .line_rsp_valid_i(line_rsp_valid),
      .line_rsp_ready_o(line_rsp_ready),
      .line_rsp_data_i (line_rsp),
      .count_run_i     (count_run_q),
      .snapshot_i      (snapshot_q),
      .count_unit_i    (count_unit_q),
      .count_event_i   (count_event_q),
      .count_o         (core_count[c])
    );

    ti_memory u_memory (
      .clk_i,
      .rst_ni,
      .flush_i         (forget_q),
      .idle_o          (memory_idle),
      .line_req_valid_i(line_req_valid),
      .line_req_ready_o(line_req_ready),
      .line_req_data_i (line_req),
      .line_rsp_valid_o(line_rsp_valid),
      .line_rsp_ready_i(line_rsp_ready),
      .line_rsp_data_o (line_rsp),
      .m_axi_arvalid   (m_axi_arvalid[c]),
      .m_axi_arready   (m_axi_arready[c]),
      .m_axi_arid      (m_axi_arid[c]),
      .m_axi_araddr    (m_axi_araddr[c]),
      .m_axi_arlen     (m_axi_arlen[c]),
      .m_axi_arsize    (m_axi_arsize[c]),
      .m_axi_arburst   (m_axi_arburst[c]),
      .m_axi_arlock    (m_axi_arlock[c]),
      .m_axi_arcache   (m_axi_arcache[c]),
      .m_axi_arprot    (m_axi_arprot[c]),
      .m_axi_arqos     (m_axi_arqos[c]),
      .m_axi_rvalid    (m_axi_rvalid[c]),
      .m_axi_rready    (m_axi_rready[c]),
      .m_axi_rid       (m_axi_rid[c]),
      .m_axi_rdata     (m_axi_rdata[c]),
      .m_axi_rresp     (m_axi_rresp[c]),
      .m_axi_rlast     (m_axi_rlast[c]),
      .events_o        (axi_events),
      .l2_events_o     (l2_events)
    );

    // Banks of counters of the memory side, in the order of `ti_count_pkg`.
    ti_count_pkg::count_t counts[ti_mem_pkg::NumBanks+1];
    if (ti_mem_pkg::NumBanks == 0) begin : gen_no_banks
      logic unused_events;
      assign unused_events = ^l2_events[0];
    end
    for (genvar b = 0; b < ti_mem_pkg::NumBanks; b++) begin : gen_l2_counters
      ti_counters #(
        .Num(ti_count_pkg::NumL2Events)
      ) u_counters (
        .clk_i,
        .rst_ni,
        .run_i     (count_run_q),
        .snapshot_i(snapshot_q),
        .events_i  (l2_events[b]),
        .index_i   (count_event_q),
        .count_o   (counts[b])
      );
    end
    ti_counters #(
      .Num(ti_count_pkg::NumAxiEvents)
    ) u_axi_counters (
      .clk_i,
      .rst_ni,
      .run_i     (count_run_q),
      .snapshot_i(snapshot_q),
      .events_i  (axi_events),
      .index_i   (count_event_q),
      .count_o   (counts[ti_mem_pkg::NumBanks])
    );
    logic [BankIndexWidth-1:0] memory_unit;
    assign memory_unit = BankIndexWidth'(32'(count_unit_q2) - ti_count_pkg::UnitTrvL2);
    assign memory_count[c] = (32'(count_unit_q2) < ti_count_pkg::NumUnits) ? counts[memory_unit] :
        '0;

    `TI_ASSERT(IdleMeansEmpty, idle -> core_idle[c] && memory_idle)
    logic unused_idle;
    assign unused_idle = memory_idle;
  end

  logic unused;
  assign unused = ^{core_hit_lost, core_idle};

  if (NumCores < 1) begin : gen_check_cores
    $error("ti_engine: NumCores must be 1 or more");
  end
  if (NumStreams < 1 || CoresEach * NumStreams != NumCores) begin : gen_check_streams
    $error("ti_engine: NumStreams must be 1 or more and divide NumCores");
  end

  `TI_ASSERT(NoHitWithoutARay, give != '0 -> inside_q != '0)
  `TI_COVER(FlushesIdle, forget_q)
  `TI_COVER(FlushWaitsForRays, flush_q && !idle)

endmodule : ti_engine
