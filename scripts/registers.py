# SPDX-License-Identifier: Apache-2.0
"""What `rtl/host/ti_regs.rdl` becomes: the register block, a C header, a Python model, a page.

PeakRDL writes the block with its package (AXI4-Lite, flat ports), the C header and the page; the
Python model, offsets and fields by name, is written here.  All are kept in the tree.

Usage: scripts/registers.py [--root DIR]     DIR has the source and gets the files; this project
"""

import argparse
import sys
import tempfile
from pathlib import Path

from peakrdl_cheader.exporter import CHeaderExporter
from peakrdl_markdown import MarkdownExporter
from peakrdl_regblock import RegblockExporter
from peakrdl_regblock.cpuif.axi4lite import AXI4Lite_Cpuif_flattened
from peakrdl_regblock.udps import ALL_UDPS
from systemrdl import RDLCompileError, RDLCompiler
from systemrdl.node import AddrmapNode

ROOT = Path(__file__).resolve().parents[1]
SOURCE = "rtl/host/ti_regs.rdl"
LICENCE = "SPDX-License-Identifier: Apache-2.0"


def compiled(source: Path) -> AddrmapNode:
    """The register map of a file."""
    compiler = RDLCompiler()
    for definition in ALL_UDPS:
        compiler.register_udp(definition, soft=False)
    compiler.compile_file(str(source))
    return compiler.elaborate().top


def files(source: Path) -> dict[str, str]:
    """Place in the tree and text of all that is made."""
    top = compiled(source)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # A synchronous reset fits both kinds of reset of a configuration (ti_reset.svh).
        RegblockExporter().export(
            top,
            str(folder),
            cpuif_cls=AXI4Lite_Cpuif_flattened,
            default_reset_activelow=True,
            err_if_bad_addr=True,
            reuse_hwif_typedefs=False,
        )
        CHeaderExporter().export(top, str(folder / "ti_regs.h"), reuse_typedefs=False)
        MarkdownExporter().export(top, str(folder / "registers.md"))
        text = {path.name: path.read_text() for path in folder.iterdir()}
    return {
        "rtl/host/ti_regs.sv": f"// {LICENCE}\n{text['ti_regs.sv']}",
        "rtl/host/ti_regs_pkg.sv": f"// {LICENCE}\n{text['ti_regs_pkg.sv']}",
        "sw/host/ti_regs.h": f"// {LICENCE}\n{text['ti_regs.h']}",
        "sw/host/ti_regs.py": python(top),
        "docs/registers.md": text["registers.md"],
    }


def python(top: AddrmapNode) -> str:
    """Registers by name: `REGISTERS["CONTROL"].fields["flush"].mask`."""
    lines = [
        f"# {LICENCE}",
        f'"""The registers of `ti_top`, written by scripts/registers.py from {SOURCE}."""',
        "",
        "from typing import NamedTuple",
        "",
        "",
        "class Field(NamedTuple):",
        "    low: int",
        "    width: int",
        "    reset: int | None",
        "",
        "    @property",
        "    def mask(self) -> int:",
        "        return (1 << self.width) - 1 << self.low",
        "",
        "    def of(self, word: int) -> int:",
        '        """The value of the field in a word of its register."""',
        "        return (word & self.mask) >> self.low",
        "",
        "",
        "class Register(NamedTuple):",
        "    offset: int",
        "    fields: dict[str, Field]",
        "",
        "",
        "# fmt: off",
        "REGISTERS = {",
    ]
    for register in top.registers(unroll=True):
        name = register.get_path_segment().replace("[", "_").rstrip("]")
        lines.append(f'    "{name}": Register({register.address_offset:#04x}, {{')
        for field in register.fields():
            reset = field.get_property("reset")
            shown = reset if reset is None else f"{reset:#x}"
            place = f"Field({field.low}, {field.width}, {shown})"
            lines.append(f'        "{field.inst_name}": {place},')
        lines.append("    }),")
    return "\n".join([*lines, "}", ""])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=Path, default=ROOT, metavar="DIR")
    root = parser.parse_args().root
    try:
        made = files(root / SOURCE)
    except RDLCompileError as error:
        print(f"{root / SOURCE}: {error}", file=sys.stderr)
        return 2
    for place, text in made.items():
        (root / place).parent.mkdir(parents=True, exist_ok=True)
        (root / place).write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
