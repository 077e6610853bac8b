#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Make the project's own scenes.

Without arguments the small ones are written to `scenes/`, where they are kept in git; `--big DIR`
writes the large ones to DIR, or those that are named behind it. The same bytes come out on every
machine: computed coordinates are rounded to multiples of 2^-16.
"""

import argparse
import json
import os
from pathlib import Path

import numpy as np
from scenes.ply import ply_bytes

from scenes import closed, cornell, knot, pavilion, still_life, windmill

ROOT = Path(__file__).resolve().parent.parent
COMPACT = {"separators": (",", ":")}


def gltf(document):
    """The bytes of a glTF file."""
    return (json.dumps(document, **COMPACT) + "\n").encode()


# File of a large scene: what gives the description beside it (or None), and its bytes.
BIG = {
    "knot.ply": knot.files,
    "icosphere.ply": lambda: closed.files(closed.icosphere, [1.5, 1, 3]),
    "torus.ply": lambda: closed.files(closed.torus, [1.5, 1.5, 3.5]),
    "tube.ply": lambda: closed.files(closed.tube, [2, 3, 7]),
    "cornell_glass.gltf": lambda: (None, gltf(cornell.cornell_glass())),
    "pavilion.gltf": lambda: (pavilion.BESIDE, gltf(pavilion.pavilion())),
    "still_life.gltf": lambda: (still_life.BESIDE, gltf(still_life.still_life())),
    "windmill.gltf": lambda: (windmill.BESIDE, gltf(windmill.windmill())),
}


def write_json(path, value, **style):
    path.write_text(json.dumps(value, **style) + "\n")


def make_small(folder):
    """Write the scenes that are kept in git."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "cornell.gltf").write_bytes(gltf(cornell.cornell()))
    (folder / "one_triangle.obj").write_text(
        "# One triangle in the plane z = 0.\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n"
    )
    camera = {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y_deg": 40}
    write_json(folder / "one_triangle.json", {"camera": camera}, indent=1)
    nothing = np.empty((0, 3))
    (folder / "empty.ply").write_bytes(ply_bytes(nothing, nothing))
    write_json(folder / "empty.json", {"camera": camera}, indent=1)


def make_big(folder, file):
    """Write a large scene, and what stands beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    beside, data = BIG[file]()
    if beside:
        write_json(folder / f"{Path(file).stem}.json", beside, indent=1)
    # Whole or not at all, and last: the Makefile takes it for the scene.
    partial = folder / f"{file}.{os.getpid()}"
    partial.write_bytes(data)
    partial.replace(folder / file)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--big", type=Path, metavar="DIR", help="write only large scenes, to DIR")
    parser.add_argument("file", nargs="*", help=f"of {', '.join(BIG)}; all, unless some are named")
    args = parser.parse_args()
    if unknown := [file for file in args.file if file not in BIG]:
        parser.error(f"{unknown[0]}: no such large scene; there are {', '.join(BIG)}")
    if args.big:
        for file in args.file or BIG:
            make_big(args.big, file)
    else:
        make_small(ROOT / "scenes")


if __name__ == "__main__":
    main()
