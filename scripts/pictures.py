# SPDX-License-Identifier: Apache-2.0
"""Pictures by `ti render` as arrays, for the scripts that compare them."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]


class PictureError(Exception):
    """One sentence for the user."""


def scene_file(name: str) -> Path:
    """The file of a scene by its name."""
    command = ["scripts/scene.sh", "file", name]
    found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.strip()
    if not (ROOT / found).is_file():
        raise PictureError(f"SCENES={name}: there is no such file or scene of the project")
    return ROOT / found


def render(
    scene: Path,
    out: Path,
    config: Path,
    engine: str = "embree",
    library: Path | None = None,
    **words,
) -> tuple[dict, np.ndarray]:
    """The report and the radiance, float32 [height, width, 3], of a picture."""
    command = [ROOT / "build/sw/ti", "render", "--config", config, "--engine", engine]
    command += ["--scene", scene, "--out", out, "--dump", "--no-progress"]
    if library is not None:
        command += ["--rtl", library]
    for key, value in words.items():
        command += [f"--{key.replace('_', '-')}", value]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode == 2:
        raise PictureError(done.stderr.strip())
    if done.returncode != 0:
        raise PictureError(f"{scene.name}: its picture failed its checks: {done.stdout.strip()}")
    report = json.loads((out / "report.json").read_text())
    return report, np.load(out / "radiance.npy")


def converged(
    scene: Path, out: Path, config: Path, runs: int, first_seed: int, **words
) -> tuple[np.ndarray, np.ndarray]:
    """Mean of pictures of so many seeds by Embree, and its standard error a pixel."""
    pictures = []
    for seed in range(first_seed, first_seed + runs):
        _, radiance = render(scene, out, config, seed=seed, **words)
        pictures.append(radiance.astype(np.float64))
        shutil.rmtree(out)
    stack = np.stack(pictures)
    return stack.mean(axis=0), stack.std(axis=0, ddof=1) / np.sqrt(runs)
