#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Pictures of three scenes beside those of Mitsuba 3 (Jakob et al. 2022), converged, same depth.

Each scene is described once, here, and written for both programs: the Cornell box; the same room
with a ball of glass; with a ball of rough metal.  A depth of N scatterings is `--bounces N` here
and `max_depth` N + 1 there.  Both integrators sample light and surfaces, without roulette, with a
box filter; samples are independent, so pictures differ by noise where the programs agree.

The measure: pictures are averaged over blocks of 8x8 pixels; the mean of |ours - theirs| over the
blocks and channels, in units of the mean of theirs.  More than a hundredth is status 1.

Usage: scripts/second_opinion.py --config FILE --out FOLDER [--size N] [--runs N] [--spp N]
"""

import argparse
import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import mitsuba as mi
import numpy as np
from pictures import PictureError, converged
from scenes.cornell import BLOCKS, FLOOR, LIGHT, WALLS, ceiling
from scenes.ply import ply_bytes
from scenes.shapes import ball, joined, placed

LIMIT = 0.01
BLOCK = 8
BOUNCES = 4
SEED = 1000
CAMERA = {"eye": [0.278, 0.273, -0.8], "target": [0.278, 0.273, 0.2], "up": [0, 1, 0]}
FOV = 39.3077

WHITE, RED, GREEN = (
    {"Kd": kd} for kd in ([0.73, 0.71, 0.68], [0.57, 0.04, 0.04], [0.1, 0.38, 0.08])
)
LAMP = {"Kd": [0.0, 0.0, 0.0], "Ke": [18.0, 15.5, 11.9]}
GLASS = {"Kd": [0, 0, 0], "Tf": [1, 1, 1], "Ni": 1.5, "illum": 7}
ALPHA = 0.1
METAL = {"Kd": [0, 0, 0], "Ks": [0.9, 0.7, 0.3], "Ns": 2 / ALPHA**2 - 2, "illum": 2}


def quad(corners: list) -> tuple[np.ndarray, np.ndarray]:
    """A quad in metres, of corners in millimetres."""
    return np.array(corners) / 1000, np.array([(0, 1, 2), (0, 2, 3)])


def room(blocks: bool) -> list:
    """Shapes with their materials: the box in metres, with its blocks or without."""
    parts = []
    walls = [*FLOOR, ("ceiling", 0, ceiling(LIGHT)), *WALLS, *(BLOCKS if blocks else [])]
    for _, number, quads in walls:
        parts.append((joined(*map(quad, quads)), [WHITE, RED, GREEN][number]))
    # In the hole of the ceiling: ours shines up too, where there is nothing.
    parts.append((quad(LIGHT), LAMP))
    return parts


SCENES = {
    "cornell": room(True),
    "glass": [*room(False), (placed(ball(24), [0.26, 0.121, 0.25], 0.12), GLASS)],
    "metal": [*room(False), (placed(ball(24), [0.26, 0.141, 0.28], 0.14), METAL)],
}


def write_ours(parts: list, folder: Path) -> Path:
    """A PLY with a material a part, and its description beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    vertices, triangles = joined(*(shape for shape, _ in parts))
    numbers = np.concatenate([np.full(len(s[1]), k) for k, (s, _) in enumerate(parts)])
    (folder / "scene.ply").write_bytes(ply_bytes(vertices, triangles, numbers))
    description = {"camera": CAMERA | {"fov_y_deg": FOV}, "materials": [m for _, m in parts]}
    (folder / "scene.json").write_text(json.dumps(description))
    return folder / "scene.ply"


def bsdf_of(material: dict) -> dict:
    """The same material for Mitsuba."""
    if "Ni" in material:
        return {"type": "dielectric", "int_ior": material["Ni"], "ext_ior": 1.0}
    if "Ks" in material:
        metal = {
            "type": "roughconductor",
            "material": "none",
            "distribution": "ggx",
            "alpha": ALPHA,
        }
        metal["specular_reflectance"] = {"type": "rgb", "value": material["Ks"]}
        return {"type": "twosided", "bsdf": metal}
    colour = {"type": "rgb", "value": material["Kd"]}
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": colour}}


