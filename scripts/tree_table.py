# SPDX-License-Identifier: Apache-2.0
"""Tree statistics of the papers' scenes, traced by the model, beside the published figures.

usage: tree_table.py TI CONFIG_JSON SCENES_FOLDER [RAYS]

The published figures are those of an independent study with its own builder; its steps are
inner nodes, so ours stand beside them without leaves.  Missing scenes are skipped with a message.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

HEADINGS = ("steps", "leaves", "full", "tests")

# Scene, kind: inner steps, leaves, leaves with triangles, tests a ray.
PUBLISHED = {
    ("conference", "primary"): (39.5, 8.5, 2.2, 5.7),
    ("conference", "ao"): (21.9, 3.8, 1.4, 3.3),
    ("conference", "diffuse"): (29.9, 5.9, 2.3, 6.0),
    ("sibenik", "primary"): (42.7, 8.5, 1.5, 4.1),
    ("sibenik", "ao"): (28.3, 4.9, 1.3, 3.2),
    ("sibenik", "diffuse"): (41.6, 7.9, 2.3, 6.4),
    ("crytek_sponza", "primary"): (53.0, 11.3, 1.9, 4.2),
    ("crytek_sponza", "ao"): (41.2, 7.2, 1.9, 4.1),
    ("crytek_sponza", "diffuse"): (51.7, 9.6, 2.6, 6.2),
    ("bart_kitchen", "primary"): None,
}


def measure(ti, config, scene, kind, count):
    """The report of `count` rays of `kind` on the model."""
    with tempfile.TemporaryDirectory() as out:
        command = [
            ti,
            "trace",
            "--rays",
            f"{kind}:{count}",
            "--scene",
            str(scene),
            "--config",
            config,
        ]
        command += ["--engine", "model", "--no-truth", "--out", out]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        return json.loads((Path(out) / "report.json").read_text())


def main(ti, config, folder, count="200000"):
    print(f"{'scene':14} {'rays':8}", *(f"{h:>11}" for h in HEADINGS), f"{'build s':>8}")
    for (name, kind), published in PUBLISHED.items():
        scene = Path(folder) / f"{name}.ply.zst"
        if not scene.is_file():
            print(f"{name:14} {kind:8} skipped: {scene} is missing")
            continue
        report = measure(ti, config, scene, kind, count)
        ray = report["per_ray"]
        ours = (ray["steps"] - ray["leaves"], ray["leaves"], ray["full_leaves"], ray["tests"])
        theirs = published or ("-",) * 4
        cells = " ".join(f"{a:5.1f} /{b:>4}" for a, b in zip(ours, theirs, strict=True))
        print(f"{name:14} {kind:8} {cells} {report['time']['build']:8.2f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
