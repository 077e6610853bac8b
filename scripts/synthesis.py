# SPDX-License-Identifier: Apache-2.0
"""How Yosys reads a module of a configuration, and what results of it have in common.

`scripts/synth_check.py`, `scripts/area.py` and `scripts/fmax.py` share this: the parameters that a
module has in the engine, one run of Yosys with its log, names of registers in a netlist, and JSON
with the versions of the tools and the configuration that it is about.
"""

import hashlib
import json
import os
import re
import subprocess
import sys
from collections import Counter
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

FORMAT = {"ExpBits": "exp_bits", "FracBits": "frac_bits"}
OPERATORS = ("ti_fp_add", "ti_fp_mul", "ti_fp_cmp", "ti_fp_rcp")


def cached(unit: str) -> dict[str, str]:
    """Parameters of a unit with slots and an L1, and their keys in the configuration."""
    return {
        "NumSlots": f"{unit}_slots",
        "Rows": f"{unit}_rows",
        "CacheBytes": f"{unit}_l1_bytes",
        "Ways": f"{unit}_l1_ways",
    }


STACK = {"StackDepth": "stack_depth", "Restart": "restart"}
STEPS = {**STACK, "WatchdogSteps": "watchdog_steps"}
ANY_HIT = {"AnyHit": "any_hit"}
# What `ti_engine` sets on its units; other modules are read with their defaults.
PARAMETERS = {
    **dict.fromkeys(OPERATORS, FORMAT),
    "ti_rd": {"NumTrv": "num_trv", "DealTile": "deal_tile", "RayCycles": "rd_cycles", **ANY_HIT},
    "ti_rd_clip": {"RayCycles": "rd_cycles", **ANY_HIT},
    "ti_trv": {**cached("trv"), **STEPS, **ANY_HIT},
    "ti_kd_decide": STEPS,
    "ti_trv_best": {"NumSlots": "trv_slots"},
    "ti_trv_retire": {"NumSlots": "trv_slots", **ANY_HIT},
    "ti_trv_return": {"NumSlots": "trv_slots", "Restart": "restart", **ANY_HIT},
    "ti_kd_state": {"NumSlots": "trv_slots", **STACK},
    "ti_ra": cached("ist1"),
    "ti_l1": {"CacheBytes": "ist1_l1_bytes", "Ways": "ist1_l1_ways"},
    "ti_l2_bank": {
        "NumUnits": "num_trv",
        "UnitIds": "trv_rows",
        "NumBanks": "trv_l2_banks",
        "Ways": "trv_l2_ways",
    },
    "ti_list": cached("list"),
    "ti_ist1": cached("ist1"),
}
UNITS = ("ti_rd", "ti_trv", "ti_list", "ti_ist1", "ti_ist2", *OPERATORS)

LIBERTY = Path("/usr/share/qflow/tech/osu018/osu018_stdcells.lib")
NAND2_UM2 = 24.0  # area of NAND2X1 there, one gate equivalent
# Wrappers of memories; what is in them is marked with the wrapper's name and can be cut out.  Paths
# that end at one end at new outputs.
RAM, FILE = "ti_ram_1r1w", "ti_regfile"
FILE_WORDS, FILE_BITS = 16, 32  # a register file with fewer words or bits a word is not cut out


def _cut(memories: str) -> tuple[str, ...]:
    return (
        f"select -set cut t:$mem_v2 {memories}",
        "expose @cut %ci:+[RD_ADDR,RD_EN,WR_ADDR,WR_DATA,WR_EN] w:* %i",
        "delete @cut",
        "setundef -undriven -expose",
    )


CUT_RAMS = _cut(f"a:{RAM} %i r:RD_CLK_ENABLE=1'1 %i")
CUT_FILES = _cut(f"a:{FILE} %i r:SIZE>={FILE_WORDS} %i r:WIDTH>={FILE_BITS} %i")

YOSYS = (
    "import sys; from pyosys import libyosys as y; d = y.Design(); "
    "[y.run_pass(c, d) for c in sys.argv[1:]]"
)


class MeasureError(Exception):
    """One sentence: what could not be measured and where to look."""


