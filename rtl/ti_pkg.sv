// SPDX-License-Identifier: Apache-2.0

/// What passes between the clusters `ti_traverse` and `ti_intersect` and their surroundings.
///
/// A tree of another kind or a triangle test of another kind stands behind the same types.
package ti_pkg;

  typedef ti_num_pkg::fp_t fp_t;
  typedef ti_num_pkg::vec3_t vec3_t;

  localparam int unsigned TrvIndexWidth = (ti_config_pkg::NumTrv > 1) ? $clog2(
      ti_config_pkg::NumTrv
  ) : 1;
  localparam int unsigned TrvSlotWidth = $clog2(ti_config_pkg::TrvSlots);

  localparam int unsigned StepsWidth = $clog2(ti_config_pkg::WatchdogSteps + 1);

  typedef logic [TrvIndexWidth-1:0] trv_index_t;
  typedef logic [TrvSlotWidth-1:0] trv_slot_t;
  typedef logic [28:0] node_index_t;
  typedef logic [28:0] record_t;
  typedef logic [31:0] list_index_t;
  typedef logic [15:0] tri_count_t;
  typedef logic [StepsWidth-1:0] steps_t;
  typedef logic [31:0] prim_t;

  localparam prim_t NoPrim = '1;

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

  /// Where the scene stands in memory, from the header of its image plus the image's address.  The plane and
  /// barycentric parts start at multiples of 32 bytes, nodes at one of 8, lists at one of 4.
  typedef struct packed {
    node_index_t       root;
    list_index_t       num_list;     // entries of the lists
    record_t           num_records;  // triangles
    ti_mem_pkg::addr_t node_base;
    ti_mem_pkg::addr_t list_base;
    ti_mem_pkg::addr_t plane_base;
    ti_mem_pkg::addr_t bary_base;
    vec3_t             box_lo;
    vec3_t             box_hi;
  } scene_t;

  /// The slot in which a ray lives.
  typedef struct packed {
    trv_index_t trv;
    trv_slot_t  slot;
  } home_t;

  /// What a triangle test needs of a ray: origin and direction; of Woop's test in place of the direction sx, sy and sz
  /// (`ti_rd_shear`), from d[0] on.  As |sx| and |sy| are less than 2, the highest bits of their exponents are 0: there
  /// stand the two bits of the axis z.
  typedef struct packed {
    vec3_t o;
    vec3_t d;
  } ray_operands_t;

  function automatic vec3_t with_axis(vec3_t shear, logic [1:0] z);
    with_axis                           = shear;
    with_axis[0][ti_num_pkg::FpWidth-2] = z[0];
    with_axis[1][ti_num_pkg::FpWidth-2] = z[1];
  endfunction
  function automatic logic [1:0] axis_of(vec3_t d);
    return {d[1][ti_num_pkg::FpWidth-2], d[0][ti_num_pkg::FpWidth-2]};
  endfunction

  /// Traversal -> intersection: a leaf that a ray has reached.
  typedef struct packed {
    home_t         home;
    list_index_t   first;
    tri_count_t    count;     // 1 or more
    ray_operands_t operands;
    fp_t           tnear;     // its tests count from here
    fp_t           tfar;      // to here; outside they may be dropped
  } leaf_t;

  /// Intersection -> traversal: `count` tests of the leaf are over.
  typedef struct packed {
    home_t      home;
    tri_count_t count;
    logic       error;  // memory answered with an error, or an index was beyond its section
    logic       hit;    // count is 1 and the rest is valid
    prim_t      prim;
    fp_t        t;
    fp_t        u;
    fp_t        v;
  } return_t;

endpackage : ti_pkg
