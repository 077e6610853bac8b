// SPDX-License-Identifier: Apache-2.0

`include "ti_assert.svh"
`include "ti_reset.svh"

/// Makes a ray thick: the two origins from which every t of a plane is the least, or the greatest, that rounding may
/// come to, here and in the triangle test.
///
/// A is the largest |plane - o| of the scene box; the thickness has the fraction of A and an exponent lower by
/// `Places`, at least 1: 2^k u A with u = 2^-(FracBits+1), 32 u A by division to nearest.  On each axis the origins
/// are o + thickness and o - thickness, each moved outward by one more ulp; `least` is the one farther along the
/// direction.  What the thickness covers is added up in `sw/model/rd.hpp`.
/// A ray in `RayCycles` steps, as `ti_rd_clip` takes it: lane 0 has the axis of the step, each further axis a lane of
/// its own in the last step.  `Latency` cycles, no stall.  A lane has 4 ADD.
module ti_rd_thick #(
  /// Cycles a ray, 1 to 3.
  parameter int unsigned RayCycles = ti_config_pkg::RdCycles,
  localparam int unsigned Lanes = 4 - RayCycles,
  localparam int unsigned FarthestLatency = 1,
  localparam int unsigned OutwardLatency = 1,
  // The second sum of the first step waits for the first sum of the last.
  localparam int unsigned WidenTime = ti_fp_pkg::AddLatency + RayCycles - 1 + FarthestLatency,
  localparam int unsigned Latency = WidenTime + ti_fp_pkg::AddLatency + OutwardLatency
) (
  input logic clk_i,
  input logic rst_ni,
  input ti_pkg::vec3_t box_lo_i,  // constant while rays are inside
  input ti_pkg::vec3_t box_hi_i,

  input logic               valid_i,
  input logic         [1:0] step_i,   // 0 to RayCycles - 1 in consecutive valid cycles
  input ti_pkg::ray_t       ray_i,    // the same for all steps

  output logic                            valid_o,
  output logic                      [1:0] step_o,
  output ti_pkg::ray_t                    ray_o,
  output ti_traverse_pkg::origins_t       origins_o  // of the axes so far; all in the last step
);

  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;
  localparam int unsigned W = ti_num_pkg::FpWidth;
  // What the thickness covers, in units of u A, and the exponent of the next power of two.
  localparam int unsigned Operations = ti_fp_pkg::TowardZero ? 34 : 17;
  localparam int unsigned Covered = Operations + 4 * ti_fp_pkg::rcp_half_ulps(M);
  localparam int unsigned Thicker = $clog2(Covered);
  localparam int unsigned Places = (M + 1 > Thicker) ? M + 1 - Thicker : 0;
  localparam logic [1:0] LastStep = 2'(RayCycles - 1);
  typedef ti_pkg::fp_t fp_t;
  typedef logic [W-2:0] size_t;

  if (RayCycles < 1 || RayCycles > 3) begin : gen_check_ray_cycles
    $error("ti_rd_thick: RayCycles must be 1 to 3");
  end

  // What travels along, and where it is needed on the way.
  typedef struct packed {
    logic [1:0]   step;
    ti_pkg::ray_t ray;
  } along_t;
  along_t along_widen, along_out;
  logic [Latency-1:0] valid_q;
  logic [1:0] sized_step;

  always_ff @(`TI_CLK_RST) begin
    if (!rst_ni) valid_q <= '0;
    else valid_q <= {valid_q[Latency-2:0], valid_i};
  end
  ti_delay #(
    .payload_t(logic [1:0]),
    .Cycles   (ti_fp_pkg::AddLatency)
  ) u_sized_step (
    .clk_i,
    .rst_ni,
    .data_i(step_i),
    .data_o(sized_step)
  );
  ti_delay #(
    .payload_t(along_t),
    .Cycles   (WidenTime)
  ) u_to_widen (
    .clk_i,
    .rst_ni,
    .data_i('{step: step_i, ray: ray_i}),
    .data_o(along_widen)
  );
  ti_delay #(
    .payload_t(along_t),
    .Cycles   (Latency - WidenTime)
  ) u_to_out (
    .clk_i,
    .rst_ni,
    .data_i(along_widen),
    .data_o(along_out)
  );

  // The farthest plane of the box: of the axes before, and of those of this step.
  size_t size[2*Lanes];
  size_t farthest, farthest_q, gathered_q;
  logic sized, sized_last;
  assign sized = valid_q[ti_fp_pkg::AddLatency-1];
  assign sized_last = sized && sized_step == LastStep;
  always_comb begin
    farthest = (sized_step == 2'd0) ? '0 : gathered_q;
    for (int unsigned i = 0; i < 2 * Lanes; i++) begin
      if ((i < 2 || sized_step == LastStep) && size[i] > farthest) farthest = size[i];
    end
  end
  always_ff @(posedge clk_i) begin
    if (sized) gathered_q <= farthest;
    if (sized_last) farthest_q <= farthest;
  end

  fp_t thickness;
  logic [E-1:0] exponent;
  assign exponent = farthest_q[M+:E];
  assign thickness = {
    1'b0, (32'(exponent) > Places) ? exponent - E'(Places) : E'(1), farthest_q[M-1:0]
  };

  logic widen_valid, widened_valid;
  logic [1:0] widened_step;
  assign widen_valid   = valid_q[WidenTime-1];
  assign widened_valid = valid_q[Latency-2];
  ti_delay #(
    .payload_t(logic [1:0]),
    .Cycles   (ti_fp_pkg::AddLatency)
  ) u_widened_step (
    .clk_i,
    .rst_ni,
    .data_i(along_widen.step),
    .data_o(widened_step)
  );

  for (genvar k = 0; k < Lanes; k++) begin : gen_lane
    logic [1:0] axis, widen_axis, widened_axis;
    logic to_lo_valid, mine, widen_mine;
    fp_t to_lo, to_hi, above, below, above_out, below_out;
    assign axis = (k == 0) ? step_i : 2'(RayCycles - 1 + k);
    assign widen_axis = (k == 0) ? along_widen.step : 2'(RayCycles - 1 + k);
    assign widened_axis = (k == 0) ? widened_step : 2'(RayCycles - 1 + k);
    assign mine = valid_i && (k == 0 || step_i == LastStep);
    assign widen_mine = widen_valid && (k == 0 || along_widen.step == LastStep);

    ti_fp_add #(
      .ExpBits (E),
      .FracBits(M)
    ) u_to_lo (
      .clk_i,
      .rst_ni,
      .valid_i(mine),
      .a_i(box_lo_i[axis]),
      .b_i(ray_i.o[axis]),
      .negate_b_i(1'b1),
      .valid_o(to_lo_valid),
      .result_o(to_lo)
    );
    ti_fp_add #(
      .ExpBits (E),
      .FracBits(M)
    ) u_to_hi (
      .clk_i,
      .rst_ni,
      .valid_i(mine),
      .a_i(box_hi_i[axis]),
      .b_i(ray_i.o[axis]),
      .negate_b_i(1'b1),
      .valid_o(),
      .result_o(to_hi)
    );
    assign size[2*k]   = to_lo[W-2:0];
    assign size[2*k+1] = to_hi[W-2:0];

    ti_fp_add #(
      .ExpBits (E),
      .FracBits(M)
    ) u_above (
      .clk_i,
      .rst_ni,
      .valid_i(widen_mine),
      .a_i(along_widen.ray.o[widen_axis]),
      .b_i(thickness),
      .negate_b_i(1'b0),
      .valid_o(),
      .result_o(above)
    );
    ti_fp_add #(
      .ExpBits (E),
      .FracBits(M)
    ) u_below (
      .clk_i,
      .rst_ni,
      .valid_i(widen_mine),
      .a_i(along_widen.ray.o[widen_axis]),
      .b_i(thickness),
      .negate_b_i(1'b1),
      .valid_o(),
      .result_o(below)
    );

    // The next number above, and below; from a zero the least one of that sign.
    localparam fp_t Least = ti_fp_pkg::Flush ? fp_t'(1) << M : fp_t'(1);
    logic above_zero, below_zero;
    assign above_zero = above[M+:E] == '0 && (ti_fp_pkg::Flush || above[M-1:0] == '0);
    assign below_zero = below[M+:E] == '0 && (ti_fp_pkg::Flush || below[M-1:0] == '0);
    always_comb begin
      above_out = above[W-1] ? above - 1'b1 : above + 1'b1;
      below_out = below[W-1] ? below + 1'b1 : below - 1'b1;
      if (above_zero) above_out = Least;
      if (below_zero) below_out = {1'b1, Least[W-2:0]};
      if (above[M+:E] == '1) above_out = above;
      if (below[M+:E] == '1) below_out = below;
    end

    logic negative, written;
    ti_delay #(
      .payload_t(logic),
      .Cycles   (ti_fp_pkg::AddLatency)
    ) u_negative (
      .clk_i,
      .rst_ni,
      .data_i(along_widen.ray.d[widen_axis][W-1]),
      .data_o(negative)
    );
    assign written = widened_valid && (k == 0 || widened_step == LastStep);
    always_ff @(posedge clk_i) begin
      if (written) begin
        origins_o.least[widened_axis] <= negative ? below_out : above_out;
        origins_o.most[widened_axis]  <= negative ? above_out : below_out;
      end
    end

    logic unused;
    assign unused = ^{to_lo_valid, to_lo[W-1], to_hi[W-1]};
  end

  assign valid_o = valid_q[Latency-1];
  assign step_o  = along_out.step;
  assign ray_o   = along_out.ray;

  `TI_ASSERT(StepsOfARayInOrder, valid_i -> step_i <= LastStep)
  `TI_ASSERT_KNOWN(ValidKnown, valid_o)

endmodule : ti_rd_thick
