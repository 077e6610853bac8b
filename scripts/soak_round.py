# SPDX-License-Identifier: Apache-2.0
"""A round of `make soak`: a machine, scenes and rays, drawn from a seed and the round's number."""

import random
from dataclasses import dataclass, field
from pathlib import Path

import config_schema
import configure
import numpy as np
from scenes.ply import ply_bytes

from scenes import closed

ROOT = Path(configure.__file__).parents[1]
BASE = "tiny"
# Keys of a machine and the values that are drawn; a machine that cannot be is drawn again.
SHAPES = {
    "cores": [1, 1, 1, 2],
    "core_tile": [1, 4, 64],
    "num_trv": [1, 1, 2, 3],
    "num_list": [1, 1, 2],
    "num_ist1": [1, 1, 2, 3],
    "deal_tile": [1, 4, 16],
    "rd_cycles": [1, 2, 3],
    "trv_slots": [2, 4, 8, 16, 32],
    "list_slots": [2, 4, 8],
    "ist1_slots": [2, 4, 8, 32],
    "stack_depth": [0, 1, 2, 4, 8],
    "watchdog_steps": [65535],
    "trv_l1_bytes": [256, 1024, 4096],
    "trv_l1_ways": [1, 2, 4],
    "trv_rows": [1, 2, 4],
    "list_l1_bytes": [256, 512, 4096],
    "list_l1_ways": [1, 2],
    "list_rows": [1, 2, 4],
    "ist1_l1_bytes": [256, 1024, 8192],
    "ist1_l1_ways": [1, 2, 4],
    "ist1_rows": [1, 2, 4],
    "trv_l2_bytes": [0, 0, 4096],
    "ist1_l2_bytes": [0, 0, 8192],
    "line_bytes": [32, 64, 64, 128],
    "addr_bits": [32, 40],
    "max_reads": [2, 16, 64],
    "read_timeout": [0, 5000],
    "lookup_stages": [1, 2, 3, 4, 5],
    "fill_bytes": [8, 16, 128],
    "ray_accumulation": ["gather", "gather", "gather", "retry", "blocking"],
    "interval_cull": ["true", "true", "false"],
    "early_exit": ["true", "true", "false"],
    "fp_add_stages": [4, 5, 7, 10],
    "fp_mul_stages": [3, 4, 5, 8],
    "fp_cmp_stages": [0, 0, 1],
    "reciprocal": ["division", "division", "newton"],
    "rounding": ["nearest", "nearest", "zero"],
    "subnormals": ["keep", "keep", "flush"],
    "triangle_test": ["local", "np", "woop"],
    "traversal": ["plain", "padded"],
    "sync_reset": ["true", "false"],
    "ring_delays": ["true", "false"],
}
FORMATS = [(8, 23), (8, 23), (8, 20), (7, 16), (8, 13), (6, 12), (5, 10)]
KINDS = ["random", "inside", "primary", "ao", "diffuse", "uniform", "edges", "vertices", "grazing"]
MEMORIES = [["--mem", "ideal"], ["--mem-latency", "3"], ["--mem-latency", "100"]]
FAULTS = ["--error-every", "--late-every"]


@dataclass(frozen=True)
class Run:
    """Rays of one kind on one scene."""

    scene: str
    rays: str
    options: tuple[str, ...] = ()
    faults: bool = False  # rays may end with an error of the memory


@dataclass(frozen=True)
class Round:
    """One machine and what it traces."""

    number: int
    seed: int
    overrides: tuple[str, ...]
    runs: tuple[Run, ...]
    refused: int = 0  # machines that cannot be, before this one
    meshes: dict[str, bytes] = field(default_factory=dict)  # PLY files by name

    def write_meshes(self, folder: Path) -> None:
        """The scenes of this round that are no files of the project."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, data in self.meshes.items():
            (folder / name).write_bytes(data)


def draw(seed: int, number: int, rays: int) -> Round:
    """Round `number` of a seed, each run of `rays` rays; the same on every machine."""
    rng = random.Random(f"{seed}/{number}")
    overrides, refused = machine(rng)
    meshes = {"soup.ply": soup(rng), "ball.ply": ball(rng)}
    scenes = ["scenes/cornell.gltf", "build/scenes/knot.ply", *meshes]
    runs = tuple(run(rng, scenes, overrides, rays) for _ in range(4))
    return Round(number, seed, overrides, runs, refused, meshes)


def machine(rng: random.Random) -> tuple[tuple[str, ...], int]:
    """Overrides of `BASE` that make a machine; how many drawn before it could not be."""
    for refused in range(1000):
        chosen = rng.sample(sorted(SHAPES), rng.randint(3, 14))
        exp_bits, frac_bits = rng.choice(FORMATS)
        words = [f"{key}={rng.choice(SHAPES[key])}" for key in chosen]
        words += [f"exp_bits={exp_bits}", f"frac_bits={frac_bits}"]
        try:
            configure.load(BASE, words)
        except config_schema.ConfigError:
            continue
        return tuple(words), refused
    raise RuntimeError("no machine can be had from these keys")


def run(rng: random.Random, scenes: list[str], overrides: tuple[str, ...], rays: int) -> Run:
    """A scene, a kind of rays, a memory, perhaps stalls and faults."""
    options = list(rng.choice(MEMORIES))
    if rng.random() < 0.7:
        share = rng.choice(["0.1", "0.3", "0.7"])
        options += ["--stall-seed", str(rng.randrange(1, 1 << 30)), "--stall-share", share]
    faults = rng.random() < 0.25
    if faults:
        usable = FAULTS if "read_timeout=5000" in overrides else FAULTS[:1]
        options += [rng.choice(usable), str(rng.choice([30, 300, 3000]))]
    options += ["--seed", str(rng.randrange(1 << 30))]
    return Run(rng.choice(scenes), f"{rng.choice(KINDS)}:{rays}", tuple(options), faults)


def soup(rng: random.Random) -> bytes:
    """Triangles of one size in a cube, some flat on an axis, some twice, some without an area."""
    count, size = rng.choice([1, 7, 60, 600, 3000]), rng.choice([0.01, 0.1, 0.5])
    scale = rng.choice([1.0, 1.0, 1e-3, 1e4])
    numbers = np.random.default_rng(rng.getrandbits(63))
    corners = numbers.random((count, 1, 3)) + size * (numbers.random((count, 3, 3)) - 0.5)
    for axis in range(3):
        flat = numbers.random(count) < 0.1
        corners[flat, :, axis] = np.round(corners[flat, :1, axis] * 8) / 8
    corners[numbers.random(count) < 0.02] = corners[0]
    thin = numbers.random(count) < 0.02
    corners[thin, 2] = corners[thin, 1]
    if thin.all():
        corners[0, 2] = corners[0, 0] + (0, size, size)
    triangles = np.arange(3 * count).reshape(count, 3)
    return ply_bytes(scale * corners.reshape(-1, 3), triangles)


def ball(rng: random.Random) -> bytes:
    """A sphere of some fineness, somewhere."""
    vertices, triangles = closed.icosphere(rng.randint(0, 4))
    place = [rng.choice([0.0, 0.0, 100.0]) for _ in range(3)]
    return ply_bytes(np.asarray(vertices) + place, triangles)
