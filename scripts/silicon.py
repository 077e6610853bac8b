# SPDX-License-Identifier: Apache-2.0
"""Area in standard cells and SRAM: gate equivalents, um2 of sky130 cells, mm2 at 65 nm.

Every factor is in `factors()` and goes into the JSON.  docs/synthesis.md says where each is from,
and how far such an estimate can be off.
"""

import json
import re
import subprocess
from pathlib import Path

from operators import PAPER_KB, PAPER_MM2
from synthesis import LIBERTY, NAND2_UM2, ROOT, MeasureError, memory_bits, rams

LIBRARIES = {"osu018": "OSU cells, 0.18 um rules", "sky130": "sky130_fd_sc_hd, 130 nm"}
GATE_UM2_65 = 1.44  # NAND2 of a common 65 nm library of 9 tracks
UTILISATION = 0.75  # share of the placed area that is cells
SKY130 = ROOT / "build/sky130/sky130/src/sky130_fd_sc_hd/cells"
CACTI = ROOT / "build/cacti/hwcomponents_cacti/cacti"
LEAST_BYTES, LEAST_WORDS = 512, 16  # of a memory that CACTI can lay out
PAPER_WIRING_MM2 = 4.95  # of the published core
ABC_SIZED = (
    "strash; ifraig; scorr; dc2; dch -f; map -B 0.9 -D 4000; topo; "
    "buffer -c; upsize; dnsize; stime -p"
)
# Cells of sky130 that are mapped to, with functions as their Verilog models have them; size 1.
SKY130_CELLS = {
    "inv": "Y=!A",
    "nand2": "Y=!(A&B)",
    "nand3": "Y=!(A&B&C)",
    "nand4": "Y=!(A&B&C&D)",
    "nor2": "Y=!(A|B)",
    "nor3": "Y=!(A|B|C)",
    "and2": "X=A&B",
    "and3": "X=A&B&C",
    "or2": "X=A|B",
    "or3": "X=A|B|C",
    "xor2": "X=A^B",
    "xnor2": "Y=!(A^B)",
    "a21oi": "Y=!((A1&A2)|B1)",
    "a22oi": "Y=!((A1&A2)|(B1&B2))",
    "a21o": "X=(A1&A2)|B1",
    "o21ai": "Y=!((A1|A2)&B1)",
    "o22a": "X=(A1|A2)&(B1|B2)",
    "o21a": "X=(A1|A2)&B1",
    "mux2": "X=(A0&!S)|(A1&S)",
    "maj3": "X=(A&B)|(A&C)|(B&C)",
    "buf": "X=A",
}
SKY130_FLOP = "dfxtp"  # CLK, D, Q; the only flop, others are made of it and gates
SKY130_FLOP_RESET, SKY130_FLOP_SET = "dfrtp", "dfstp"


def factors() -> dict:
    """Numbers that an area is made of, with their meaning."""
    return {
        "nand2_um2_osu018": NAND2_UM2,
        "nand2_um2_65nm": GATE_UM2_65,
        "utilisation": UTILISATION,
        "sram": "CACTI 7, 65 nm, itrs-hp, one read and one write port, ram",
        "sram_least_bytes": LEAST_BYTES,
        "sram_least_words": LEAST_WORDS,
        "published_core_mm2": PAPER_MM2["core"],
        "published_wiring_mm2": PAPER_WIRING_MM2,
    }


def available(part: str) -> None:
    """Raises when what a part needs is not installed."""
    if part == "osu018" and not LIBERTY.is_file():
        raise MeasureError(f"{LIBERTY} is missing; 'scripts/setup.sh --extra' installs it")
    if part == "osu018" and not (CACTI / "cacti").is_file():
        raise MeasureError("CACTI is missing; 'scripts/setup.sh --cacti' builds it")
    if part == "sky130" and not SKY130.is_dir():
        raise MeasureError("the cells of sky130 are missing; 'scripts/setup.sh --sky130' does that")


def library(part: str, work: Path) -> tuple[Path, list[str]]:
    """The liberty of a part, and the commands that map to it."""
    script = work / f"{part}.abc"
    if part == "sky130":
        liberty = work / "sky130.lib"
        liberty.write_text(sky130_liberty())
        return liberty, [f"dfflibmap -liberty {liberty}", f"abc -liberty {liberty}"]
    script.write_text(ABC_SIZED + "\n")
    return LIBERTY, [
        f"dfflibmap -liberty {LIBERTY}",
        f"abc -liberty {LIBERTY} -script {script}",
    ]


def lef_um2(cell: str) -> float:
    """Area of a sky130 cell of size 1, out of its LEF."""
    name = f"sky130_fd_sc_hd__{cell}_1"
    lef = (SKY130 / cell / f"{name}.lef").read_text()
    width, height = re.search(r"^ *SIZE +([\d.]+) +BY +([\d.]+)", lef, re.MULTILINE).groups()
    return float(width) * float(height)