class Synthesis:
    """Yosys runs on one configuration."""

    def __init__(self, folder: Path, rtl: Path, work: str = "synth"):
        if not (folder / "config.json").is_file():
            raise MeasureError(f"{folder} has no config.json; scripts/configure.py writes it")
        self.config = json.loads((folder / "config.json").read_text())
        self.packages = [folder / "ti_config_pkg.sv", folder / "ti_count_pkg.sv"]
        self.rtl = rtl
        self.work = folder / work
        self.work.mkdir(parents=True, exist_ok=True)

    def known(self, module: str) -> None:
        """Raises for a module that the RTL does not have."""
        if not any(self.rtl.rglob(f"{module}.sv")):
            raise MeasureError(f"{module}: there is no such module in {self.rtl}")

    def parameters(self, module: str) -> dict[str, int]:
        """What the configuration sets on a module that is read alone."""
        return {n: int(self.config[key]) for n, key in PARAMETERS.get(module, {}).items()}

    def read(self, module: str, *options: str) -> str:
        """Yosys command that elaborates a module of the configuration."""
        sources, options = [*self.packages], [*options, "-DSYNTHESIS", f"--top {module}"]
        options.append(f"-I{self.packages[0].parent}")
        for word in (self.rtl / "ti.f").read_text().split():
            if word.startswith("+incdir+"):
                options.append(f"-I{self.rtl.parent / word.removeprefix('+incdir+')}")
            else:
                sources.append(self.rtl.parent / word)
        options += [f"-G {name}={value}" for name, value in self.parameters(module).items()]
        return " ".join(["read_slang", *options, *map(str, sources)])

    def marked(self, module: str) -> list[str]:
        """Commands that read a module with its hierarchy and mark the memories of wrappers."""
        marks = [f"setattr -set {wrapper} 1 {wrapper}*/m:*" for wrapper in (RAM, FILE)]
        return [self.read(module, "--keep-hierarchy"), *marks]

    def run(self, name: str, *commands: str) -> tuple[bool, str]:
        """Whether Yosys took all commands, and its output, which stays in `work`."""
        log = self.work / f"{name}.log"
        with log.open("w") as out:
            done = subprocess.run(
                [sys.executable, "-c", YOSYS, *commands],
                stdout=out,
                stderr=subprocess.STDOUT,
                check=False,
            )
        text = log.read_text(errors="replace")
        # An error ends the interpreter; its status says so only in some versions.
        return done.returncode == 0 and not re.search(r"^ERROR:", text, re.MULTILINE), text

    def result(self, name: str, file: str, *commands: str) -> dict:
        """The JSON that the last of the commands writes to `file` in `work`, there `{out}`."""
        path = self.work / file
        path.unlink(missing_ok=True)
        good, _ = self.run(name, *(c.replace("{out}", str(path)) for c in commands))
        if not good or not path.is_file():
            raise MeasureError(f"{name}: Yosys stopped; see {self.work / name}.log")
        return json.loads(path.read_text())


def memory_rows(modules: dict, counts: dict[str, int] | None = None) -> list[dict]:
    """Memories in a JSON netlist with `$mem_v2` cells, largest first.

    A row has the name without indices, words, bits a word, ports, whether the read is clocked, the
    wrapper that it is marked with, if any, and how many there are; `counts` says how often a module
    stands in the design, where not once.
    """
    found = Counter()
    for module, part in modules.items():
        for name, cell in part["cells"].items():
            if cell["type"] != "$mem_v2":
                continue
            value = {k: int(v, 2) for k, v in cell["parameters"].items() if set(v) <= {*"01"}}
            ports = (value["RD_PORTS"], value["WR_PORTS"])
            clocked = cell["parameters"]["RD_CLK_ENABLE"].count("1") == ports[0] > 0
            key = (re.sub(r"\[\d+\]", "", name), value["SIZE"], value["WIDTH"], *ports)
            key += (clocked, next((w for w in (RAM, FILE) if w in cell["attributes"]), None))
            found[key] += 1 if counts is None else counts[module]
    keys = ("name", "words", "bits", "read_ports", "write_ports", "clocked_read", "wrapper")
    keys += ("count",)
    rows = [dict(zip(keys, (*key, count), strict=True)) for key, count in found.items()]
    return sorted(rows, key=lambda r: (-r["words"] * r["bits"] * r["count"], r["name"]))


def rams(rows: list[dict]) -> list[dict]:
    """Those of the RAM wrapper that Yosys sees as RAM, with a clocked read."""
    return [row for row in rows if row["wrapper"] == RAM and row["clocked_read"]]


def register_files(rows: list[dict]) -> list[dict]:
    """Those of the wrapper of register files that are large enough to be a macro."""
    return [
        row
        for row in rows
        if row["wrapper"] == FILE and row["words"] >= FILE_WORDS and row["bits"] >= FILE_BITS
    ]


def memory_bits(rows: list[dict]) -> int:
    """Bits of memories."""
    return sum(r["words"] * r["bits"] * r["count"] for r in rows)


def configuration_hash(config: dict) -> str:
    """Changes with any key of a configuration."""
    return hashlib.sha256(json.dumps(config, sort_keys=True).encode()).hexdigest()[:16]


def heading(config: dict, *packages: str) -> dict:
    """What every result begins with: versions of the tools, and the configuration."""
    return {
        "tools": {name: metadata.version(name) for name in ("pyosys", *packages)},
        "configuration": config["name"],
        "configuration_hash": configuration_hash(config),
        "config": config,
    }


def write_json(path: Path, value: dict) -> None:
    """Whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(f".{os.getpid()}.part")
    try:
        part.write_text(json.dumps(value, indent=2) + "\n")
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
