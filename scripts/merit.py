#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Figure of merit: cells, clock and cycles of configurations, and rays a second for each of them.

Runs `scripts/area.py`, `scripts/fmax.py` and `scripts/bench.py` on each configuration, or takes
what they wrote before (--file), and writes `merit.json` and `merit.md`: a row for each
configuration and part, beside published engines.

The clock is that of the whole engine by the part's open tools.  Where it cannot be had, the column
says why, and what follows from a clock is left out.  If single units were timed instead, the clock
of the slowest stands there, and it and all that follows are called an estimate.

Exit status: 0, 1 when a check of a bench or of RAM bits failed, 2 for bad input.

Usage: scripts/merit.py --config NAME ... --part PART ... --scene FILE --out FOLDER
                        [--set "KEY=VALUE ..."] [--cores N] [--unit MODULE ...] [--seeds N]
                        [--file FILE ...] [BENCH_OPTIONS]
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import area
import bench
import compare
import operators
import points
from config_schema import ConfigError
from synthesis import configuration_hash, write_json

ENGINE = "ti_engine"
# A part of `make area`, and the device on which `make fmax` times it.
DEVICES = {"ecp5": "ecp5-85k", "gowin": "gowin", "osu018": "osu018"}
# What a device holds, in columns of `make area`; look-up tables that are memory count as LUT.
# Sources: nextpnr's database for the ECP5-85F, Gowin DS102 for the GW2A-18.
CAPACITY = {
    "ecp5-85k": {"LUT": 83640, "FF": 83640, "DSP": 156, "BRAM": 208},
    "gowin": {"LUT": 20736, "FF": 15552, "DSP": 48, "BRAM": 46},
}
SAMPLE = ["--rays", "primary", "--sample-primary", "--count", "40000"]

WORDS = ["machine", "part"]
# Columns of figures: heading, key of a row, form, whether it follows from the clock.
FIGURES = (
    ("LUT", "LUT", "{:,.0f}", False),
    ("FF", "FF", "{:,.0f}", False),
    ("DSP", "DSP", "{:,g}", False),
    ("BRAM", "BRAM", "{:,g}", False),
    ("gate equivalents", "gate_equivalents", "{:,.0f}", False),
    ("mm2 at 65 nm", "mm2_65nm", "{:.3f}", False),
    ("MHz", "mhz", "{:.1f}", True),
    ("cycles a ray", "cycles_per_ray", "{:.2f}", False),
    ("Mrays/s", "mrays_per_s", "{:.3f}", True),
    ("Mrays/s per kLUT", "mrays_per_s_klut", "{:.4f}", True),
    ("Mrays/s per mm2", "mrays_per_s_mm2", "{:.3f}", True),
    ("rays per kcycle and kLUT", "rays_per_kcycle_klut", "{:.3f}", False),
)
# Engines of others, as published; what differs is said with each.
PUBLISHED = (
    {
        "configuration": "T&I Engine, one core",
        "part": "65 nm",
        "mm2_65nm": operators.PAPER_MM2["core"],
        "mhz": 500,
        "differs": "Nah et al. 2011: a sum of areas of its parts, 4.95 mm2 of it wiring, which is "
        "left out of ours; its table of Mrays/s is not at hand",
    },
    {
        "configuration": "Vortex RTU",
        "part": "U55C",
        "LUT": 67881,
        "FF": 95516,
        "DSP": 146,
        "BRAM": 53,
        "mhz": 297.5,
        "cycles_per_ray": 67,
        "differs": "placed and routed by Vivado for 300 MHz, slack -0.028 ns, where ours are cells "
        "by Yosys; its scene has 16 KB and lies in the unit, where ours is read from memory; the "
        "cycles are those of a program on its GPU",
    },
    {
        "configuration": "Vortex RTU",
        "part": "ASAP7",
        "mhz": 956.8,
        "cycles_per_ray": 67,
        "differs": "7 nm cells by Yosys and OpenSTA; another configuration of it than on the U55C",
    },
)
# What a reader must know of the columns, below each table.
REMARKS = (
    "LUT includes those that are memory. BRAM: blocks of 36 Kb on Xilinx, of 18 Kb on the others.",
    "MHz of osu018 is of 0.18 um cells without wires, and Mrays/s per mm2 has that clock over an "
    "area at 65 nm.",
)


