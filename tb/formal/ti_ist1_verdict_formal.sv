// SPDX-License-Identifier: Apache-2.0

`include "formal.svh"

/// `ti_ist1_verdict` drops in pass (a), of tests whose det and dett may be those of a hit, only such whose
/// t = fl(dett * fl(1 / det)) is above tfar or whose dett / det, exactly, is below tnear; it drops all that are
/// further outside than its guard.  In pass (b) it drops exactly what the rule says is outside of the triangle, and
/// nothing that is inside by the exact detu + detv.
module ti_ist1_verdict_formal #(
  parameter int unsigned CmpStages = 0
) (
  input logic        clk_i,
  input logic        rst_ni,
  input logic        pass_b_i,
  input ti_pkg::fp_t x1_i,
  input ti_pkg::fp_t x2_i,
  input ti_pkg::fp_t x3_i,
  input ti_pkg::fp_t given_i,
  input ti_pkg::fp_t limit_i,
  input ti_pkg::fp_t nearest_i,
  input logic        keep_o
);
  `TI_STARTS_IN_RESET

  localparam int unsigned ExpBits = ti_num_pkg::ExpBits;
  localparam int unsigned FracBits = ti_num_pkg::FracBits;
  localparam int unsigned Width = ti_num_pkg::FpWidth;
  localparam bit TowardZero = ti_fp_pkg::TowardZero;
  localparam bit Flush = ti_fp_pkg::Flush;
  `include "rounding.svh"
  typedef logic [Width-1:0] fp_t;

  function automatic logic sign_of(fp_t x);
    return x[Width-1];
  endfunction
  // What an operator takes x for.
  function automatic mag_t size_of(fp_t x);
    return (Flush && x[MagBits-1:0] < LeastNormal) ? '0 : x[MagBits-1:0];
  endfunction
  function automatic logic is_nan(fp_t x);
    return size_of(x) > Infinity;
  endfunction
  function automatic logic is_finite(fp_t x);
    return size_of(x) < Infinity;
  endfunction
  function automatic logic is_normal(fp_t x);
    return is_finite(x) && size_of(x) >= LeastNormal;
  endfunction

  // p is the product of a and b as `ti_fp_mul` gives it (proven there), r the inverse of a by `ti_fp_rcp` (there).
  function automatic logic is_product(fp_t a, fp_t b, fp_t p);
    logic sign;
    sign = sign_of(a) ^ sign_of(b);
    if (is_nan(a) || is_nan(b)) return p == QuietNaN;
    if (size_of(a) == Infinity || size_of(b) == Infinity)
      return p == (size_of(a) == '0 || size_of(b) == '0 ? QuietNaN : {sign, Infinity});
    return sign_of(
        p
    ) == sign && rounds_to(
        (value(size_of(a)) * value(size_of(b))) << FineBits, OneBits, p[MagBits-1:0]
    );
  endfunction
  function automatic logic is_inverse(fp_t a, fp_t r);
    if (is_nan(a)) return r == QuietNaN;
    if (size_of(a) == '0) return r == {sign_of(a), Infinity};
    if (size_of(a) == Infinity) return r == {sign_of(a), mag_t'(0)};
    return sign_of(r) == sign_of(a) && inverse_rounds_to(size_of(a), r[MagBits-1:0]);
  endfunction

  // What the verdict is about: the inputs `CmpStages` cycles before.
  typedef struct packed {
    logic known;    // out of reset ever since
    logic pass_b;
    fp_t  x1;
    fp_t  x2;
    fp_t  x3;
    fp_t  given;
    fp_t  limit;
    fp_t  nearest;
  } at_t;
  at_t [CmpStages:0] at_q;
  at_t at;
  assign at_q[0] = '{
          known: rst_ni,
          pass_b: pass_b_i,
          x1: x1_i,
          x2: x2_i,
          x3: x3_i,
          given: given_i,
          limit: limit_i,
          nearest: nearest_i
      };
  for (genvar i = 1; i <= CmpStages; i++) begin : gen_later
    always_ff @(posedge clk_i) begin
      at_q[i]       <= at_q[i-1];
      at_q[i].known <= rst_ni && at_q[i-1].known;
    end
  end
  assign at = at_q[CmpStages];

  // ---- Pass (a).
  fp_t det, dett, tfar, tnear, inverse, t;
  logic pass_a;
  assign pass_a = at.known && !at.pass_b;
  assign det    = at.x1;
  assign dett   = at.x3;
  assign tfar   = at.given;

  // `tnear`, `inverse` and `t` are free, and then what the operators of `ti_ist1_pipe` and `ti_ist2` make them.
  `TI_ASSUME(LimitOfTfar, pass_a -> is_product(tfar, det, at.limit))
  `TI_ASSUME(NearestOfTnear, pass_a -> is_product(tnear, det, at.nearest))
  `TI_ASSUME(InverseOfDet, pass_a -> is_inverse(det, inverse))
  `TI_ASSUME(TimeOfTheTest, pass_a -> is_product(dett, inverse, t))
  // A leaf begins at +0 or later: `ti_kd_decide` moves it outward no further.
  `TI_ASSUME(LeafBeginsAtZeroOrLater, pass_a -> !sign_of(tnear))

  // A test that may be a hit: its t is a number, 0 or more.
  logic may_hit;
  assign may_hit = is_finite(
      det
  ) && size_of(
      det
  ) != '0 && is_finite(
      dett
  ) && (size_of(
      dett
  ) == '0 || sign_of(
      dett
  ) == sign_of(
      det
  ));

  // t > tfar, as rounded; dett / det < tnear, exactly.
  logic comes_after, lies_before;
  assign comes_after = !is_nan(
      t
  ) && !is_nan(
      tfar
  ) && (sign_of(
      tfar
  ) ? size_of(
      t
  ) != '0 || size_of(
      tfar
  ) != '0 : !sign_of(
      t
  ) && size_of(
      t
  ) > size_of(
      tfar
  ));
  assign lies_before = !is_nan(
      tnear
  ) && value(
      size_of(dett)
  ) << OneBits < value(
      size_of(tnear)
  ) * value(
      size_of(det)
  );

  // Where the ends count: the far one where tfar, its product and 1 / det are normal, toward zero none of them at the
  // largest number; the near one where its product is normal.
  localparam int unsigned Guard = TowardZero ? 5 : 4;
  localparam mag_t TopBinade = Infinity - LeastNormal;
  logic small_inverse, may_saturate, far_counts, near_counts;
  logic [31:0] dett_place, limit_place, nearest_place;
  assign small_inverse = value(size_of(det)) * value(LeastNormal) >= One >> FineBits;
  assign may_saturate  = TowardZero && (size_of(det) < LeastNormal || size_of(tfar) >= TopBinade);
  assign far_counts    = is_normal(tfar) && is_normal(at.limit) && !small_inverse && !may_saturate;
  assign near_counts   = is_normal(at.nearest);
  assign dett_place    = 32'(dett[MagBits-1:0]);
  assign limit_place   = 32'(at.limit[MagBits-1:0]);
  assign nearest_place = 32'(at.nearest[MagBits-1:0]);

  logic dropped;
  assign dropped = pass_a && may_hit && !keep_o;
  `TI_ASSERT(DropsWhatIsNoNumber, pass_a && !may_hit -> !keep_o)
  `TI_ASSERT(DropsNoneInRange, dropped -> comes_after || lies_before)
  `TI_ASSERT(DropsFarBehind, pass_a && far_counts && dett_place > limit_place + Guard -> !keep_o)
  `TI_ASSERT(DropsFarInFront,
             pass_a && near_counts && nearest_place > dett_place + Guard -> !keep_o)
  `TI_COVER(DropsBehind, dropped && !lies_before)
  `TI_COVER(DropsInFront, dropped && !comes_after)
  `TI_COVER(KeepsAtTheEnd, pass_a && may_hit && keep_o && t == tfar && dett_place > limit_place)
  `TI_COVER(KeepsBehind, pass_a && may_hit && keep_o && comes_after && far_counts)

  // ---- Pass (b).
  fp_t detu, detv;
  logic pass_b, agree_u, agree_v, are_numbers, sum_fits;
  exact_t sum;
  assign pass_b = at.known && at.pass_b;
  assign detu = at.x1;
  assign detv = at.x2;
  assign agree_u = !is_nan(detu) && (size_of(detu) == '0 || sign_of(detu) == sign_of(at.given));
  assign agree_v = !is_nan(detv) && (size_of(detv) == '0 || sign_of(detv) == sign_of(at.given));
  assign are_numbers = is_finite(detu) && is_finite(detv) && sign_of(detu) == sign_of(detv);
  assign sum = value(size_of(detu)) + value(size_of(detv));
  assign sum_fits = !is_nan(at.x3) && !is_nan(at.given) && size_of(at.x3) <= size_of(at.given);

  // The sum of numbers of one sign is as `ti_fp_add` gives it (proven there).
  `TI_ASSUME(SumOfBoth, pass_b && are_numbers -> rounds_to(sum << FineBits, 0, at.x3[MagBits-1:0]))
  `TI_ASSERT(InsideByTheRule, pass_b -> keep_o == (agree_u && agree_v && sum_fits))
  `TI_ASSERT(DropsNoneInside, pass_b && are_numbers && agree_u && agree_v && !is_nan(at.given
             ) && sum <= value(size_of(at.given)) -> keep_o)
  `TI_COVER(KeepsAtTheEdge, pass_b && keep_o && sum == value(size_of(at.given)) && detu != '0)
  `TI_COVER(DropsOutside, pass_b && !keep_o && agree_u && agree_v)
endmodule : ti_ist1_verdict_formal

bind ti_ist1_verdict ti_ist1_verdict_formal #(.CmpStages(CmpStages)) u_formal (.*);
