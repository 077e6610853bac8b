# SPDX-License-Identifier: Apache-2.0
"""A smaller case of a run that fails: rays, then triangles, taken away while it still fails.

By delta debugging (Zeller and Hildebrandt 2002): halves, quarters and so on are left out in turn.
With stalls fewer rays meet otherwise, so a case may stay larger than it could be.
"""

import re
import shlex
from pathlib import Path

import numpy as np
from scenes.ply import ply_bytes

TRIES = 60  # runs for the rays, and as many for the triangles


def fewer(count: int, fails, tries: int = TRIES) -> list[int]:
    """A small set of the numbers below `count` with which it still fails; all fail."""
    kept, parts = list(range(count)), 2
    while len(kept) > 1 and tries > 0:
        size = -(-len(kept) // parts)
        for begin in range(0, len(kept), size):
            rest = kept[:begin] + kept[begin + size :]
            tries -= 1
            if rest and fails(rest):
                kept, parts = rest, max(parts - 1, 2)
                break
            if tries <= 0:
                break
        else:
            if size == 1:
                break
            parts = min(2 * parts, len(kept))
    return kept


def read_ply(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a file that `ply_bytes` wrote."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    vertices, faces = (int(n) for n in re.findall(rb"element \w+ (\d+)", data[:end]))
    points = np.frombuffer(data, "<f4", 3 * vertices, end).reshape(-1, 3)
    kind = np.dtype([("n", "u1"), ("v", "<i4", 3)])
    return points, np.frombuffer(data, kind, faces, end + points.nbytes)["v"]


def reduce(machine, run, library: Path, case: Path, verdict, words: list[str]) -> None:
    """Leaves in `case` what is needed to see the failure again."""
    case.mkdir(parents=True, exist_ok=True)
    scene, out = machine.scene(run), case / "out"
    _, _, said, report = machine.trace(run, library, out, "--dump")
    (case / "output.txt").write_text(f"{shlex.join(words)}\n{said}")
    if report is None or not (out / "rays.npy").is_file():
        (case / "repeat.txt").write_text(shlex.join(words) + "\n")
        return
    rays = np.load(out / "rays.npy")
    file = case / "rays.npy"

    def still(kept, mesh=None) -> bool:
        np.save(file, kept)
        return bool(verdict(run, *machine.trace(run, library, out, scene=mesh, rays=file)[1:]))

    if still(rays):
        rays = rays[fewer(len(rays), lambda some: still(rays[some]))]
        if scene.suffix == ".ply":
            points, triangles = read_ply(scene)
            mesh = case / "scene.ply"

            def fails(some) -> bool:
                mesh.write_bytes(ply_bytes(points, triangles[some]))
                return still(rays, mesh)

            if fails(list(range(len(triangles)))):
                mesh.write_bytes(ply_bytes(points, triangles[fewer(len(triangles), fails)]))
                scene = mesh
        np.save(file, rays)
    waves = machine.build("waves", "waves=1")
    more = ["--waves-file", case / "waves.fst"]
    found = re.search(r"ray (\d+):", said) if len(rays) > 1 else None
    more += ["--log-ray", str(min(int(found[1]) if found else 0, len(rays) - 1))]
    words, _, said, _ = machine.trace(run, waves, out, *more, scene=scene, rays=file)
    (case / "repeat.txt").write_text(shlex.join(words) + "\n")
    (case / "output.txt").write_text(f"{shlex.join(words)}\n{said}")