class MeritError(Exception):
    """One sentence for the user."""


# --- Arithmetic -----------------------------------------------------------------------------------


def cells_of(result: dict) -> dict[str, float]:
    """Columns of a part's area."""
    found = {k: result[k] for k in ("FF", "DSP", "BRAM", "gate_equivalents", "mm2_65nm", "um2")
             if k in result}  # fmt: skip
    if "LUT" in result:
        found["LUT"] = result["LUT"] + result["LUTRAM"]
    return found


def misfit(part: str, cells: dict[str, float]) -> str | None:
    """What a device has too little of, if anything."""
    room = CAPACITY.get(DEVICES.get(part), {})
    over = [f"{cells[c]:,g} of {n:,} {c}" for c, n in room.items() if cells[c] > n]
    return f"does not fit: {', '.join(over)}" if over else None


def clock_of(units: dict[str, dict]) -> dict:
    """The engine's clock where it was timed, else an estimate: its slowest unit's."""
    name = ENGINE if ENGINE in units else min(units, key=lambda u: units[u]["median_mhz"])
    clock = {"mhz": units[name]["median_mhz"], "of": name, "seeds": units[name]["mhz"]}
    return clock if name == ENGINE else clock | {"estimate": True, "units": len(units)}


def with_merit(row: dict) -> dict:
    """A row with what follows from its cells, clock and cycles, as far as it has them."""
    cycles, klut = row.get("cycles_per_ray"), row.get("LUT", 0) / 1000
    found = dict(row)
    if cycles and klut:
        found["rays_per_kcycle_klut"] = 1000 / cycles / klut
    if cycles and row.get("mhz"):
        found["mrays_per_s"] = row["mhz"] / cycles
        if klut:
            found["mrays_per_s_klut"] = found["mrays_per_s"] / klut
        if row.get("mm2_65nm"):
            found["mrays_per_s_mm2"] = found["mrays_per_s"] / row["mm2_65nm"]
    return found


# --- Table ----------------------------------------------------------------------------------------


def figures(row: dict) -> list[str]:
    """Figures of a row as they stand in the table."""
    texts = []
    for _, key, form, of_clock in FIGURES:
        text = form.format(row[key]) if row.get(key) is not None else ""
        estimate = of_clock and text and row.get("clock", {}).get("estimate")
        texts.append(f"estimate {text}" if estimate else text)
        if key == "mhz" and not text:
            texts[-1] = row.get("clock", {}).get("why", "")
    return texts


def run_of(row: dict) -> str:
    """What was traced, and the memory behind it."""
    memory = row["memory"]
    text = f"Cycles: {row['rays']:,} primary rays of {row['scene']}, memory {memory['kind']}"
    if memory["kind"] == "fixed":
        text += f", {memory['latency']} cycles, {memory['bytes_per_cycle']:g} bytes a cycle"
    return text + "."


def remarks(rows: list[dict]) -> list[str]:
    """Lines below the table."""
    runs = dict.fromkeys(run_of(row) for row in rows if "rays" in row)
    lines = [f"- {text}" for text in (*runs, *REMARKS)]
    for row in rows:
        clock, texts = row.get("clock", {}), []
        if clock.get("estimate"):
            texts.append(f"estimate: {clock['of']}, slowest of {clock['units']} units timed alone")
            texts += [f"the engine {clock['why']}"] if "why" in clock else []
        elif clock.get("timed_on"):
            seeds = list(clock["seeds"].values())
            spread = f", {min(seeds):.1f} to {max(seeds):.1f} MHz" if len(seeds) > 1 else ""
            texts.append(f"timed whole on {clock['timed_on']}, seeds: {len(seeds)}{spread}")
        texts += [row["differs"]] if "differs" in row else []
        if texts:
            lines.append(f"- {row['configuration']}, {row['part']}: {'; '.join(texts)}.")
    return lines


