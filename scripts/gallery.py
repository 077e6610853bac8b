#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Pictures of scenes on one page: what each calls for, its rays, cycles, time and heat map.

Each scene is rendered by `make render` into a folder of its own below OUT; `OUT/index.html` holds
pictures and figures, all of them from `report.json`, and needs no other file.  Words that are not
known here are those of `make render`.

Exit status: 0, 1 when a check of some picture failed, 2 for bad input.

Usage: scripts/gallery.py [RENDER_WORD=value ...] --out FOLDER --scene NAME ...
"""

import argparse
import base64
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import bench
import jinja2

ROOT = Path(__file__).resolve().parents[1]
TEMPLATE = "gallery.html.j2"
# Words of scenes that move.
MOVING = {"windmill": {"FRAMES": ":", "FPS": "8"}}


class GalleryError(Exception):
    """One sentence for the user."""


def words_of(scene: str, given: dict[str, str]) -> dict[str, str]:
    """The words of `make render` for a scene; of one that moves, a quarter of the samples."""
    moving = MOVING.get(scene, {"FRAMES": ":"} if scene.endswith("_anim") else {})
    words = {"SCENE": scene} | moving | given
    if moving and words.get("SPP", "").isdigit():
        words["SPP"] = str(max(1, int(words["SPP"]) // 4))
    return words


def render(scene: str, folder: Path, given: dict[str, str]) -> None:
    """Renders a scene; a refusal, which says its sentence, ends the gallery with its status."""
    words = [f"{key}={value}" for key, value in words_of(scene, given).items()]
    without = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    command = ["make", "-s", "render", *words, f"OUT={folder}"]
    (folder / "report.json").unlink(missing_ok=True)
    status = subprocess.run(command, cwd=ROOT, env=without).returncode
    if not (folder / "report.json").is_file():
        sys.exit(status)


def entry_of(scene: str, folder: Path, given: dict[str, str]) -> dict[str, Any]:
    """What the page shows of a scene."""
    report = json.loads((folder / "report.json").read_text())
    check = report["check"]
    good = not check["truth_unexplained"] and not check["model_mismatches"]
    good = good and check["lost"] == check["duplicated"] == 0

    def picture(*names: str) -> str:
        path = next((folder / name for name in names if (folder / name).is_file()), None)
        return base64.b64encode(path.read_bytes()).decode() if path else ""

    words = [f"{key}={value}" for key, value in words_of(scene, given).items()]
    return {
        "name": scene,
        "report": report,
        "good": good,
        "command": " ".join(["make render", *words]),
        "picture": picture("animation.png", "image.png"),
        "steps": picture("steps.png"),
    }


def page(entries: list[dict[str, Any]]) -> str:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(ROOT / "scripts"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    return environment.get_template(TEMPLATE).render(scenes=entries)


def run(words: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", nargs="+", required=True, help="names or files of scenes")
    parser.add_argument("--out", type=Path, required=True, help="folder of the page")
    arguments, rest = parser.parse_known_args(words)
    given = dict(word.split("=", 1) for word in rest)
    for scene in arguments.scene:
        named = subprocess.run(
            ["scripts/scene.sh", "file", scene], cwd=ROOT, capture_output=True, text=True
        )
        if not (ROOT / named.stdout.strip()).is_file():
            raise GalleryError(f"SCENES={scene}: there is no such file or scene of the project")
    entries = []
    for scene in arguments.scene:
        print(f"\n{scene}", flush=True)
        folder = arguments.out.resolve() / Path(scene).name
        render(scene, folder, given)
        entries.append(entry_of(scene, folder, given))
        bench.write_text(arguments.out / "index.html", page(entries))
    print(f"\n{arguments.out / 'index.html'}: {len(entries)} scenes")
    return 0 if all(entry["good"] for entry in entries) else 1


if __name__ == "__main__":
    sys.exit(bench.status_of("gallery", run, GalleryError))
