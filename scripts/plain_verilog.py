#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A block in Verilog-2001, for tools that do not read the SystemVerilog of this project.

Yosys elaborates the block by its slang front end and writes it with its hierarchy: registers,
memories and attributes for synthesis keep their names, so that constraints hold.  There is a module
for each instance.  `ti_top_wrapper_plain.v` and a list with it alone, `ti_top_wrapper_plain.f`,
go beside the block.

Exit status: 0, 2 when the block cannot be read.

Usage: scripts/plain_verilog.py DIR
DIR is the folder that scripts/wrapper.py wrote.
"""

import argparse
import sys
from pathlib import Path

from elaborated import TOP, elaborate
from synthesis import MeasureError

PLAIN = f"{TOP}_plain"


def write(folder: Path) -> None:
    """Write the block in `folder` as plain Verilog."""
    objects = "w:* c:* m:* A:*"
    elaborate(
        folder,
        "",
        # Enables of a memory become one for a word, as templates for RAM have it.
        "opt -full",
        "techmap t:$bwmux t:$bmux t:$demux",
        "opt_clean",
        "rename -enumerate -pattern made_% w:$*",
        f"setattr -unset src {objects}",
        f"setattr -unset hdlname {objects}",
        f"write_verilog {PLAIN}.v",
    )
    (folder / f"{PLAIN}.f").write_text(f"{PLAIN}.v\n")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, metavar="DIR", help="what scripts/wrapper.py wrote")
    try:
        write(parser.parse_args().folder)
    except (MeasureError, OSError) as error:
        print(f"plain_verilog: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
