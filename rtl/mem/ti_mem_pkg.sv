// SPDX-License-Identifier: Apache-2.0

/// The memory as units see it: lines, asked for by streams of `line_req_t` and answered by streams of
/// `line_rsp_t`.
///
/// Units that read memory come in `NumKinds` kinds.  Each unit has one line port; the ports of a core are numbered
/// kind by kind: those of kind k are KindFirst[k] to KindFirst[k] + KindUnits[k] - 1.
package ti_mem_pkg;

  localparam int unsigned AddrWidth = ti_config_pkg::AddrBits;
  localparam int unsigned LineBytes = ti_config_pkg::LineBytes;
  localparam int unsigned LineBits = 8 * LineBytes;
  localparam int unsigned LineAddrWidth = AddrWidth - $clog2(LineBytes);

  localparam int unsigned NumKinds = 3;
  localparam int unsigned KindUnits[NumKinds] = '{
      ti_config_pkg::NumTrv,
      ti_config_pkg::NumList,
      ti_config_pkg::NumIst1
  };
  localparam int unsigned KindFirst[NumKinds] = '{
      0,
      ti_config_pkg::NumTrv,
      ti_config_pkg::NumTrv + ti_config_pkg::NumList
  };
  localparam int unsigned NumPorts = ti_config_pkg::NumTrv + ti_config_pkg::NumList +
      ti_config_pkg::NumIst1;
  localparam int unsigned PortIndexWidth = $clog2(NumPorts);

  localparam int unsigned MaxRows = (ti_config_pkg::TrvRows > ti_config_pkg::ListRows) ?
      ((ti_config_pkg::TrvRows > ti_config_pkg::Ist1Rows) ? ti_config_pkg::TrvRows :
       ti_config_pkg::Ist1Rows) :
      ((ti_config_pkg::ListRows > ti_config_pkg::Ist1Rows) ? ti_config_pkg::ListRows :
       ti_config_pkg::Ist1Rows);
  localparam int unsigned RowIdWidth = (MaxRows > 1) ? $clog2(MaxRows) : 1;

  typedef logic [AddrWidth-1:0] addr_t;
  typedef logic [LineAddrWidth-1:0] line_addr_t;
  typedef logic [LineBits-1:0] line_t;
  typedef logic [RowIdWidth-1:0] row_id_t;
  typedef logic [PortIndexWidth-1:0] port_index_t;

  /// A unit asks for a line; it has at most one request in flight under an id.
  typedef struct packed {
    row_id_t    id;
    line_addr_t line;
  } line_req_t;

  /// The answer, in any order; `data` means nothing when `error` is 1.
  typedef struct packed {
    row_id_t id;
    logic    error;
    line_t   data;
  } line_rsp_t;

  /// A request among those of all ports of a core.
  typedef struct packed {
    port_index_t port_index;
    line_req_t   req;
  } port_req_t;

  /// Whose answer comes.
  typedef struct packed {
    port_index_t port_index;
    row_id_t     id;
  } port_id_t;

  typedef struct packed {
    port_index_t port_index;
    line_rsp_t   rsp;
  } port_rsp_t;

endpackage : ti_mem_pkg
