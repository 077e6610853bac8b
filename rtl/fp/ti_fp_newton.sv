// SPDX-License-Identifier: Apache-2.0

/// 1 / x for x in [1, 2) by Newton steps from a table of seeds: the middle of `ti_fp_rcp`.
///
/// Latency 1 for the seed and `ProductStages` for each of two products a step, one x a cycle, never
/// stalls; stage k works where `valid_i[k]` is 1.
///
/// x = X 2^-M, and y = Y 2^-(M+3) is an estimate of 1/x in [1/2, 1), M = `FracBits`.  The seed of the
/// interval of x with an index of `TableBits` is the inverse of its middle, to nearest in
/// `TableBits` + 1 bits.  A step is y (2 - x y): X Y is cut off to M + 3 bits below the point and
/// inverted bit by bit, which is 2 - x y less one unit; its product with Y is cut off to a new Y.
/// To nearest 1 is added, which halves the error.  `ti_fp_pkg::rcp_half_ulps` bounds it.  No estimate
/// leaves [1/2, 1): `sw/test/test_modes.cpp` tries every x of every format with every table.
module ti_fp_newton #(
  /// Stored fraction bits, 2 to 23.
  parameter int unsigned FracBits = 23,
  /// Bits of the index into the seeds, at most `FracBits`.
  parameter int unsigned TableBits = 7,
  /// Newton steps, 0 to 2.
  parameter int unsigned Steps = 2,
  /// Stages of a product, 1 or 2; 2 make it in halves.
  parameter int unsigned ProductStages = 1,
  /// Whether estimates stay below 1/x.
  parameter bit TowardZero = 1'b0,
  localparam int unsigned Products = 2 * Steps,
  localparam int unsigned SeedLatency = 1,
  localparam int unsigned Latency = SeedLatency + Products * ProductStages
) (
  input logic clk_i,

  input logic [Latency-1:0] valid_i,
  input logic [FracBits:0] sig_i,  // X
  input logic exact_i,  // x is 1

  output logic [FracBits+3:0] inverse_o  // an integer bit, then Y
);

  localparam int unsigned YBits = FracBits + 3;
  localparam int unsigned FactorBits = YBits + 1;  // of 2 - x y; X is shorter
  localparam int unsigned ProdBits = YBits + FactorBits;
  localparam int unsigned LowBits = FactorBits / 2;
  localparam int unsigned HighBits = FactorBits - LowBits;

  typedef logic [(1<<TableBits)-1:0][TableBits:0] seeds_t;

  // The inverse of the middle of interval i, 2^(k+1) / (2^(k+1) + 2i + 1), in units of 2^-(k+1).
  function automatic seeds_t make_seeds();
    seeds_t seeds;
    for (int unsigned i = 0; i < (1 << TableBits); i++) begin
      automatic int unsigned middle = (1 << (TableBits + 1)) + 2 * i + 1;
      seeds[i] = (TableBits + 1)'(((1 << (2 * TableBits + 3)) + middle) / (2 * middle));
    end
    return seeds;
  endfunction

  localparam seeds_t Seeds = make_seeds();

  if (TableBits < 1 || TableBits > 12 || TableBits > FracBits) begin : gen_check_table_bits
    $error("ti_fp_newton: TableBits must be 1 to 12 and at most FracBits.");
  end
  if (Steps > 2) begin : gen_check_steps
    $error("ti_fp_newton: Steps must be 0 to 2.");
  end
  if (ProductStages < 1 || ProductStages > 2) begin : gen_check_product_stages
    $error("ti_fp_newton: ProductStages must be 1 or 2.");
  end

  // What goes beside the products.
  typedef struct packed {
    logic exact;
    logic [YBits-1:0] y;
    logic [FracBits:0] x;  // for the next step
  } beside_t;

  // In front of product j: it is that of y and a factor.  The last ones are behind all products.
  beside_t beside_q[Products+1];
  logic [FactorBits-1:0] factor_q[Products+1];

  always_ff @(posedge clk_i) begin
    if (valid_i[0]) begin
      beside_q[0].exact <= exact_i;
      beside_q[0].y <= {Seeds[sig_i[FracBits-1-:TableBits]], {(YBits - TableBits - 1) {1'b0}}};
      beside_q[0].x <= sig_i;
      factor_q[0] <= FactorBits'(sig_i);
    end
  end

  for (genvar j = 0; j < Products; j++) begin : gen_product
    localparam bit First = (j % 2) == 0;  // of a step
    localparam int unsigned LastStage = SeedLatency + (j + 1) * ProductStages - 1;
    beside_t beside;
    logic [ProdBits-1:0] product;

    if (ProductStages == 1) begin : gen_whole
      assign beside  = beside_q[j];
      assign product = ProdBits'(beside_q[j].y) * ProdBits'(factor_q[j]);
    end else begin : gen_halves
      beside_t half_q;
      logic [YBits+LowBits-1:0] low_q;
      logic [YBits+HighBits-1:0] high_q;
      always_ff @(posedge clk_i) begin
        if (valid_i[LastStage-1]) begin
          half_q <= beside_q[j];
          low_q <= (YBits + LowBits)'(beside_q[j].y) * (YBits + LowBits)'(factor_q[j][LowBits-1:0]);
          high_q <= (YBits + HighBits)'(beside_q[j].y)
              * (YBits + HighBits)'(factor_q[j][FactorBits-1:LowBits]);
        end
      end
      assign beside  = half_q;
      assign product = ProdBits'(low_q) + {high_q, {LowBits{1'b0}}};
    end

    // x y makes the factor 2 - x y, whose product with y is the next y.
    beside_t next;
    logic [FactorBits-1:0] factor;
    if (First) begin : gen_first
      logic unused_product;
      assign next = beside;
      assign factor = ~product[FracBits+:FactorBits];
      assign unused_product = ^{product[ProdBits-1:FracBits+FactorBits], product[FracBits-1:0]};
    end else begin : gen_second
      logic unused_product;
      always_comb begin
        next   = beside;
        next.y = product[YBits+:YBits] + YBits'(!TowardZero);
      end
      assign factor = FactorBits'(beside.x);
      assign unused_product = ^{product[ProdBits-1:2*YBits], product[YBits-1:0]};
    end

    always_ff @(posedge clk_i) begin
      if (valid_i[LastStage]) begin
        beside_q[j+1] <= next;
        factor_q[j+1] <= factor;
      end
    end
  end

  assign inverse_o = {
    beside_q[Products].exact, beside_q[Products].exact ? YBits'(0) : beside_q[Products].y
  };

  logic unused_last;
  assign unused_last = ^{beside_q[Products].x, factor_q[Products]};

endmodule : ti_fp_newton
