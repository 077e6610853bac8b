# SPDX-License-Identifier: Apache-2.0
"""What a machine of a sweep of accuracy costs: operators, cells, latency, bytes.

Cells of the operators (ECP5, scripts/area.py) are kept in build/accuracy/cells, in a file
named after what they depend on: the keys of the number format and its operators, and the RTL.
"""

import hashlib
import json
import subprocess
from pathlib import Path

import configure

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / "build/venv/bin/python"  # has what the other scripts ask for
OPERATORS = {"ADD": "ti_fp_add", "MUL": "ti_fp_mul", "RCP": "ti_fp_rcp", "CMP": "ti_fp_cmp"}
CELLS = {"lut": "LUT", "ff": "FF", "dsp": "DSP"}  # columns of `make area`
FORMAT_KEYS = ("exp_bits", "frac_bits", "rounding", "subnormals", "reciprocal")
NODE_BYTES = 8


class AccuracyError(Exception):
    """One sentence for the user."""


def run(words: list, what: str) -> str:
    """What a program prints; its last words when it fails."""
    done = subprocess.run([str(w) for w in words], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise AccuracyError(f"{what}: {said[-1] if said else f'status {done.returncode}'}")
    return done.stdout


def latencies(keys: dict) -> dict[str, int]:
    """Cycles from a node to the next, and from a record to the verdict and to the hit."""
    add, mul, cmp = (keys[f"fp_{name}_stages"] for name in ("add", "mul", "cmp"))
    rcp = configure.reciprocal_stages(keys)
    if keys["triangle_test"] == "woop":
        passes, last = 3 * add + 2 * mul + 2, 3 * mul + 2 * add + rcp + 2
    else:
        one = (5 if keys["triangle_test"] == "np" else 4) * add + 3 * mul + cmp + 2
        passes, last = 2 * one, rcp + mul + 1
    return {"step": 2 + add + mul + cmp, "test": passes, "hit": passes + last}


def triangle_bytes(keys: dict) -> int:
    if keys["triangle_test"] != "woop":
        return 48
    return 32 if 9 * (1 + keys["exp_bits"] + keys["frac_bits"]) + 32 <= 256 else 64


def digest_of_rtl() -> str:
    """Changes with every file that the cells of an operator may depend on."""
    digest = hashlib.sha256()
    files = [*(ROOT / "rtl").rglob("*.sv"), *(ROOT / "rtl").rglob("*.svh")]
    counting = [ROOT / "scripts" / f"{name}.py" for name in ("area", "cells", "synthesis")]
    for file in [*sorted(files), *counting, ROOT / "requirements.txt"]:
        digest.update(f"{file.relative_to(ROOT)}\n".encode() + file.read_bytes())
    return digest.hexdigest()


class Costs:
    """Operators and cells of machines, each counted once."""

    def __init__(self, folder: Path, cells: Path = ROOT / "build/accuracy/cells"):
        self._folder = folder
        self._store = cells
        self._rtl = digest_of_rtl()
        self._cells: dict[str, dict] = {}
        self._operators: dict[tuple[str, str], dict] = {}

    def of(self, machine: configure.Configuration, folder: Path) -> dict:
        """The costs of a machine whose files are in `folder`."""
        keys = machine.values
        cells = self._cells_of(keys, folder)
        operators = self._operators_of(keys, folder)
        sums = {c: sum(operators[o] * cells[o][c] for o in OPERATORS) for c in CELLS}
        return {
            "operators": operators,
            **{f"operator_{c}": total for c, total in sums.items()},
            "latency": latencies(keys),
            "bytes": {"node": NODE_BYTES, "triangle": triangle_bytes(keys)},
        }

    def file_of(self, keys: dict) -> Path:
        """Where the cells of the operators of a machine are kept."""
        chosen = {
            k: v for k, v in keys.items() if k in FORMAT_KEYS or k.startswith(("fp_", "rcp_"))
        }
        text = json.dumps([self._rtl, chosen], sort_keys=True)
        name = hashlib.sha256(text.encode()).hexdigest()[:16]
        return self._store / f"{keys['exp_bits']}-{keys['frac_bits']}-{name}.json"

    def _cells_of(self, keys: dict, folder: Path) -> dict:
        file = self.file_of(keys)
        if file.name not in self._cells:
            if not file.exists():
                found = self._synthesize(folder)
                file.parent.mkdir(parents=True, exist_ok=True)
                part = file.with_suffix(".part")
                part.write_text(json.dumps(found, indent=1) + "\n")
                part.replace(file)
            self._cells[file.name] = json.loads(file.read_text())
        return self._cells[file.name]

    def _synthesize(self, folder: Path) -> dict:
        out = self._folder / "cells.json"
        words = [VENV, "scripts/area.py", folder, "--part", "ecp5", "--json", out]
        run([*words, "--unit", *OPERATORS.values()], "area")
        units = json.loads(out.read_text())["units"]
        out.unlink()
        return {
            name: {c: units[module]["ecp5"][column] for c, column in CELLS.items()}
            for name, module in OPERATORS.items()
        }

    def _operators_of(self, keys: dict, folder: Path) -> dict:
        kind = keys["triangle_test"], keys["traversal"]
        if kind not in self._operators:
            out = self._folder / "operators.json"
            run([VENV, "scripts/operators.py", folder, "--json", out], "operators")
            self._operators[kind] = json.loads(out.read_text())["total"]["operators"]
            out.unlink()
        return self._operators[kind]
