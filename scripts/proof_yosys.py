#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Yosys as SymbiYosys calls it: `proof_yosys.py -ql LOG SCRIPT` runs a script of commands.

The package pyosys has Yosys as a library alone.  Exit status: 0, or 1 when a command failed.
"""

import sys

from pyosys import libyosys


def main() -> int:
    if len(sys.argv) != 4 or sys.argv[1] != "-ql":
        print(__doc__.splitlines()[0], file=sys.stderr)
        return 2
    libyosys.Design().run_pass(f"tee -q -o {sys.argv[2]} script {sys.argv[3]}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
