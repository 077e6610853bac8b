// SPDX-License-Identifier: Apache-2.0

/// Whether a test is kept: the comparisons at the end of passes (a) and (b).  2 CMP; 1 without `IntervalCull`.
/// Latency `CmpStages` cycles, all of them in front of the comparisons; combinational where that is 0.
///
/// (a) keeps a test unless det is 0 or not finite, dett is not finite, dett != 0 has the other sign,
/// |dett| exceeds |limit| by more than `CullUlps`, or |nearest| exceeds |dett| by more than that.
/// The far end counts only where tfar, limit and 1/det are normal numbers: then t = fl(dett * fl(1/det)) > tfar for
/// certain.  The near end counts only where nearest is a normal number: then dett / det < tnear for certain.
///
/// With u = 2^-(FracBits+1), each ulp is at least u of its number and at most 2 u.  limit is less than an ulp away from
/// P = |tfar * det|, so that |dett| > limit + k ulp makes |dett| at least P (1 + u)^k.  With H half ulps the error of
/// the reciprocal, |dett| * fl(1/det) >= tfar (1 + u)^k (1 - H u), and that is not rounded to tfar where it reaches the
/// next number, which is at most tfar (1 + 2 u).  k = H + 3 does it for H^2 <= 2^(FracBits+1), which
/// `scripts/configure.py` holds.  By division H is 1 to nearest and 2 toward zero.  |nearest| is at most |tnear * det|
/// (1 + u).  Toward zero this holds only where 1/det and t do not end at the largest number: not for a subnormal det,
/// nor for a tfar in the topmost binade.  Where subnormals are flushed det is normal or 0, and t > tfar is normal.
/// (b) keeps a test when detu and detv are 0 or have det's sign and |detu + detv| <= |det|.
module ti_ist1_verdict #(
  parameter bit IntervalCull = 1'b1,
  /// Register stages in front of the comparisons.
  parameter int unsigned CmpStages = ti_fp_pkg::CmpLatency
) (
  input logic clk_i,
  input logic rst_ni,

  input  logic        pass_b_i,
  input  ti_pkg::fp_t x1_i,       // (a) det; (b) detu
  input  ti_pkg::fp_t x2_i,       // (b) detv
  input  ti_pkg::fp_t x3_i,       // (a) dett; (b) detu + detv
  input  ti_pkg::fp_t given_i,    // (a) tfar; (b) det
  input  ti_pkg::fp_t limit_i,    // (a) tfar * det
  input  ti_pkg::fp_t nearest_i,  // (a) tnear * det
  output logic        keep_o
);

  typedef ti_pkg::fp_t fp_t;
  localparam int unsigned W = ti_num_pkg::FpWidth;
  localparam int unsigned E = ti_num_pkg::ExpBits;
  localparam int unsigned M = ti_num_pkg::FracBits;
  // Units in the last place by which the range test of (a) errs on the side of keeping.
  localparam int unsigned CullUlps = ti_fp_pkg::rcp_half_ulps(M) + 3;

  // Moved outward by the guard, up to infinity at most.
  fp_t x3_size, limit_size, limit_up, x3_up;
  assign x3_size = {1'b0, x3_i[W-2:0]};
  assign limit_size = {1'b0, limit_i[W-2:0]};
  assign limit_up   = (limit_size >= ti_num_pkg::Inf - fp_t'(CullUlps)) ? ti_num_pkg::Inf :
      limit_size + fp_t'(CullUlps);
  assign x3_up      = (x3_size >= ti_num_pkg::Inf - fp_t'(CullUlps)) ? ti_num_pkg::Inf :
      x3_size + fp_t'(CullUlps);

  typedef struct packed {
    logic pass_b;
    fp_t  x1;
    fp_t  x2;
    fp_t  x3;
    fp_t  given;
    fp_t  limit;
    fp_t  nearest;
    fp_t  limit_up;
    fp_t  x3_up;
  } at_t;
  at_t now, at;
  always_comb begin
    now = '{
        pass_b: pass_b_i,
        x1: x1_i,
        x2: x2_i,
        x3: x3_i,
        given: given_i,
        limit: limit_i,
        nearest: nearest_i,
        limit_up: limit_up,
        x3_up: x3_up
    };
  end
  ti_delay #(
    .payload_t(at_t),
    .Cycles   (CmpStages)
  ) u_at (
    .clk_i,
    .rst_ni,
    .data_i(now),
    .data_o(at)
  );

  // What kinds of numbers these are.
  logic zero_x1, finite_x1, nan_x1, zero_x2, nan_x2, zero_x3, finite_x3, nan_x3;
  logic normal_tfar, normal_limit;
  ti_fp_class #(
    .ExpBits (E),
    .FracBits(M)
  ) u_x1_class (
    .x_i     (at.x1),
    .zero_o  (zero_x1),
    .finite_o(finite_x1),
    .normal_o(),
    .nan_o   (nan_x1)
  );
  ti_fp_class #(
    .ExpBits (E),
    .FracBits(M)
  ) u_x2_class (
    .x_i     (at.x2),
    .zero_o  (zero_x2),
    .finite_o(),
    .normal_o(),
    .nan_o   (nan_x2)
  );
  ti_fp_class #(
    .ExpBits (E),
    .FracBits(M)
  ) u_x3_class (
    .x_i     (at.x3),
    .zero_o  (zero_x3),
    .finite_o(finite_x3),
    .normal_o(),
    .nan_o   (nan_x3)
  );
  ti_fp_class #(
    .ExpBits (E),
    .FracBits(M)
  ) u_tfar_class (
    .x_i     (at.given),
    .zero_o  (),
    .finite_o(),
    .normal_o(normal_tfar),
    .nan_o   ()
  );
  ti_fp_class #(
    .ExpBits (E),
    .FracBits(M)
  ) u_limit_class (
    .x_i     (at.limit),
    .zero_o  (),
    .finite_o(),
    .normal_o(normal_limit),
    .nan_o   ()
  );

  // (a) |limit| and CullUlps < |dett|; (b) |detu + detv| <= |det|.
  fp_t dett_size;
  logic lt, le, inverse_is_normal, saturates, beyond;
  assign dett_size = {1'b0, at.x3[W-2:0]};
  ti_fp_cmp #(
    .ExpBits (E),
    .FracBits(M)
  ) u_cmp (
    .a_i(at.pass_b ? dett_size : at.limit_up),
    .b_i(at.pass_b ? {1'b0, at.given[W-2:0]} : dett_size),
    .lt_o(lt),
    .eq_o(),
    .le_o(le),
    .unordered_o()
  );
  assign inverse_is_normal = at.x1[M+:E] <= E'(2 * ti_num_pkg::Bias - 2);
  assign saturates = ti_fp_pkg::TowardZero &&
      (at.x1[M+:E] == '0 || at.given[M+:E] >= E'(2 * ti_num_pkg::Bias));
  assign beyond = lt && inverse_is_normal && normal_tfar && normal_limit && !saturates;

  // (a) |dett| and CullUlps < |nearest|.
  logic lies_before;
  if (IntervalCull) begin : gen_near
    logic less, normal_nearest;
    ti_fp_class #(
      .ExpBits (E),
      .FracBits(M)
    ) u_nearest_class (
      .x_i     (at.nearest),
      .zero_o  (),
      .finite_o(),
      .normal_o(normal_nearest),
      .nan_o   ()
    );
    ti_fp_cmp #(
      .ExpBits (E),
      .FracBits(M)
    ) u_near (
      .a_i(at.x3_up),
      .b_i({1'b0, at.nearest[W-2:0]}),
      .lt_o(less),
      .eq_o(),
      .le_o(),
      .unordered_o()
    );
    assign lies_before = less && normal_nearest;
  end else begin : gen_no_near
    logic unused_nearest;
    assign unused_nearest = ^{at.nearest, at.x3_up};
    assign lies_before = 1'b0;
  end

  // Zero, or a number of the same sign.
  logic dett_agrees, detu_agrees, detv_agrees, keep_a, keep_b;
  assign dett_agrees = zero_x3 || (at.x3[W-1] == at.x1[W-1] && !nan_x3);
  assign detu_agrees = zero_x1 || (at.x1[W-1] == at.given[W-1] && !nan_x1);
  assign detv_agrees = zero_x2 || (at.x2[W-1] == at.given[W-1] && !nan_x2);

  assign keep_a = !zero_x1 && finite_x1 && finite_x3 && dett_agrees && !beyond && !lies_before;
  assign keep_b = detu_agrees && detv_agrees && le;
  assign keep_o = at.pass_b ? keep_b : keep_a;

endmodule : ti_ist1_verdict