def sky130_liberty() -> str:
    """Areas and functions alone: enough to map, not to time."""
    text = ["library(sky130_area) {"]
    for cell, function in SKY130_CELLS.items():
        output, _, expression = function.partition("=")
        inputs = sorted(set(re.findall(r"[A-Z]\d?", expression)))
        pins = " ".join(f"pin({i}) {{ direction: input; }}" for i in inputs)
        text.append(
            f"  cell({cell}) {{ area: {lef_um2(cell):.4f}; {pins} "
            f'pin({output}) {{ direction: output; function: "{expression}"; }} }}'
        )
    for cell, more in [
        (SKY130_FLOP, ""),
        (SKY130_FLOP_RESET, 'clear: "!RESET_B";'),
        (SKY130_FLOP_SET, 'preset: "!SET_B";'),
    ]:
        pin = re.search(r"(\w+)_B", more)
        extra = f"pin({pin[1]}_B) {{ direction: input; }}" if pin else ""
        text.append(
            f"  cell({cell}) {{ area: {lef_um2(cell):.4f}; "
            f'ff("IQ","IQN") {{ clocked_on: "CLK"; next_state: "D"; {more} }} '
            f"pin(CLK) {{ direction: input; clock: true; }} pin(D) {{ direction: input; }} {extra} "
            f'pin(Q) {{ direction: output; function: "IQ"; }} }}'
        )
    return "\n".join([*text, "}"]) + "\n"


def columns(part: str, stat: dict) -> dict[str, float]:
    """Columns of a module from what `stat -json -liberty` says of it."""
    flops = sum(
        count
        for name, count in stat["num_cells_by_type"].items()
        if re.match(r"(DFF|LATCH|df)", name)
    )
    area = stat["area"]
    if part == "osu018":
        return {"gate_equivalents": round(area / NAND2_UM2, 1), "FF": flops}
    return {"um2": round(area, 1), "FF": flops}


def sram_mm2(words: int, bits: int, kept: dict) -> float:
    """mm2 of one memory with a read and a write port at 65 nm, by CACTI.

    CACTI lays out whole bytes and nothing small: a smaller memory has its share of the bits of the
    least one of as wide a word.
    """
    width = -(-bits // 8)
    rows = max(words, LEAST_WORDS, -(-LEAST_BYTES // width))
    rows = 1 << (rows - 1).bit_length()
    if (width, rows) not in kept:
        kept[(width, rows)] = cacti(width, rows)
    return kept[(width, rows)] * (words * bits) / (rows * width * 8)


def cacti(width: int, rows: int) -> float:
    """mm2 of a memory of `rows` words of `width` bytes."""
    words = {
        "size (bytes)": width * rows,
        "block size (bytes)": width,
        "associativity": 1,
        "read-write port": 0,
        "exclusive read port": 1,
        "exclusive write port": 1,
        "technology (u)": 0.065,
        "output/input bus width": 8 * width,
        "cache type": '"ram"',
        "design objective (weight delay, dynamic power, leakage power, cycle time, area)": (
            "0:0:0:0:100"
        ),
        "deviate (delay, dynamic power, leakage power, cycle time, area)": (
            "100:100000:100000:100:20"
        ),
        "Add ECC -": '"false"',
    }
    lines = [
        line
        for line in (CACTI / "cache.cfg").read_text().splitlines()
        if not any(line.startswith(f"-{name} ") for name in words)
    ]
    lines += [f"-{name} {value}" for name, value in words.items()]
    config = CACTI / f"{width}x{rows}.cfg"
    config.write_text("\n".join(lines) + "\n")
    done = subprocess.run(
        [CACTI / "cacti", "-infile", config.name],
        cwd=CACTI,
        capture_output=True,
        text=True,
        check=False,
    )
    size = re.search(r"Cache height x width \(mm\): +([\d.]+) x ([\d.]+)", done.stdout)
    if not size:
        raise MeasureError(f"CACTI gives no area for {rows} words of {width} bytes: {config}")
    return float(size[1]) * float(size[2])


def at_65_nm(result: dict, memories: list[dict]) -> dict:
    """mm2 of logic and SRAM."""
    kept: dict = {}
    rows = rams(memories)
    sram = sum(sram_mm2(r["words"], r["bits"], kept) * r["count"] for r in rows)
    cells = result["gate_equivalents"] * GATE_UM2_65 / 1e6
    return {
        "cells_mm2": cells,
        "logic_mm2": cells / UTILISATION,
        "sram_mm2": sram,
        "sram_kb": memory_bits(rows) / 8192,
        "mm2_65nm": cells / UTILISATION + sram,
        "sram_macros": {f"{w} B x {n}": mm2 for (w, n), mm2 in sorted(kept.items())},
    }


def print_65_nm(result: dict, top: str) -> None:
    """Area at 65 nm with its factors; of an engine beside the published core."""
    print(
        f"\n65 nm: {result['gate_equivalents']:,.0f} gates x {GATE_UM2_65} um2 / {UTILISATION} = "
        f"{result['logic_mm2']:.4f} mm2 of logic; {result['sram_kb']:.1f} KB of SRAM = "
        f"{result['sram_mm2']:.4f} mm2 by CACTI; {result['mm2_65nm']:.4f} mm2 in all"
    )
    if top != "ti_engine":
        return
    wired = PAPER_MM2["core"]
    memory = ", ".join(f"{kb} KB {name}" for name, kb in PAPER_KB.items())
    print(
        f"published core at 65 nm: {wired} mm2, wiring {PAPER_WIRING_MM2} of it, "
        f"{wired - PAPER_WIRING_MM2:.2f} without; {memory}; "
        + ", ".join(f"{name} {PAPER_MM2[name]}" for name in ("ADD", "MUL", "RCP", "CMP"))
        + " mm2 an operator"
    )


def published_operators(each: dict[str, float]) -> str:
    """Ours beside the published operator; `each` has gate equivalents by heading."""
    return json.dumps(
        {name: [gates * GATE_UM2_65 / 1e6, PAPER_MM2[name]] for name, gates in each.items()}
    )
