#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""List the clock-domain crossings of a block: registers that look, through logic, at another clock.

Clocks outside of the engine are compared; that the engine has one is checked.

Exit status: 0, 2 when the block cannot be read.

Usage: scripts/crossings.py DIR
DIR is the folder that scripts/wrapper.py wrote.
"""

import argparse
import sys
from pathlib import Path

from elaborated import Block
from synthesis import MeasureError


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, metavar="DIR", help="what scripts/wrapper.py wrote")
    try:
        block = Block(parser.parse_args().folder)
        if block.clocks_of_engine() != {"clk_i"}:
            raise MeasureError(f"the engine has several clocks: {block.clocks_of_engine()}")
        crossings, clocks = block.crossings(), block.clocks()
    except (MeasureError, OSError) as error:
        print(f"crossings: {error}", file=sys.stderr)
        return 2
    for crossing in crossings:
        print(f"{crossing.start_clock} -> {crossing.end_clock}")
        print(f"  {crossing.start}\n    -> {crossing.end}")
    print(f"{len(crossings)} crossings between {len(clocks)} clocks: {', '.join(sorted(clocks))}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