def theirs(parts: list, size: int, spp: int) -> np.ndarray:
    """Mitsuba's picture, float64 [size, size, 3]."""
    mi.set_variant("scalar_rgb")
    film = {
        "type": "hdrfilm",
        "width": size,
        "height": size,
        "rfilter": {"type": "box"},
        "pixel_format": "rgb",
        "component_format": "float32",
    }
    look = mi.ScalarTransform4f().look_at(CAMERA["eye"], CAMERA["target"], CAMERA["up"])
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": BOUNCES + 1, "rr_depth": 1000},
        "sensor": {
            "type": "perspective",
            "fov": FOV,
            "fov_axis": "y",
            "to_world": look,
            "film": film,
            "sampler": {"type": "independent", "sample_count": spp},
        },
    }
    for k, ((vertices, triangles), material) in enumerate(parts):
        props = mi.Properties()
        props["mesh_bsdf"] = mi.load_dict(bsdf_of(material))
        if "Ke" in material:
            light = {"type": "area", "radiance": {"type": "rgb", "value": material["Ke"]}}
            props["mesh_emitter"] = mi.load_dict(light)
        mesh = mi.Mesh(f"part{k}", len(vertices), len(triangles), props=props)
        params = mi.traverse(mesh)
        params["vertex_positions"] = np.asarray(vertices, dtype=np.float32).ravel()
        params["faces"] = np.asarray(triangles, dtype=np.uint32).ravel()
        params.update()
        scene[f"part{k}"] = mesh
    return np.array(mi.render(mi.load_dict(scene), seed=1), dtype=np.float64)


def blocks(picture: np.ndarray) -> np.ndarray:
    n = len(picture) // BLOCK
    return picture.reshape(n, BLOCK, n, BLOCK, 3).mean(axis=(1, 3))


def show(ours: np.ndarray, other: np.ndarray, path: Path, title: str) -> None:
    """Both pictures and their difference in percent of the mean."""
    exposure = 0.25 / np.mean(other)
    figure, axes = plt.subplots(1, 3, figsize=(12, 4.2))
    for axis, picture, name in zip(axes, (ours, other), ("ours", "Mitsuba 3"), strict=False):
        axis.imshow(np.clip(picture * exposure, 0, 1) ** (1 / 2.2))
        axis.set_title(name)
    percent = 100 * (ours - other).mean(axis=2) / other.mean()
    image = axes[2].imshow(percent, cmap="RdBu", vmin=-10, vmax=10)
    axes[2].set_title("difference, % of the mean")
    figure.colorbar(image, ax=axes[2], fraction=0.046)
    for axis in axes:
        axis.axis("off")
    figure.suptitle(title)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    plt.close(figure)


def run(words: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", type=Path, required=True, help="config.json")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--size", type=int, default=64, help="pixels on a side, of 8")
    parser.add_argument("--runs", type=int, default=16, help="pictures of ours, a seed each")
    parser.add_argument("--spp", type=int, default=256, help="samples a pixel of each")
    arguments = parser.parse_args(words)
    if arguments.size % BLOCK != 0:
        raise PictureError(f"--size {arguments.size}: give a multiple of {BLOCK}")
    arguments.out.mkdir(parents=True, exist_ok=True)
    size, good, rows = arguments.size, True, []
    for name, parts in SCENES.items():
        scene = write_ours(parts, arguments.out / name)
        options = {"size": f"{size}x{size}", "spp": arguments.spp, "bounces": BOUNCES}
        ours, error = converged(
            scene, arguments.out / name / "run", arguments.config, arguments.runs, SEED, **options
        )
        other = theirs(parts, size, arguments.runs * arguments.spp)
        difference = np.abs(blocks(ours) - blocks(other)).mean() / other.mean()
        brightness = ours.mean() / other.mean() - 1
        noise = np.sqrt(2) * np.sqrt(blocks(error**2) / BLOCK**2).mean() / other.mean()
        good = good and difference < LIMIT
        rows.append(f"| {name} | {difference:.2%} | {brightness:+.2%} | {noise:.2%} |")
        print(rows[-1], flush=True)
        show(
            ours, other, arguments.out / f"{name}.png", f"{name}: mean difference {difference:.2%}"
        )
    head = [
        "| scene | mean difference | brightness | noise that alone would give |",
        "|---|---:|---:|---:|",
    ]
    (arguments.out / "second-opinion.md").write_text("\n".join([*head, *rows]) + "\n")
    return 0 if good else 1


if __name__ == "__main__":
    try:
        sys.exit(run(sys.argv[1:]))
    except PictureError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
