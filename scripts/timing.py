#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Longest path, gates and flops of each unit in a 0.18 um library: what limits the clock.

Yosys with its slang front end maps a unit of a configuration, flattened, to the OSU standard cells;
the delay is what `stime -p` of abc says after buffering and sizing.  It is that of the gates
between two registers, an input and a register, a register and an output, or an input and an output:
without the registers' own times, wires, or the clock's skew, and a register or an input drives any
load at once.  The memory of a `ti_ram_1r1w` is cut out: paths end at its ports and begin behind its
read register, and neither its access time nor its area is in the table.  Other arrays are flops and
multiplexers.

Exit status: 0 within the limit, 1 when a unit exceeds it, 2 when something cannot be measured.

Usage: scripts/timing.py DIR [--unit MODULE ...] [--limit NS] [--rtl DIR] [--json FILE]
DIR is the folder that scripts/configure.py wrote; logs go to `timing` in it.
"""

import argparse
import json
import re
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from synth_check import OPERATORS, ROOT, Synthesis

# Measured unless one is named, as far as the RTL has them.
UNITS = (
    *OPERATORS,
    "ti_trv",
    "ti_trv_return",
    "ti_trv_best",
    "ti_kd_state",
    "ti_list",
    "ti_ist1",
    "ti_ist1_pipe",
    "ti_ist2",
    "ti_ra",
    "ti_l1",
    "ti_l2_bank",
    "ti_memory",
    "ti_axi_read",
    "ti_core_deal",
    "ti_rd",
    "ti_rd_clip",
)

LIBERTY = Path("/usr/share/qflow/tech/osu018/osu018_stdcells.lib")
NAND2_UM2 = 24.0  # area of NAND2X1, one gate equivalent
FLOPS = re.compile(r"(DFF|LATCH)")
ABC = (
    "strash; ifraig; scorr; dc2; dch -f; map -B 0.9 -D 4000; topo; "
    "buffer -c; upsize; dnsize; stime -p"
)
# The memory of a RAM wrapper: its read is clocked.  Paths that end at it end at new outputs.
CUT_RAMS = (
    "select -set rams t:$mem_v2 n:*mem_q %i r:RD_CLK_ENABLE=1'1 %i",
    "expose @rams %ci:+[RD_ADDR,RD_EN,WR_ADDR,WR_DATA,WR_EN] w:* %i",
    "delete @rams",
    "setundef -undriven -expose",
)


class MeasureError(Exception):
    """One sentence: what could not be measured and where to look."""


@dataclass(frozen=True)
class Timing:
    """One line of the table."""

    unit: str
    delay_ns: float
    gates: float  # in NAND2X1, flops included
    flops: int
    seconds: float
    start: str  # register or input bit where the longest path begins
    end: str


def register(netlist: dict, name: str, pin: str) -> str:
    """The register whose pin (D or Q) is on a net of abc, `\\name [index]`, or the port there."""
    plain, _, index = name.removeprefix("\\").partition(" [")
    net = netlist["netnames"].get(plain)
    if net is None:
        return name
    bit = net["bits"][int(index.rstrip("]") or 0) - net.get("offset", 0)]
    for cell in netlist["cells"].values():
        if FLOPS.match(cell["type"]) and cell["connections"].get(pin) == [bit]:
            return f"register {net_of(netlist, cell['connections']['Q'][0])}"
    for port, what in netlist["ports"].items():
        if bit in what["bits"]:
            return f"{what['direction']} {bit_name(port, what['bits'], bit)}"
    return name


def bit_name(name: str, bits: list, bit: int) -> str:
    return name if len(bits) == 1 else f"{name}[{bits.index(bit)}]"


def net_of(netlist: dict, bit: int) -> str:
    """The shortest name that the RTL has for a net, else the shortest of Yosys."""
    names = [
        (net["hide_name"], len(name), bit_name(name, net["bits"], bit))
        for name, net in netlist["netnames"].items()
        if bit in net["bits"]
    ]
    return min(names)[2]


def measure(synthesis: Synthesis, unit: str) -> Timing:
    """Map one unit and take its figures from the logs of Yosys and abc."""
    begin = time.monotonic()
    script = synthesis.work / "abc.script"
    script.write_text(ABC + "\n")
    stat, netlist = (synthesis.work / f"{unit}.{kind}.json" for kind in ("stat", "netlist"))
    good, text = synthesis.run(
        unit,
        synthesis.read(unit),
        f"synth -flatten -top {unit} -run begin:fine",
        *CUT_RAMS,
        f"synth -flatten -top {unit} -run fine:check",
        f"dfflibmap -liberty {LIBERTY}",
        f"abc -liberty {LIBERTY} -script {script}",
        f"write_json {netlist}",
        f"tee -q -o {stat} stat -json -liberty {LIBERTY}",
    )
    delay = re.findall(r"^ABC: .*Delay = *([\d.]+) ps", text, re.MULTILINE)
    ends = re.findall(
        r"^ABC: Start-point = \w+ \((.*?)\)\.  End-point = \w+ \((.*?)\)\.", text, re.MULTILINE
    )
    if not (good and delay and ends):
        raise MeasureError(f"{unit}: Yosys gives no delay; see {synthesis.work / unit}.log")
    design = json.loads(stat.read_text())["design"]
    module = json.loads(netlist.read_text())["modules"][unit]
    cells = design["num_cells_by_type"]
    return Timing(
        unit=unit,
        delay_ns=float(delay[-1]) / 1000,
        gates=design["area"] / NAND2_UM2,
        flops=sum(count for name, count in cells.items() if FLOPS.match(name)),
        seconds=time.monotonic() - begin,
        start=register(module, ends[-1][0], "Q"),
        end=register(module, ends[-1][1], "D"),
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("config", type=Path, metavar="DIR", help="folder of ti_config_pkg.sv")
    parser.add_argument("--unit", nargs="*", metavar="MODULE", help="these modules instead of all")
    parser.add_argument("--limit", type=float, metavar="NS", help="status 1 when a path is longer")
    parser.add_argument("--rtl", type=Path, default=ROOT / "rtl", help="folder of ti.f")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the table to FILE")
    arguments = parser.parse_args()
    try:
        return run(arguments)
    except (MeasureError, OSError) as error:
        print(f"timing: {error}", file=sys.stderr)
        return 2


def run(arguments: argparse.Namespace) -> int:
    """Measure what the arguments say and print the table as it grows."""
    if not (arguments.config / "config.json").is_file():
        raise MeasureError(f"{arguments.config} has no config.json; scripts/configure.py writes it")
    if not LIBERTY.is_file():
        raise MeasureError(f"{LIBERTY} is missing; 'scripts/setup.sh --extra' installs it")
    exists = {file.stem for file in arguments.rtl.rglob("*.sv")}
    for unit in arguments.unit or ():
        if unit not in exists:
            raise MeasureError(f"{unit}: there is no such module in {arguments.rtl}")
    units = arguments.unit or [unit for unit in UNITS if unit in exists]

    synthesis = Synthesis(arguments.config, arguments.rtl, "timing")
    print(f"{synthesis.config['name']}: ns by abc in OSU 0.18 um, gates in NAND2X1")
    print(f"{'unit':14}{'ns':>6}{'gates':>9}{'flops':>8}{'s':>6}  longest path")
    rows = []
    for unit in units:
        row = measure(synthesis, unit)
        rows.append(row)
        over = arguments.limit is not None and row.delay_ns > arguments.limit
        print(
            f"{unit:14}{row.delay_ns:6.2f}{row.gates:9.0f}{row.flops:8}{row.seconds:6.0f}  "
            f"{row.start} -> {row.end}{'  OVER THE LIMIT' if over else ''}",
            flush=True,
        )
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        result = {"config": synthesis.config, "units": [asdict(row) for row in rows]}
        arguments.json.write_text(json.dumps(result, indent=2) + "\n")
    if arguments.limit is None:
        return 0
    bad = [row.unit for row in rows if row.delay_ns > arguments.limit]
    print(f"over {arguments.limit:g} ns: {', '.join(bad) or 'none'}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
