// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// What stands between the registers (`ti_regs`) and the engine: run, drain, flush, interrupt, traffic, counters.
///
/// A flush waits for the rays that were taken before it, also those that the engine has not accepted yet; then the
/// engine forgets its lines, in one idle cycle.  Scene and any-hit go out as they are written.
module ti_host #(
  localparam int unsigned NumCores = ti_config_pkg::Cores,
  localparam int unsigned NumStreams = ti_config_pkg::Streams,
  localparam int unsigned CoreIndexWidth = (NumCores > 1) ? $clog2(NumCores) : 1
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic        s_axil_awvalid,
  output logic        s_axil_awready,
  input  logic [ 7:0] s_axil_awaddr,
  input  logic [ 2:0] s_axil_awprot,
  input  logic        s_axil_wvalid,
  output logic        s_axil_wready,
  input  logic [31:0] s_axil_wdata,
  input  logic [ 3:0] s_axil_wstrb,
  output logic        s_axil_bvalid,
  input  logic        s_axil_bready,
  output logic [ 1:0] s_axil_bresp,
  input  logic        s_axil_arvalid,
  output logic        s_axil_arready,
  input  logic [ 7:0] s_axil_araddr,
  input  logic [ 2:0] s_axil_arprot,
  output logic        s_axil_rvalid,
  input  logic        s_axil_rready,
  output logic [31:0] s_axil_rdata,
  output logic [ 1:0] s_axil_rresp,

  output logic irq_o,

  output ti_pkg::scene_t scene_o,
  output logic any_hit_o,
  output logic run_o,  // rays are taken
  output logic flush_o,  // of the engine
  input logic idle_i,  // of the engine
  input logic [NumStreams-1:0] no_ray_i,  // none waits in front of the engine
  input logic [NumStreams-1:0] no_hit_i,  // none waits behind it
  input logic [NumStreams-1:0] take_i,  // a ray is taken
  input logic [NumStreams-1:0] give_i,  // a hit leaves the engine
  input ti_pkg::hit_t hit_i[NumStreams],

  output logic                                            count_run_o,
  output logic                                            snapshot_o,
  output logic                       [CoreIndexWidth-1:0] count_core_o,
  output ti_count_pkg::unit_index_t                       count_unit_o,
  output ti_count_pkg::event_index_t                      count_event_o,
  input  ti_count_pkg::count_t                            count_i
);

  // A cycle more on the way of answers to writes and one on that of reads: so a read behind the answer to a write of
  // COUNTER_SELECT or SNAPSHOT finds what that asked for, which takes 4 cycles.
  logic b_valid, b_ready, ar_valid, ar_ready;
  logic [1:0] b_resp;
  logic [7:0] ar_addr;
  logic [2:0] ar_prot;

  ti_fifo #(
    .payload_t(logic [1:0]),
    .Depth    (2)
  ) u_b (
    .clk_i,
    .rst_ni,
    .in_valid_i (b_valid),
    .in_ready_o (b_ready),
    .in_data_i  (b_resp),
    .out_valid_o(s_axil_bvalid),
    .out_ready_i(s_axil_bready),
    .out_data_o (s_axil_bresp)
  );
  ti_fifo #(
    .payload_t(logic [10:0]),
    .Depth    (2)
  ) u_ar (
    .clk_i,
    .rst_ni,
    .in_valid_i (s_axil_arvalid),
    .in_ready_o (s_axil_arready),
    .in_data_i  ({s_axil_arprot, s_axil_araddr}),
    .out_valid_o(ar_valid),
    .out_ready_i(ar_ready),
    .out_data_o ({ar_prot, ar_addr})
  );

  ti_regs_pkg::ti_regs__in_t  in;
  ti_regs_pkg::ti_regs__out_t out;

  ti_regs u_regs (
    .clk           (clk_i),
    .rst_n         (rst_ni),
    .s_axil_awvalid,
    .s_axil_awready,
    .s_axil_awaddr,
    .s_axil_awprot,
    .s_axil_wvalid,
    .s_axil_wready,
    .s_axil_wdata,
    .s_axil_wstrb,
    .s_axil_bvalid (b_valid),
    .s_axil_bready (b_ready),
    .s_axil_bresp  (b_resp),
    .s_axil_arvalid(ar_valid),
    .s_axil_arready(ar_ready),
    .s_axil_araddr (ar_addr),
    .s_axil_arprot (ar_prot),
    .s_axil_rvalid,
    .s_axil_rready,
    .s_axil_rdata,
    .s_axil_rresp,
    .hwif_in       (in),
    .hwif_out      (out)
  );

  // Run, drain, flush.
  logic flush, flush_q, idle_q, idle_q2;

  assign flush   = out.CONTROL.flush.value;
  assign run_o   = out.CONTROL.run.value && !flush;
  assign flush_o = flush && (&no_ray_i);

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      flush_q <= 1'b0;
      idle_q  <= 1'b1;
      idle_q2 <= 1'b1;
    end else begin
      flush_q <= flush_o;  // as the engine has it
      idle_q  <= idle_i && (&no_ray_i) && (&no_hit_i);
      idle_q2 <= idle_q;
    end
  end

  // Scene.
  assign any_hit_o = out.CONTROL.any_hit.value;
  assign scene_o.root = $bits(scene_o.root)'(out.ROOT.value.value);
  assign scene_o.num_list = out.NUM_LIST.value.value;
  assign scene_o.num_records = $bits(scene_o.num_records)'(out.NUM_RECORDS.value.value);
  assign scene_o.node_base = address(out.NODE_BASE_HI.value.value, out.NODE_BASE_LO.value.value);
  assign scene_o.list_base = address(out.LIST_BASE_HI.value.value, out.LIST_BASE_LO.value.value);
  assign scene_o.plane_base = address(out.PLANE_BASE_HI.value.value, out.PLANE_BASE_LO.value.value);
  assign scene_o.bary_base = address(out.BARY_BASE_HI.value.value, out.BARY_BASE_LO.value.value);
  for (genvar axis = 0; axis < 3; axis++) begin : gen_box
    assign scene_o.box_lo[axis] = ti_pkg::fp_t'(out.BOX_LO[axis].value.value);
    assign scene_o.box_hi[axis] = ti_pkg::fp_t'(out.BOX_HI[axis].value.value);
  end

  function automatic ti_mem_pkg::addr_t address(logic [31:0] high, logic [31:0] low);
    return ti_mem_pkg::addr_t'({high, low});
  endfunction

  // Traffic: what passed a cycle ago.
  localparam int unsigned StatusWidth = $bits(ti_pkg::status_e);
  logic [NumStreams-1:0] take_q, give_q;
  logic [NumStreams-1:0][StatusWidth-1:0] status_q;
  logic [2**StatusWidth-1:1][NumStreams-1:0] ended;  // by status, those with an error
  logic [2**StatusWidth-1:1][31:0] ended_q;
  ti_count_pkg::count_t rays_q, hits_q;

  always_comb begin
    for (int unsigned status = 1; status < 2 ** StatusWidth; status++) begin
      for (int unsigned s = 0; s < NumStreams; s++) begin
        ended[status][s] = give_q[s] && status_q[s] == StatusWidth'(status);
      end
    end
  end
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      take_q  <= '0;
      give_q  <= '0;
      rays_q  <= '0;
      hits_q  <= '0;
      ended_q <= '0;
    end else begin
      take_q <= take_i;
      give_q <= give_i;
      rays_q <= rays_q + $bits(rays_q)'($countones(take_q));
      hits_q <= hits_q + $bits(hits_q)'($countones(give_q));
      for (int unsigned status = 1; status < 2 ** StatusWidth; status++) begin
        ended_q[status] <= ended_q[status] + 32'($countones(ended[status]));
      end
    end
  end
  for (genvar s = 0; s < NumStreams; s++) begin : gen_stream
    always_ff @(posedge clk_i) status_q[s] <= hit_i[s].status;
  end

  // Interrupt.
  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) begin
      irq_o <= 1'b0;
    end else begin
      irq_o <= (out.IRQ_STATUS.invalid_ray.value && out.IRQ_ENABLE.invalid_ray.value) ||
          (out.IRQ_STATUS.memory_error.value && out.IRQ_ENABLE.memory_error.value) ||
          (out.IRQ_STATUS.watchdog.value && out.IRQ_ENABLE.watchdog.value) ||
          (out.IRQ_STATUS.drained.value && out.IRQ_ENABLE.drained.value);
    end
  end

  // Counters; a number beyond the last reads 0.
  logic known;
  assign known = 32'(out.COUNTER_SELECT.core.value) < NumCores &&
      32'(out.COUNTER_SELECT.unit.value) < ti_count_pkg::NumUnits &&
      out.COUNTER_SELECT.event_number.value >> $bits(
      count_event_o
  ) == '0;
  assign count_run_o = out.CONTROL.count.value;
  assign snapshot_o = out.SNAPSHOT.take.value;
  assign count_core_o = CoreIndexWidth'(out.COUNTER_SELECT.core.value);
  assign count_unit_o = $bits(count_unit_o)'(out.COUNTER_SELECT.unit.value);
  assign count_event_o = $bits(count_event_o)'(out.COUNTER_SELECT.event_number.value);

  ti_count_pkg::count_t count_q;
  always_ff @(posedge clk_i) count_q <= known ? count_i : '0;

  // What the registers show.
  always_comb begin
    in.CONFIG_HASH.value.next                            = ti_config_pkg::Hash;
    in.FORMAT.exp_bits.next                              = 8'(ti_config_pkg::ExpBits);
    in.FORMAT.frac_bits.next                             = 8'(ti_config_pkg::FracBits);
    in.FORMAT.rounding.next                              = 1'(ti_config_pkg::Rounding);
    in.FORMAT.subnormals.next                            = 1'(ti_config_pkg::Subnormals);
    in.MACHINE.cores.next                                = 8'(NumCores);
    in.MACHINE.streams.next                              = 8'(NumStreams);
    in.MACHINE.triangle_test.next                        = 2'(ti_config_pkg::TriangleTest);
    in.MACHINE.traversal.next                            = 1'(ti_config_pkg::Traversal);
    in.MACHINE.any_hit.next                              = ti_config_pkg::AnyHit;
    in.MACHINE.counters.next                             = ti_config_pkg::Counters;
    in.MACHINE.snapshot.next                             = ti_config_pkg::CounterSnapshot;
    in.MACHINE.stream_clock.next                         = 1'(ti_config_pkg::StreamClock);
    in.UNITS.num_trv.next                                = 10'(ti_config_pkg::NumTrv);
    in.UNITS.num_list.next                               = 10'(ti_config_pkg::NumList);
    in.UNITS.num_ist1.next                               = 10'(ti_config_pkg::NumIst1);
    in.MEMORY.line_bytes.next                            = 8'(ti_config_pkg::LineBytes);
    in.MEMORY.addr_bits.next                             = 8'(ti_config_pkg::AddrBits);
    in.CONTROL.flush.hwclr                               = flush_q && idle_i;
    in.STATUS.idle.next                                  = idle_q;
    in.STATUS.flushing.next                              = flush;
    in.IRQ_STATUS.invalid_ray.hwset                      = |ended[ti_pkg::InvalidRay];
    in.IRQ_STATUS.memory_error.hwset                     = |ended[ti_pkg::MemoryError];
    in.IRQ_STATUS.watchdog.hwset                         = |ended[ti_pkg::Watchdog];
    in.IRQ_STATUS.drained.hwset                          = idle_q && !idle_q2;
    {in.RAYS_HI.value.next, in.RAYS_LO.value.next}       = rays_q;
    {in.HITS_HI.value.next, in.HITS_LO.value.next}       = hits_q;
    in.INVALID_RAYS.value.next                           = ended_q[ti_pkg::InvalidRay];
    in.MEMORY_ERRORS.value.next                          = ended_q[ti_pkg::MemoryError];
    in.WATCHDOGS.value.next                              = ended_q[ti_pkg::Watchdog];
    {in.COUNTER_HI.value.next, in.COUNTER_LO.value.next} = count_q;
  end

  `TI_ASSERT(NoRayDuringAFlush, flush -> take_i == '0)
  `TI_COVER(FlushWaitsForRays, flush && !idle_i)

endmodule : ti_host