def write(out: Path, head: dict, rows: list[dict]) -> None:
    """Both files."""
    published = [with_merit(row) for row in PUBLISHED]
    write_json(out / "merit.json", head | {"rows": rows, "published": published})
    shown = [*rows, *published]
    cells = [[row["configuration"], row["part"], *figures(row)] for row in shown]
    points.write_table(out / "merit.md", WORDS, [f[0] for f in FIGURES], cells)
    with (out / "merit.md").open("a") as file:
        file.write("\n" + "\n".join(remarks(shown)) + "\n")


# --- Measurements ---------------------------------------------------------------------------------


def taken(files: list[Path]) -> list[dict]:
    """What commands wrote before, each with the hash of its configuration."""
    found = []
    for file in files:
        try:
            value = json.loads(file.read_text())
            if value.get("schema") == bench.SCHEMA:
                value["configuration_hash"] = configuration_hash(value["config"])
            elif "units" not in value:
                raise KeyError("units")
            found.append(value | {"file": str(file)})
        except (OSError, ValueError, KeyError, AttributeError) as error:
            raise MeritError(
                f"FILE={file}: no JSON of make area, make fmax or make bench ({error})"
            ) from None
    return found


class Machine:
    """One configuration: where its files are, and what is known of it."""

    def __init__(self, name: str, arguments: argparse.Namespace, stored: list[dict]):
        self.arguments = argparse.Namespace(**vars(arguments) | {"config": name})
        config, _ = compare.machine_of(self.arguments, "")
        self.name = config.name
        self.out = arguments.out / config.folder.name
        self.hash = configuration_hash({"name": config.name, **config.values})
        self.stored = [value for value in stored if value["configuration_hash"] == self.hash]
        self.status = 0
        self.tools = {k: v for value in self.stored for k, v in value.get("tools", {}).items()}
        self.built: tuple[Path, Path] | None = None

    def build(self) -> tuple[Path, Path]:
        """`config.json` and the library of the RTL."""
        if self.built is None:
            dram = self.arguments.bench.mem == "dram"
            self.built = compare.build_engine(self.arguments, "", dram)
        return self.built

    def command(self, script: str, *words) -> None:
        """Run a script of the project; its sentence is raised when it cannot measure."""
        command = [sys.executable, str(Path(__file__).with_name(script)), *map(str, words)]
        sys.stdout.flush()
        done = subprocess.run(command, stderr=subprocess.PIPE, text=True)
        sys.stderr.write(done.stderr)
        if done.returncode not in (0, 1):
            said = done.stderr.strip().splitlines() or [f"{script} ended with {done.returncode}"]
            raise MeritError(said[-1])
        self.status |= done.returncode

    def units(self, name: str, script: str, *words) -> dict[str, dict]:
        """What a script measures of units."""
        file = self.out / name
        self.command(script, self.build()[0].parent, *words, "--json", file)
        value = json.loads(file.read_text())
        self.tools |= value["tools"]
        return value["units"]

    def areas(self) -> dict[str, dict]:
        """Area of the engine by part."""
        parts, found = self.arguments.part, {}
        for value in self.stored:
            if "part" not in value and "units" in value:
                found |= value["units"].get(ENGINE, {})
        missing = [part for part in parts if part not in found]
        if missing:
            found |= self.units("area.json", "area.py", "--part", *missing)[ENGINE]
        return found

    def cell(self) -> dict:
        """Cycles on the scene."""
        scene = self.arguments.scene
        wanted = (bench.sha256(scene), "primary")
        for value in self.stored:
            cells = value.get("cells", ())
            pairs = [(s, kind) for s in value.get("scene_sha256", ()) for kind in value["rays"]]
            for pair, cell in zip(pairs, cells, strict=False):  # it may have been stopped
                if pair == wanted:
                    return cell
        config, library = self.build()
        words = [*self.arguments.words, "--scene", scene, "--out", self.out / "bench"]
        self.command("bench.py", "--config", config, "--library", library, *words)
        return json.loads((self.out / "bench/bench.json").read_text())["cells"][0]

    def clock(self, part: str, cells: dict[str, float]) -> dict:
        """The clock on a part, or why there is none."""
        device = DEVICES.get(part)
        why = misfit(part, cells)
        if device is None:
            return {"why": "no open tool times it"}
        timed, timed_on = {}, {}
        for value in self.stored:
            if value.get("part", "").startswith(device):
                timed |= value["units"]
                timed_on = {"timed_on": value["part"]}  # with the speed grade
        if not timed:
            units = self.arguments.unit or ([] if why else [ENGINE])
            if not units:
                return {"why": why}
            words = ["--part", device, "--seeds", self.arguments.seeds, "--unit", *units]
            try:
                timed = self.units(f"fmax-{part}.json", "fmax.py", *words)
            except MeritError as error:
                return {"why": f"not measured: {error}"}
        return clock_of(timed) | timed_on | ({"why": why} if why else {})

    def rows(self):
        """A row for each part, as they come."""
        cell, areas = self.cell(), self.areas()
        for part in self.arguments.part:
            cells = cells_of(areas[part])
            clock = self.clock(part, cells)
            yield with_merit(
                {
                    "configuration": self.name,
                    "configuration_hash": self.hash,
                    "part": part,
                    **cells,
                    "clock": clock,
                    "mhz": clock.get("mhz"),
                    "scene": cell["scene"],
                    "rays": cell["rays"],
                    "cycles": cell["cycles"],
                    "cycles_per_ray": cell["cycles"] / cell["rays"],
                    "memory": cell["mem"],
                    "good": cell["good"],
                }
            )


