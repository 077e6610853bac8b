// SPDX-License-Identifier: Apache-2.0

/// Types that units share, all derived from the configuration.
package ti_pkg;

  localparam int unsigned ExpBits = ti_config_pkg::ExpBits;
  localparam int unsigned FracBits = ti_config_pkg::FracBits;
  localparam int unsigned FpWidth = 1 + ExpBits + FracBits;
  localparam int unsigned AddrWidth = ti_config_pkg::AddrBits;
  localparam int unsigned LineBytes = ti_config_pkg::LineBytes;
  localparam int unsigned LineBits = 8 * LineBytes;
  localparam int unsigned LineAddrWidth = AddrWidth - $clog2(LineBytes);
  localparam int unsigned CounterWidth = 48;

  localparam int unsigned TrvIndexWidth = (ti_config_pkg::NumTrv > 1) ? $clog2(
      ti_config_pkg::NumTrv
  ) : 1;
  localparam int unsigned TrvSlotWidth = $clog2(ti_config_pkg::TrvSlots);

  typedef logic [FpWidth-1:0] fp_t;
  typedef fp_t [2:0] vec3_t;  // [0] = x, [1] = y, [2] = z
  typedef logic [AddrWidth-1:0] addr_t;
  typedef logic [LineAddrWidth-1:0] line_addr_t;
  typedef logic [LineBits-1:0] line_t;
  typedef logic [28:0] node_index_t;
  typedef logic [28:0] record_t;
  typedef logic [15:0] tri_count_t;
  typedef logic [15:0] steps_t;
  typedef logic [31:0] prim_t;
  typedef logic [TrvSlotWidth-1:0] trv_slot_t;
  typedef logic [TrvIndexWidth-1:0] trv_index_t;
  typedef logic [CounterWidth-1:0] counter_t;

  localparam prim_t NoPrim = '1;

  // Bit patterns of the number format.
  localparam fp_t FpInf = fp_t'({1'b0, {ExpBits{1'b1}}, {FracBits{1'b0}}});
  localparam int unsigned FpBias = (1 << (ExpBits - 1)) - 1;

  typedef enum logic [1:0] {
    Ok          = 2'd0,
    InvalidRay  = 2'd1,
    MemoryError = 2'd2,
    Watchdog    = 2'd3
  } status_e;

  /// The host's ray: o + t d for tmin <= t <= tmax.
  typedef struct packed {
    logic [31:0] ray_id;
    logic        any_hit;  // report hit or miss only
    vec3_t       o;
    vec3_t       d;
    fp_t         tmin;
    fp_t         tmax;
  } ray_t;

  /// The engine's answer.  A miss has t = +inf, u = v = 0, prim all ones; an any-hit ray's hit has zeros.
  typedef struct packed {
    logic [31:0] ray_id;
    status_e     status;
    logic        hit;
    prim_t       prim;
    fp_t         t;
    fp_t         u;
    fp_t         v;
    steps_t      steps;
  } hit_t;

  /// Where the scene stands in memory, from the header of its image plus the image's address.
  typedef struct packed {
    node_index_t root;
    addr_t       node_base;
    addr_t       list_base;
    addr_t       plane_base;
    addr_t       bary_base;
    vec3_t       box_lo;
    vec3_t       box_hi;
  } scene_t;

  /// Tree node as in memory, 8 bytes, word 1 above word 0.
  typedef struct packed {
    logic [28:0] link;     // inner: the child that is not adjacent; leaf: triangle count
    logic        reorder;  // inner: 1 when the adjacent child is the upper one
    logic [1:0]  axis;     // 3: leaf
    logic [31:0] value;    // inner: split; leaf: first list entry
  } node_t;

  /// Plane part of a triangle as in memory, 32 bytes, word 7 first.
  typedef struct packed {
    logic [31:0] reserved;
    logic [31:0] prim;
    logic [31:0] axis;
    logic [31:0] pw;
    logic [31:0] pv;
    logic [31:0] pu;
    logic [31:0] nv;
    logic [31:0] nu;
  } plane_t;

  /// Barycentric part of a triangle as in memory, 16 bytes, word 3 first.
  typedef struct packed {
    logic [31:0] e1v;
    logic [31:0] e1u;
    logic [31:0] e0v;
    logic [31:0] e0u;
  } bary_t;

  typedef struct packed {
    trv_index_t trv;
    trv_slot_t  slot;
  } home_t;

  /// RD -> TRV: a ray that enters the scene box.
  typedef struct packed {
    ray_t  ray;
    vec3_t inv;   // 1 / d
    fp_t   tmin;  // interval of the traversal
    fp_t   tmax;
  } dispatch_t;

  /// TRV -> LIST: the leaf that a ray has reached.
  typedef struct packed {
    home_t       home;
    logic [31:0] first;
    tri_count_t  count;
    vec3_t       o;
    vec3_t       d;
    fp_t         tbest;
  } leaf_t;

  /// LIST -> IST1: one ray against one triangle.
  typedef struct packed {
    home_t   home;
    record_t record;
    vec3_t   o;
    vec3_t   d;
    fp_t     tbest;
  } test_t;

  /// IST1 -> IST2: a test that is inside the triangle.
  typedef struct packed {
    home_t home;
    prim_t prim;
    fp_t   det;
    fp_t   dett;
    fp_t   detu;
    fp_t   detv;
  } candidate_t;

  /// LIST, IST1, IST2 -> home: `count` tests of the leaf are over.
  typedef struct packed {
    home_t      home;
    tri_count_t count;
    logic       error;  // memory answered with an error
    logic       hit;    // count is 1 and the rest is valid
    prim_t      prim;
    fp_t        t;
    fp_t        u;
    fp_t        v;
  } return_t;

  typedef struct packed {
    counter_t accesses;
    counter_t hits;
    counter_t merged;
    counter_t misses;
  } cache_counters_t;

  typedef struct packed {
    counter_t        steps;        // nodes visited, leaves included
    counter_t        leaves;       // leaves visited
    counter_t        full_leaves;  // of these, with triangles
    counter_t        restarts;
    counter_t        rays;         // retired here
    cache_counters_t cache;
  } trv_counters_t;

  typedef struct packed {
    counter_t        ids;
    cache_counters_t cache;
  } list_counters_t;

  typedef struct packed {
    counter_t        a_passes;
    counter_t        b_passes;
    cache_counters_t cache;
  } ist1_counters_t;

  typedef struct packed {counter_t c_passes;} ist2_counters_t;

  /// Bits of a number below `num`, 1 at least.
  function automatic int unsigned index_width(input int unsigned num);
    return (num > 1) ? $clog2(num) : 1;
  endfunction

  /// Width of ARID and RID of `ti_memory`: two bits for the kind of unit, then the widest {port, row}.
  function automatic int unsigned memory_id_width(
      input int unsigned num_trv, input int unsigned trv_rows, input int unsigned num_list,
      input int unsigned list_rows, input int unsigned num_ist1, input int unsigned ist1_rows);
    int unsigned widest;
    widest = index_width(num_trv) + index_width(trv_rows);
    if (index_width(num_list) + index_width(list_rows) > widest)
      widest = index_width(num_list) + index_width(list_rows);
    if (index_width(num_ist1) + index_width(ist1_rows) > widest)
      widest = index_width(num_ist1) + index_width(ist1_rows);
    return widest + 2;
  endfunction

  // Classes of numbers.
  function automatic logic [ExpBits-1:0] fp_exponent(input fp_t x);
    return x[FracBits+:ExpBits];
  endfunction
  function automatic logic fp_sign(input fp_t x);
    return x[FpWidth-1];
  endfunction
  function automatic fp_t fp_magnitude(input fp_t x);
    return {1'b0, x[FpWidth-2:0]};
  endfunction
  function automatic logic fp_is_zero(input fp_t x);
    return x[FpWidth-2:0] == '0;
  endfunction
  function automatic logic fp_is_finite(input fp_t x);
    return fp_exponent(x) != '1;
  endfunction
  function automatic logic fp_is_normal(input fp_t x);
    return fp_is_finite(x) && fp_exponent(x) != '0;
  endfunction
  function automatic logic fp_is_nan(input fp_t x);
    return !fp_is_finite(x) && x[FracBits-1:0] != '0;
  endfunction
  function automatic logic fp_is_inf(input fp_t x);
    return !fp_is_finite(x) && x[FracBits-1:0] == '0;
  endfunction
  /// Magnitude of `x`, `ulps` places up in the order of bit patterns, infinity at most.
  function automatic fp_t fp_ulps_up(input fp_t x, input int unsigned ulps);
    fp_t sum;
    sum = fp_magnitude(x) + fp_t'(ulps);
    return (sum > FpInf) ? FpInf : sum;
  endfunction
  /// Magnitude of `x`, `ulps` places down, 0 at least.
  function automatic fp_t fp_ulps_down(input fp_t x, input int unsigned ulps);
    return (fp_magnitude(x) > fp_t'(ulps)) ? fp_magnitude(x) - fp_t'(ulps) : '0;
  endfunction

  /// `v` with its components in the order u, v, w for the axis `w`: [2] = v[w], [0] = v[w + 1 mod 3].
  function automatic vec3_t turn_to(input vec3_t v, input logic [1:0] w);
    unique case (w)
      2'd0: return {v[0], v[2], v[1]};
      2'd1: return {v[1], v[0], v[2]};
      default: return {v[2], v[1], v[0]};
    endcase
  endfunction

endpackage : ti_pkg
