# SPDX-License-Identifier: Apache-2.0
"""What the cells of an FPGA family that Yosys maps to are worth in LUT, FF, DSP, BRAM and LUTRAM.

LUT: look-up tables of logic and of carries.  LUTRAM: look-up tables used as memory or as shift
registers.  BRAM: blocks of 36 Kb on Xilinx, where one of 18 Kb is a half; of 18 Kb on ECP5 and
Gowin.  DSP: DSP48 on Xilinx, 18x18 multipliers on ECP5 and Gowin, where one of 9x9 is a half.
Sources: the families' configurable-logic guides (UG474, UG574: RAM64M is four LUTs, RAM64M8 eight),
ECP5 FPGA-TN-02204 (DPR16X4: four LUTs as memory), Gowin UG288 (RAM16SDP4: four).
"""

import re
from dataclasses import dataclass

from synthesis import MeasureError

COLUMNS = ("LUT", "FF", "DSP", "BRAM", "LUTRAM")


@dataclass(frozen=True)
class Family:
    """One family: name, command, and pairs of a pattern of cell types and (column, how many)."""

    name: str
    command: str
    worth: tuple[tuple[str, str | None, float], ...]


XILINX = (
    (r"LUT[1-6]|INV", "LUT", 1),
    (r"FD[RSCP]E(_1)?", "FF", 1),
    (r"DSP48E[12]", "DSP", 1),
    (r"RAMB36E[12]", "BRAM", 1),
    (r"RAMB18E[12]", "BRAM", 0.5),
    (r"SRL16E|SRLC32E|RAM(16|32|64)X1S(_1)?", "LUTRAM", 1),
    (r"RAM(16|32|64)X1D(_1)?|RAM128X1S(_1)?", "LUTRAM", 2),
    (r"RAM32M|RAM64M|RAM128X1D|RAM256X1S", "LUTRAM", 4),
    (r"RAM32M16|RAM64M8|RAM256X1D|RAM512X1S|RAM32X16DR8|RAM64X8SW", "LUTRAM", 8),
    (r"CARRY[48]|MUXF[789]|[IO]BUF|BUFG|GND|VCC", None, 0),
)
FPGAS = {
    "xcup": Family("Xilinx UltraScale+", "synth_xilinx -family xcup -noiopad -noclkbuf", XILINX),
    "xc7": Family("Xilinx 7 series", "synth_xilinx -family xc7 -noiopad -noclkbuf", XILINX),
    "ecp5": Family(
        "Lattice ECP5",
        "synth_ecp5 -noflatten",
        (
            (r"LUT4", "LUT", 1),
            (r"CCU2C", "LUT", 2),
            (r"TRELLIS_FF", "FF", 1),
            (r"MULT18X18D", "DSP", 1),
            (r"MULT9X9D", "DSP", 0.5),
            (r"DP16KD|PDPW16KD", "BRAM", 1),
            (r"TRELLIS_DPR16X4", "LUTRAM", 4),
            (r"PFUMX|L6MUX21|ALU54B", None, 0),
        ),
    ),
    "gowin": Family(
        "Gowin GW2A",
        "synth_gowin -family gw2a -noiopads -noflatten",
        (
            (r"LUT[1-4]|ALU|INV", "LUT", 1),
            (r"DFFN?[SRPC]?E?", "FF", 1),
            (r"MULT18X18", "DSP", 1),
            (r"MULT9X9", "DSP", 0.5),
            (r"MULT36X36", "DSP", 4),
            (r"(SP|SDPB?|DPB?|pROM)(X?9B?)?", "BRAM", 1),
            (r"RAM16SDP4|RAM16S4", "LUTRAM", 4),
            (r"RAM16SDP2|RAM16S2", "LUTRAM", 2),
            (r"RAM16SDP1|RAM16S1", "LUTRAM", 1),
            (r"MUX2_LUT[5678]|GND|VCC|GSR|[IO]BUF", None, 0),
        ),
    ),
}


def columns(part: str, stat: dict) -> dict[str, float]:
    """Columns of a module from what `stat -json` says of it."""
    found = dict.fromkeys(COLUMNS, 0)
    for name, count in stat["num_cells_by_type"].items():
        if "$ti_" in name:
            continue  # a unit, which has a row of its own
        for kind, column, worth in FPGAS[part].worth:
            if re.fullmatch(kind, name):
                if column:
                    found[column] += count * worth
                break
        else:
            raise MeasureError(f"{part}: it is not known what a cell {name} is worth")
    return found
