// SPDX-License-Identifier: Apache-2.0

/// The kd-tree in memory.
package ti_kd_pkg;

  /// Tree node as in memory, 8 bytes, word 1 above word 0.
  typedef struct packed {
    logic [28:0] link;     // inner: the child that is not adjacent; leaf: triangle count
    logic        reorder;  // inner: 1 when the adjacent child is the upper one
    logic [1:0]  axis;     // 3: leaf
    logic [31:0] value;    // inner: split; leaf: first list entry
  } node_t;

  /// Levels of a tree that a restart trail has a bit for.
  localparam int unsigned TrailLevels = 64;

  /// Which of a ray's choices on its way down are done (Laine 2010): a bit for each level, 1 where nothing is left
  /// to do behind the child that the ray has gone to; and the level that it has reached.
  typedef struct packed {
    logic [6:0]             level;
    logic [TrailLevels-1:0] done;
  } trail_t;

endpackage : ti_kd_pkg