def parse_arguments(words: list[str]) -> argparse.Namespace:
    """The words of the command, checked before anything is measured."""
    parser = bench.Parser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", nargs="+", required=True, help="names or files")
    parser.add_argument("--part", nargs="+", required=True, help=", ".join(area.PARTS))
    parser.add_argument("--scene", type=Path, required=True)
    parser.add_argument("--set", default="", help="overrides that all configurations have")
    parser.add_argument("--cores", default="", help="cores of all configurations")
    parser.add_argument("--unit", nargs="*", default=[], help="time these in place of the engine")
    parser.add_argument("--seeds", type=int, default=3, help="runs of nextpnr")
    parser.add_argument("--file", type=Path, nargs="*", default=[], help="what was measured before")
    parser.add_argument("--out", type=Path, required=True, help="folder of the table")
    arguments, given = parser.parse_known_args(words)
    for part in arguments.part:
        if part not in area.PARTS:
            raise MeritError(f"PART={part}: no such part; there are {', '.join(area.PARTS)}")
    if not arguments.scene.is_file():
        raise MeritError(f"SCENE={arguments.scene}: there is no such file or scene of the project")
    exists = {file.stem for file in (area.ROOT / "rtl").rglob("*.sv")}
    for unit in arguments.unit:
        if unit not in exists:
            raise MeritError(f"UNIT={unit}: there is no such module")
    arguments.words = [*SAMPLE, *given]
    arguments.bench = compare.bench_words([*arguments.words, "--scene", str(arguments.scene)])
    return arguments


def run(words: list[str]) -> int:
    arguments = parse_arguments(words)
    stored = taken(arguments.file)
    machines = [Machine(name, arguments, stored) for name in arguments.config]
    for value in stored:
        if value["configuration_hash"] not in [machine.hash for machine in machines]:
            raise MeritError(f"FILE={value['file']}: it is of another configuration than CONFIG=")
    rows: list[dict] = []
    for machine in machines:
        print(f"\n{machine.name}", flush=True)
        for row in machine.rows():
            rows.append(row)
            write(arguments.out, {"tools": [machine.tools for machine in machines]}, rows)
    print(f"\n{(arguments.out / 'merit.md').read_text()}")
    good = all(row["good"] for row in rows)
    return max(0 if good else 1, *(machine.status for machine in machines))


if __name__ == "__main__":
    sys.exit(bench.status_of("merit", run, MeritError, compare.CompareError, ConfigError))
