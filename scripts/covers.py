# SPDX-License-Identifier: Apache-2.0
"""Table of the cover properties of the RTL and how often the unit tests of a build reached them.

Every simulation of a unit test leaves a `coverage.dat`.  A cover counts for its module, whatever
the instance.  The last line names those that no test reached.

Usage: scripts/covers.py FOLDER
"""

import re
import sys
from collections import Counter
from pathlib import Path

FIELD = re.compile("\x01(\\w+)\x02([^\x01']*)")


def covers(folder: Path) -> Counter:
    """{(module, cover): how often it was reached} over all files below `folder`."""
    reached = Counter()
    for file in folder.rglob("coverage.dat"):
        for line in file.read_text(errors="replace").splitlines():
            point, _, count = line.rpartition(" ")
            fields = dict(FIELD.findall(point))
            if fields.get("page", "").startswith("v_user"):
                reached[Path(fields["f"]).stem, fields["o"]] += int(count)
    return reached


def main() -> int:
    reached = covers(Path(sys.argv[1]))
    for (module, name), count in sorted(reached.items()):
        print(f"{module:18} {name:28} {count:>12}")
    missed = [f"{module}.{name}" for (module, name), count in sorted(reached.items()) if not count]
    print(f"{len(reached) - len(missed)} of {len(reached)} covers reached", end="")
    print(f"; not: {', '.join(missed)}" if missed else "")
    return 0


if __name__ == "__main__":
    sys.exit(main())
