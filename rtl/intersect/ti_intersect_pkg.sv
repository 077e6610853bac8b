// SPDX-License-Identifier: Apache-2.0

/// What passes inside the intersection cluster, and the triangle in memory.
package ti_intersect_pkg;

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

  /// LIST -> IST1: one ray against one triangle.
  typedef struct packed {
    ti_pkg::home_t         home;
    ti_pkg::record_t       record;
    ti_pkg::ray_operands_t operands;
    ti_pkg::fp_t           tnear;
    ti_pkg::fp_t           tfar;
  } test_t;

  /// IST1 -> IST2: a test that is inside the triangle, or, where tests do not end early, any.
  typedef struct packed {
    ti_pkg::home_t home;
    logic          miss;  // it has failed a pass
    ti_pkg::prim_t prim;
    ti_pkg::fp_t   det;
    ti_pkg::fp_t   dett;
    ti_pkg::fp_t   detu;
    ti_pkg::fp_t   detv;
  } candidate_t;

  /// Bytes of a packed record of Woop's test, and that record: corners of nine coordinates, the triangle.
  localparam int unsigned CornerBytes = (9 * ti_num_pkg::FpWidth + 32 <= 256) ? 32 : 64;

  typedef struct packed {
    ti_pkg::prim_t       prim;
    ti_pkg::vec3_t [2:0] p;
  } corners_t;

  /// Of Woop's test: the edge functions, each the weight of a corner, the corners' ways along z, and the inverse of
  /// the direction along z.
  typedef struct packed {
    ti_pkg::vec3_t weight;
    ti_pkg::vec3_t z;
    ti_pkg::fp_t   sz;
  } edges_t;

  /// IST1 -> IST2 of Woop's test: the ray passes between the corners, or, where tests do not end early, any.
  typedef struct packed {
    ti_pkg::home_t home;
    logic          miss;
    ti_pkg::prim_t prim;
    edges_t        edges;
  } woop_candidate_t;

endpackage : ti_intersect_pkg
