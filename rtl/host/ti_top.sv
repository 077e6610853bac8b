// SPDX-License-Identifier: Apache-2.0

/// The engine as a board holds it: AXI4-Lite registers, AXI4-Streams of rays and hits, AXI4 read masters, an interrupt.
///
/// Element c of `m_axi_*` belongs to core c, element s of the streams to stream s; `scripts/wrapper.py` writes a module
/// in plain Verilog with a set of ports for each.  All ports but those of the streams belong to `aclk`.  With
/// `stream_clock` core the streams do too, and `axis_aclk` is not looked at; with own, stream s, its rays and its
/// hits, belongs to `axis_aclk[s]`.
///
/// `aresetn` keeps the setup and hold times of `aclk` when it is released.  It must be low for at least 4 cycles of
/// the slowest clock; the streams come out of reset with their own clocks.
module ti_top #(
  localparam int unsigned NumCores = ti_config_pkg::Cores,
  localparam int unsigned NumStreams = ti_config_pkg::Streams,
  localparam int unsigned AddrBits = ti_config_pkg::AddrBits,
  localparam int unsigned LineBits = 8 * ti_config_pkg::LineBytes,
  localparam int unsigned AxiIdWidth = (ti_config_pkg::MaxReads > 1) ? $clog2(
      ti_config_pkg::MaxReads
  ) : 1
) (
  input  logic                  aclk,
  input  logic                  aresetn,
  input  logic [NumStreams-1:0] axis_aclk,
  output logic                  irq,

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

  input  logic [NumStreams-1:0]        s_axis_ray_tvalid,
  output logic [NumStreams-1:0]        s_axis_ray_tready,
  input  logic [NumStreams-1:0][255:0] s_axis_ray_tdata,
  input  logic [NumStreams-1:0]        s_axis_ray_tlast,

  output logic [NumStreams-1:0]        m_axis_hit_tvalid,
  input  logic [NumStreams-1:0]        m_axis_hit_tready,
  output logic [NumStreams-1:0][255:0] m_axis_hit_tdata,
  output logic [NumStreams-1:0]        m_axis_hit_tlast,

  output logic [NumCores-1:0]                 m_axi_arvalid,
  input  logic [NumCores-1:0]                 m_axi_arready,
  output logic [NumCores-1:0][AxiIdWidth-1:0] m_axi_arid,
  output logic [NumCores-1:0][  AddrBits-1:0] m_axi_araddr,
  output logic [NumCores-1:0][           7:0] m_axi_arlen,
  output logic [NumCores-1:0][           2:0] m_axi_arsize,
  output logic [NumCores-1:0][           1:0] m_axi_arburst,
  output logic [NumCores-1:0]                 m_axi_arlock,
  output logic [NumCores-1:0][           3:0] m_axi_arcache,
  output logic [NumCores-1:0][           2:0] m_axi_arprot,
  output logic [NumCores-1:0][           3:0] m_axi_arqos,
  input  logic [NumCores-1:0]                 m_axi_rvalid,
  output logic [NumCores-1:0]                 m_axi_rready,
  input  logic [NumCores-1:0][AxiIdWidth-1:0] m_axi_rid,
  input  logic [NumCores-1:0][  LineBits-1:0] m_axi_rdata,
  input  logic [NumCores-1:0][           1:0] m_axi_rresp,
  input  logic [NumCores-1:0]                 m_axi_rlast
);

  localparam int unsigned CoreIndexWidth = (NumCores > 1) ? $clog2(NumCores) : 1;

  // Beats that a crossing holds: enough for one a cycle with two flops each way.
  localparam int unsigned CrossingDepth = 8;

  logic run, flush, any_hit, any_hit_q, idle, count_run, snapshot;
  logic [NumStreams-1:0] no_ray, no_hit, take, give;
  logic [NumStreams-1:0] ray_valid, ray_ready, hit_valid, hit_ready;
  ti_pkg::ray_t ray[NumStreams];
  ti_pkg::hit_t hit[NumStreams];
  ti_pkg::scene_t scene;
  logic [CoreIndexWidth-1:0] count_core;
  ti_count_pkg::unit_index_t count_unit;
  ti_count_pkg::event_index_t count_event;
  ti_count_pkg::count_t count;

  ti_host u_host (
    .clk_i        (aclk),
    .rst_ni       (aresetn),
    .s_axil_awvalid,
    .s_axil_awready,
    .s_axil_awaddr,
    .s_axil_awprot,
    .s_axil_wvalid,
    .s_axil_wready,
    .s_axil_wdata,
    .s_axil_wstrb,
    .s_axil_bvalid,
    .s_axil_bready,
    .s_axil_bresp,
    .s_axil_arvalid,
    .s_axil_arready,
    .s_axil_araddr,
    .s_axil_arprot,
    .s_axil_rvalid,
    .s_axil_rready,
    .s_axil_rdata,
    .s_axil_rresp,
    .irq_o        (irq),
    .scene_o      (scene),
    .any_hit_o    (any_hit),
    .run_o        (run),
    .flush_o      (flush),
    .idle_i       (idle),
    .no_ray_i     (no_ray),
    .no_hit_i     (no_hit),
    .take_i       (take),
    .give_i       (give),
    .hit_i        (hit),
    .count_run_o  (count_run),
    .snapshot_o   (snapshot),
    .count_core_o (count_core),
    .count_unit_o (count_unit),
    .count_event_o(count_event),
    .count_i      (count)
  );

  // Taken over as the scene is.
  always_ff @(posedge aclk) if (idle) any_hit_q <= any_hit;

  // Streams.
  typedef struct packed {
    logic         last;
    logic [255:0] data;
  } beat_t;

  for (genvar s = 0; s < NumStreams; s++) begin : gen_stream
    logic in_valid, in_ready, out_valid, out_ready, last;
    beat_t in, out;
    ti_pkg::ray_t taken;

    if (ti_config_pkg::StreamClock == ti_config_pkg::StreamClockOwn) begin : gen_own_clock
      logic stream_rst_n;
      ti_sync u_reset (
        .clk_i (axis_aclk[s]),
        .rst_ni(aresetn),
        .in_i  (1'b1),
        .out_o (stream_rst_n)
      );
      ti_cdc_fifo #(
        .payload_t(beat_t),
        .Depth    (CrossingDepth)
      ) u_in (
        .in_clk_i   (axis_aclk[s]),
        .in_rst_ni  (stream_rst_n),
        .in_valid_i (s_axis_ray_tvalid[s]),
        .in_ready_o (s_axis_ray_tready[s]),
        .in_data_i  ({s_axis_ray_tlast[s], s_axis_ray_tdata[s]}),
        .out_clk_i  (aclk),
        .out_rst_ni (aresetn),
        .out_valid_o(in_valid),
        .out_ready_i(in_ready),
        .out_data_o (in)
      );
      ti_cdc_fifo #(
        .payload_t(beat_t),
        .Depth    (CrossingDepth)
      ) u_out (
        .in_clk_i   (aclk),
        .in_rst_ni  (aresetn),
        .in_valid_i (out_valid),
        .in_ready_o (out_ready),
        .in_data_i  (out),
        .out_clk_i  (axis_aclk[s]),
        .out_rst_ni (stream_rst_n),
        .out_valid_o(m_axis_hit_tvalid[s]),
        .out_ready_i(m_axis_hit_tready[s]),
        .out_data_o ({m_axis_hit_tlast[s], m_axis_hit_tdata[s]})
      );
    end else begin : gen_core_clock
      logic unused_clk;
      assign unused_clk           = axis_aclk[s];
      assign in_valid             = s_axis_ray_tvalid[s];
      assign s_axis_ray_tready[s] = in_ready;
      assign in                   = {s_axis_ray_tlast[s], s_axis_ray_tdata[s]};
      assign m_axis_hit_tvalid[s] = out_valid;
      assign out_ready            = m_axis_hit_tready[s];
      assign m_axis_hit_tlast[s]  = out.last;
      assign m_axis_hit_tdata[s]  = out.data;
    end

    ti_ray_in u_ray_in (
      .clk_i        (aclk),
      .rst_ni       (aresetn),
      .run_i        (run),
      .empty_o      (no_ray[s]),
      .take_o       (take[s]),
      .s_axis_tvalid(in_valid),
      .s_axis_tready(in_ready),
      .s_axis_tdata (in.data),
      .s_axis_tlast (in.last),
      .ray_valid_o  (ray_valid[s]),
      .ray_ready_i  (ray_ready[s]),
      .ray_data_o   (taken),
      .hit_i        (give[s]),
      .last_o       (last)
    );
    always_comb begin
      ray[s]         = taken;
      ray[s].any_hit = any_hit_q;
    end

    assign give[s]   = hit_valid[s] && hit_ready[s];
    assign no_hit[s] = !out_valid;
    ti_hit_out u_hit_out (
      .clk_i        (aclk),
      .rst_ni       (aresetn),
      .hit_valid_i  (hit_valid[s]),
      .hit_ready_o  (hit_ready[s]),
      .hit_data_i   (hit[s]),
      .last_i       (last),
      .m_axis_tvalid(out_valid),
      .m_axis_tready(out_ready),
      .m_axis_tdata (out.data),
      .m_axis_tlast (out.last)
    );
  end

  // Memory ports: the elements of each are those of the engine.
  logic [AxiIdWidth-1:0] arid[NumCores];
  ti_mem_pkg::addr_t araddr[NumCores];
  logic [7:0] arlen[NumCores];
  logic [2:0] arsize[NumCores];
  logic [1:0] arburst[NumCores];
  logic [3:0] arcache[NumCores];
  logic [2:0] arprot[NumCores];
  logic [3:0] arqos[NumCores];
  logic [AxiIdWidth-1:0] rid[NumCores];
  ti_mem_pkg::line_t rdata[NumCores];
  logic [1:0] rresp[NumCores];

  for (genvar c = 0; c < NumCores; c++) begin : gen_core
    assign m_axi_arid[c]    = arid[c];
    assign m_axi_araddr[c]  = araddr[c];
    assign m_axi_arlen[c]   = arlen[c];
    assign m_axi_arsize[c]  = arsize[c];
    assign m_axi_arburst[c] = arburst[c];
    assign m_axi_arcache[c] = arcache[c];
    assign m_axi_arprot[c]  = arprot[c];
    assign m_axi_arqos[c]   = arqos[c];
    assign rid[c]           = m_axi_rid[c];
    assign rdata[c]         = m_axi_rdata[c];
    assign rresp[c]         = m_axi_rresp[c];
  end

  ti_engine u_engine (
    .clk_i        (aclk),
    .rst_ni       (aresetn),
    .flush_i      (flush),
    .idle_o       (idle),
    .scene_i      (scene),
    .ray_valid_i  (ray_valid),
    .ray_ready_o  (ray_ready),
    .ray_data_i   (ray),
    .hit_valid_o  (hit_valid),
    .hit_ready_i  (hit_ready),
    .hit_data_o   (hit),
    .m_axi_arvalid,
    .m_axi_arready,
    .m_axi_arid   (arid),
    .m_axi_araddr (araddr),
    .m_axi_arlen  (arlen),
    .m_axi_arsize (arsize),
    .m_axi_arburst(arburst),
    .m_axi_arlock,
    .m_axi_arcache(arcache),
    .m_axi_arprot (arprot),
    .m_axi_arqos  (arqos),
    .m_axi_rvalid,
    .m_axi_rready,
    .m_axi_rid    (rid),
    .m_axi_rdata  (rdata),
    .m_axi_rresp  (rresp),
    .m_axi_rlast,
    .count_run_i  (count_run),
    .snapshot_i   (snapshot),
    .count_core_i (count_core),
    .count_unit_i (count_unit),
    .count_event_i(count_event),
    .count_o      (count)
  );

endmodule : ti_top
