# SPDX-License-Identifier: Apache-2.0
"""Area in standard cells and SRAM: gate equivalents, um2 of sky130 cells, mm2 at 65 nm.

Every factor is in `factors()` and goes into the JSON.  docs/synthesis.md says where each is from,
and how far such an estimate can be off.
"""

import re
import subprocess
from pathlib import Path

from operators import PAPER_KB, PAPER_MM2, REGISTER_FILES
from synthesis import (
    FILE_BITS,
    FILE_WORDS,
    LIBERTY,
    NAND2_UM2,
    ROOT,
    MeasureError,
    memory_bits,
    rams,
    register_files,
)

LIBRARIES = {"osu018": "OSU cells, 0.18 um rules", "sky130": "sky130_fd_sc_hd, 130 nm"}
GATE_UM2_65 = 1.44  # NAND2 of a common 65 nm library of 9 tracks
UTILISATION = 0.75  # share of the placed area that is cells
SKY130 = ROOT / "build/sky130/sky130/src/sky130_fd_sc_hd/cells"
CACTI = ROOT / "build/cacti/hwcomponents_cacti/cacti"
MACRO_BYTES = 8  # width of a macro of SRAM at most
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
        "sram": "CACTI 7 of hwcomponents-cacti 1.0.40, 65 nm, itrs-hp, 1 read and 1 write port",
        "sram_macro_bytes": MACRO_BYTES,
        "register_file_least_words": FILE_WORDS,
        "register_file_least_bits_a_word": FILE_BITS,
        "sky130": "LEF of sky130 0.15.3, sky130_fd_sc_hd, size 1",
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


def take_out_units(modules: dict[str, dict]) -> None:
    """Leaves a module the area of what is in none of its units: `stat` gives it theirs as well,
    and none at all to a module without cells, as counters that are not built."""
    whole = {name: stat.setdefault("area", 0.0) for name, stat in modules.items()}
    for stat in modules.values():
        for name, count in stat["num_cells_by_type"].items():
            stat["area"] -= count * whole.get(name, 0)


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

    The word is cut into macros of MACRO_BYTES and a narrower one, in whole bytes.  What CACTI finds
    too small counts as the next power of two of words that it can lay out.
    """
    wide, rest = divmod(-(-bits // 8), MACRO_BYTES)
    area = 0.0
    for width, count in ((MACRO_BYTES, wide), (rest, 1)):
        if not width or not count:
            continue
        if (width, words) not in kept:
            rows, found = words, cacti(width, words)
            while found is None and rows < 1 << 16:
                rows = 1 << rows.bit_length()
                found = cacti(width, rows)
            if found is None:
                raise MeasureError(f"CACTI gives no area for {words} words of {width} bytes")
            kept[(width, words)] = found
        area += count * kept[(width, words)]
    return area


def cacti(width: int, rows: int) -> float | None:
    """mm2 of a memory of `rows` words of `width` bytes, if CACTI can lay it out."""
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
    config.unlink()
    return float(size[1]) * float(size[2]) if size else None


def at_65_nm(result: dict, memories: list[dict]) -> dict:
    """mm2 of logic and of memories: lines of caches, other SRAM, register files."""
    kept: dict = {}
    mm2 = {"lines": 0.0, "others": 0.0, "files": 0.0}
    chosen = {"sram": rams(memories), "files": register_files(memories)}
    for kind, rows in chosen.items():
        for row in rows:
            lines = "lines" if row["name"].endswith("u_lines.mem_q") else "others"
            what = lines if kind == "sram" else kind
            mm2[what] += sram_mm2(row["words"], row["bits"], kept) * row["count"]
    cells = result["gate_equivalents"] * GATE_UM2_65 / 1e6
    return {
        "cells_mm2": cells,
        "logic_mm2": cells / UTILISATION,
        "sram_mm2": mm2["lines"] + mm2["others"],
        "sram_lines_mm2": mm2["lines"],
        "sram_kb": memory_bits(chosen["sram"]) / 8192,
        "files_mm2": mm2["files"],
        "files_kb": memory_bits(chosen["files"]) / 8192,
        "mm2_65nm": cells / UTILISATION + sum(mm2.values()),
        "sram_macros": {f"{w} B x {n}": area for (w, n), area in sorted(kept.items())},
    }


def print_65_nm(result: dict) -> None:
    """Area at 65 nm with its factors."""
    print(
        f"\n65 nm: {result['gate_equivalents']:,.0f} gates x {GATE_UM2_65} um2 / {UTILISATION} = "
        f"{result['logic_mm2']:.4f} mm2 of logic; by CACTI {result['sram_kb']:.1f} KB of SRAM = "
        f"{result['sram_mm2']:.4f} mm2, {result['files_kb']:.1f} KB of register files = "
        f"{result['files_mm2']:.4f} mm2; {result['mm2_65nm']:.4f} mm2 in all"
    )


def print_published(result: dict, gates: dict[str, float], bits: dict[str, int]) -> None:
    """An engine beside the published core: `gates` of an operator by heading, `bits` by store."""
    rows = [
        (f"one {name}, cells", gates[name] * GATE_UM2_65 / 1e6, PAPER_MM2[name])
        for name in ("ADD", "MUL", "RCP", "CMP")
    ]
    rows += [
        ("logic, placed", result["logic_mm2"], None),
        ("SRAM of cache lines", result["sram_lines_mm2"], None),
        ("other SRAM", result["sram_mm2"] - result["sram_lines_mm2"], None),
        ("register files", result["files_mm2"], None),
        ("all but wiring", result["mm2_65nm"], PAPER_MM2["core"] - PAPER_WIRING_MM2),
        ("wiring", None, PAPER_WIRING_MM2),
    ]
    files = sum(bits[store] for store in REGISTER_FILES)
    memory = [("L1", bits["l1_lines"]), ("L2", bits["l2_lines"]), ("register files", files)]

    def line(what, ours, theirs, digits):
        cells = ["-" if v is None else f"{v:.{digits}f}" for v in (ours, theirs)]
        print(f"{what:24}{cells[0]:>10}{cells[1]:>11}")

    print(f"\n{'mm2 at 65 nm':24}{'ours':>10}{'published':>11}")
    for what, ours, theirs in rows:
        line(what, ours, theirs, 5)
    print(f"\n{'KB':24}{'ours':>10}{'published':>11}")
    for what, number in memory:
        line(what, number / 8192, PAPER_KB[what], 1)
