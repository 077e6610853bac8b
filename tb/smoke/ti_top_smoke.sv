// SPDX-License-Identifier: Apache-2.0

`timescale 1ns / 1ps

/// A block in any simulator: registers answer, rays that miss the scene come back as misses, packet by packet.
///
/// For the configuration of `ti.core`: one core, one stream with a clock of its own.  No memory is behind the block: rays
/// that miss the scene box ask for none.  Ends with one line, passed or by $fatal.
module ti_top_smoke;

  localparam int unsigned Packets = 4;
  localparam int unsigned Rays = 16;  // of a packet
  localparam int unsigned Timeout = 100_000;  // cycles

  // Bytes of registers, and values of float (docs/registers.md).
  localparam logic [7:0] Id = 8'h00, Control = 8'h20, HitsLo = 8'h38;
  localparam logic [7:0] Root = 8'h80, BoxLo = 8'hb0, BoxHi = 8'hc0;
  localparam logic [31:0] One = 32'h3f80_0000, Two = 32'h4000_0000, Far = 32'h4480_0000;
  localparam logic [95:0] Direction = {32'h0, 32'h0, One | 32'h8000_0000};  // -x
  localparam logic [1:0] Okay = 2'b00, SlvErr = 2'b10;

  logic aclk = 1'b0, axis00_aclk = 1'b0, aresetn = 1'b0;
  always #5 aclk = ~aclk;
  always #3.7 axis00_aclk = ~axis00_aclk;

  logic irq;
  logic s_axil_awvalid = 1'b0, s_axil_awready, s_axil_wvalid = 1'b0, s_axil_wready;
  logic s_axil_bvalid, s_axil_bready = 1'b0, s_axil_arvalid = 1'b0, s_axil_arready;
  logic s_axil_rvalid, s_axil_rready = 1'b0;
  logic [7:0] s_axil_awaddr, s_axil_araddr;
  logic [31:0] s_axil_wdata, s_axil_rdata;
  logic [1:0] s_axil_bresp, s_axil_rresp;
  logic s00_axis_ray_tvalid = 1'b0, s00_axis_ray_tready, s00_axis_ray_tlast;
  logic m00_axis_hit_tvalid, m00_axis_hit_tready = 1'b0, m00_axis_hit_tlast;
  logic [255:0] s00_axis_ray_tdata, m00_axis_hit_tdata;
  logic m00_axi_arvalid;

  ti_top_wrapper u_dut (
    .aclk,
    .axis00_aclk,
    .aresetn,
    .irq,
    .s_axil_awvalid,
    .s_axil_awready,
    .s_axil_awaddr,
    .s_axil_awprot  (3'b000),
    .s_axil_wvalid,
    .s_axil_wready,
    .s_axil_wdata,
    .s_axil_wstrb   (4'hf),
    .s_axil_bvalid,
    .s_axil_bready,
    .s_axil_bresp,
    .s_axil_arvalid,
    .s_axil_arready,
    .s_axil_araddr,
    .s_axil_arprot  (3'b000),
    .s_axil_rvalid,
    .s_axil_rready,
    .s_axil_rdata,
    .s_axil_rresp,
    .s00_axis_ray_tvalid,
    .s00_axis_ray_tready,
    .s00_axis_ray_tdata,
    .s00_axis_ray_tlast,
    .m00_axis_hit_tvalid,
    .m00_axis_hit_tready,
    .m00_axis_hit_tdata,
    .m00_axis_hit_tlast,
    .m00_axi_arvalid,
    .m00_axi_arready(1'b0),
    .m00_axi_arid   (),
    .m00_axi_araddr (),
    .m00_axi_arlen  (),
    .m00_axi_arsize (),
    .m00_axi_arburst(),
    .m00_axi_arlock (),
    .m00_axi_arcache(),
    .m00_axi_arprot (),
    .m00_axi_arqos  (),
    .m00_axi_rvalid (1'b0),
    .m00_axi_rready (),
    .m00_axi_rid    ('0),
    .m00_axi_rdata  ('0),
    .m00_axi_rresp  ('0),
    .m00_axi_rlast  (1'b0)
  );

  int unsigned sent = 0, received = 0;  // beats

  // Signals are looked at when a clock rises and driven when it falls, so that no simulator has a race.
  task automatic write(input logic [7:0] addr, input logic [31:0] data,
                       input logic [1:0] expected = Okay);
    automatic logic aw_taken, w_taken, done;
    automatic logic [1:0] resp;
    s_axil_awaddr  = addr;
    s_axil_wdata   = data;
    s_axil_awvalid = 1'b1;
    s_axil_wvalid  = 1'b1;
    s_axil_bready  = 1'b1;
    do begin
      @(posedge aclk);
      aw_taken = s_axil_awready;
      w_taken  = s_axil_wready;
      done     = s_axil_bvalid;
      resp     = s_axil_bresp;
      @(negedge aclk);
      if (aw_taken) s_axil_awvalid = 1'b0;
      if (w_taken) s_axil_wvalid = 1'b0;
    end while (!done);
    s_axil_bready = 1'b0;
    if (resp != expected) $fatal(1, "write of %h: BRESP is %b", addr, resp);
  endtask

  task automatic read(input logic [7:0] addr, output logic [31:0] data,
                      input logic [1:0] expected = Okay);
    automatic logic taken, done;
    automatic logic [1:0] resp;
    s_axil_araddr  = addr;
    s_axil_arvalid = 1'b1;
    s_axil_rready  = 1'b1;
    do begin
      @(posedge aclk);
      taken = s_axil_arready;
      done  = s_axil_rvalid;
      resp  = s_axil_rresp;
      data  = s_axil_rdata;
      @(negedge aclk);
      if (taken) s_axil_arvalid = 1'b0;
    end while (!done);
    s_axil_rready = 1'b0;
    if (resp != expected) $fatal(1, "read of %h: RRESP is %b", addr, resp);
  endtask

  // From the origin, away from the box.
  task automatic send();
    automatic logic taken;
    for (int unsigned i = 0; i < Packets * Rays; i++) begin
      repeat ($urandom_range(2)) @(negedge axis00_aclk);
      s00_axis_ray_tdata  = {Far, Direction, 32'h0, 96'h0};
      s00_axis_ray_tlast  = i % Rays == Rays - 1;
      s00_axis_ray_tvalid = 1'b1;
      do begin
        @(posedge axis00_aclk);
        taken = s00_axis_ray_tready;
        @(negedge axis00_aclk);
      end while (!taken);
      s00_axis_ray_tvalid = 1'b0;
      sent++;
    end
  endtask

  task automatic receive();
    automatic logic [Rays-1:0] seen;
    automatic logic given, last;
    automatic logic [255:0] hit;
    for (int unsigned i = 0; i < Packets * Rays; i++) begin
      repeat ($urandom_range(2)) @(negedge axis00_aclk);
      if (i % Rays == 0) seen = '0;
      m00_axis_hit_tready = 1'b1;
      do begin
        @(posedge axis00_aclk);
        given = m00_axis_hit_tvalid;
        hit   = m00_axis_hit_tdata;
        last  = m00_axis_hit_tlast;
        @(negedge axis00_aclk);
      end while (!given);
      m00_axis_hit_tready = 1'b0;
      received++;
      if (hit[31:0] >= Rays || seen[hit[3:0]])
        $fatal(1, "hit of ray %0d, which has none to come", hit[31:0]);
      seen[hit[3:0]] = 1'b1;
      if (hit[63:32] != '1 || hit[191:160] != '0)
        $fatal(1, "ray %0d: no miss with status 0", hit[31:0]);
      if (last != (i % Rays == Rays - 1)) $fatal(1, "TLAST at hit %0d of %0d", i % Rays, Rays);
    end
  endtask

  logic [31:0] data;

  initial begin
    repeat (8) @(negedge aclk);
    aresetn = 1'b1;
    repeat (8) @(negedge aclk);

    read(Id, data);
    if (data != "1I&T") $fatal(1, "ID is %h", data);
    write(Root, 32'h0123_4560);
    read(Root, data);
    if (data != 32'h0123_4560) $fatal(1, "ROOT is %h behind a write", data);
    write(8'hfc, 32'h0, SlvErr);
    read(8'hfc, data, SlvErr);

    for (int unsigned axis = 0; axis < 3; axis++) begin
      write(BoxLo + 8'(4 * axis), One);
      write(BoxHi + 8'(4 * axis), Two);
    end
    write(Control, 32'h1);
    @(negedge axis00_aclk);
    fork
      send();
      receive();
    join
    @(negedge aclk);
    read(HitsLo, data);
    if (data != Packets * Rays) $fatal(1, "HITS is %0d, not %0d", data, Packets * Rays);
    $display("ti_top_smoke: passed, %0d rays in %0d packets", Packets * Rays, Packets);
    $finish;
  end

  always @(posedge aclk) if (m00_axi_arvalid && aresetn) $fatal(1, "a ray that misses read memory");

  initial begin
    repeat (Timeout) @(posedge aclk);
    $fatal(1, "not done in %0d cycles: %0d rays sent, %0d hits received", Timeout, sent, received);
  end

endmodule : ti_top_smoke
