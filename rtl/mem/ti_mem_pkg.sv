// SPDX-License-Identifier: Apache-2.0

/// The memory as units see it: lines, asked for by streams of `line_req_t` and answered by streams of
/// `line_rsp_t`.
///
/// Units that read memory come in `NumKinds` kinds.  Each unit has one line port; the ports of a core are numbered
/// kind by kind: those of kind k are KindFirst[k] to KindFirst[k] + KindUnits[k] - 1.  A kind may have an L2 of
/// KindL2Banks[k] banks.  Who asks the memory port are the banks of the kinds that have one and the units
/// of the others, its clients, numbered in the same way.
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

  /// Rows of a unit, hence ids under which it asks.
  localparam int unsigned KindRows[NumKinds] = '{
      ti_config_pkg::TrvRows,
      ti_config_pkg::ListRows,
      ti_config_pkg::Ist1Rows
  };
  /// Bytes of a kind's L2; 0: it has none.
  localparam int unsigned KindL2Bytes[NumKinds] = '{
      ti_config_pkg::TrvL2Bytes,
      ti_config_pkg::ListL2Bytes,
      ti_config_pkg::Ist1L2Bytes
  };
  localparam int unsigned KindL2Ways[NumKinds] = '{
      ti_config_pkg::TrvL2Ways,
      ti_config_pkg::ListL2Ways,
      ti_config_pkg::Ist1L2Ways
  };
  localparam int unsigned KindL2Banks[NumKinds] = '{
      (KindL2Bytes[0] > 0) ? ti_config_pkg::TrvL2Banks : 0,
      (KindL2Bytes[1] > 0) ? ti_config_pkg::ListL2Banks : 0,
      (KindL2Bytes[2] > 0) ? ti_config_pkg::Ist1L2Banks : 0
  };
  /// Lines on their way to a bank.
  localparam int unsigned KindL2Rows[NumKinds] = '{
      ti_config_pkg::TrvL2Rows,
      ti_config_pkg::ListL2Rows,
      ti_config_pkg::Ist1L2Rows
  };
  localparam int unsigned KindFirstBank[NumKinds] = '{
      0,
      KindL2Banks[0],
      KindL2Banks[0] + KindL2Banks[1]
  };
  localparam int unsigned NumBanks = KindL2Banks[0] + KindL2Banks[1] + KindL2Banks[2];

  localparam int unsigned KindClients[NumKinds] = '{
      (KindL2Bytes[0] > 0) ? KindL2Banks[0] : KindUnits[0],
      (KindL2Bytes[1] > 0) ? KindL2Banks[1] : KindUnits[1],
      (KindL2Bytes[2] > 0) ? KindL2Banks[2] : KindUnits[2]
  };
  localparam int unsigned KindFirstClient[NumKinds] = '{
      0,
      KindClients[0],
      KindClients[0] + KindClients[1]
  };
  localparam int unsigned NumClients = KindClients[0] + KindClients[1] + KindClients[2];
  localparam int unsigned ClientWidth = $clog2(NumClients);

  /// The most rows that a unit or a bank has.
  localparam int unsigned MaxUnitRows = (KindRows[0] > KindRows[1]) ?
      ((KindRows[0] > KindRows[2]) ? KindRows[0] : KindRows[2]) :
      ((KindRows[1] > KindRows[2]) ? KindRows[1] : KindRows[2]);
  localparam int unsigned MaxBankRows = (KindL2Rows[0] > KindL2Rows[1]) ?
      ((KindL2Rows[0] > KindL2Rows[2]) ? KindL2Rows[0] : KindL2Rows[2]) :
      ((KindL2Rows[1] > KindL2Rows[2]) ? KindL2Rows[1] : KindL2Rows[2]);
  localparam int unsigned MaxRows = (NumBanks > 0 && MaxBankRows > MaxUnitRows) ? MaxBankRows :
      MaxUnitRows;
  localparam int unsigned RowIdWidth = (MaxRows > 1) ? $clog2(MaxRows) : 1;

  typedef logic [AddrWidth-1:0] addr_t;
  typedef logic [LineAddrWidth-1:0] line_addr_t;
  typedef logic [LineBits-1:0] line_t;
  typedef logic [RowIdWidth-1:0] row_id_t;
  typedef logic [ClientWidth-1:0] client_t;

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

  /// A request among those of all clients of a core's memory port.
  typedef struct packed {
    client_t   client;
    line_req_t req;
  } port_req_t;

  /// Whose answer comes.
  typedef struct packed {
    client_t client;
    row_id_t id;
  } port_id_t;

  typedef struct packed {
    client_t   client;
    line_rsp_t rsp;
  } port_rsp_t;

endpackage : ti_mem_pkg
