// SPDX-License-Identifier: Apache-2.0

/// What passes inside the traversal cluster, whatever the kind of tree.
package ti_traverse_pkg;

  /// Where a ray begins for its way through the tree: `least` makes each t of a plane the least that rounding may
  /// come to, `most` the greatest.  Both are o for a ray that is not thick (`ti_rd_thick`).
  typedef struct packed {
    ti_pkg::vec3_t least;
    ti_pkg::vec3_t most;
  } origins_t;

  /// RD -> TRV: a ray that enters the scene box.
  typedef struct packed {
    logic [31:0]           ray_id;
    logic                  any_hit;
    ti_pkg::ray_operands_t operands;
    ti_pkg::fp_t           ray_tmin;  // interval in which hits count
    ti_pkg::fp_t           ray_tmax;
    origins_t              origins;
    ti_pkg::vec3_t         inv;       // 1 / d
    ti_pkg::fp_t           tmin;      // interval of the traversal
    ti_pkg::fp_t           tmax;
  } dispatch_t;

  /// The best hit of a ray.
  typedef struct packed {
    logic          hit;   // there is one, and the rest is valid
    ti_pkg::fp_t   t;
    ti_pkg::fp_t   u;
    ti_pkg::fp_t   v;
    ti_pkg::prim_t prim;
  } best_t;

endpackage : ti_traverse_pkg
