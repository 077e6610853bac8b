# SPDX-License-Identifier: Apache-2.0
"""Run the programs and the Makefile as a user does, and read what they leave."""

import json
import os
import re
import subprocess
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"
KNOT = ROOT / "build/scenes/knot.ply"
BENCHMARKS = ROOT.parent / "shared/scenes"
MAKES_OWN = re.compile(r"make(\[\d+\])?: \*\*\*")
PATIENCE = 600  # seconds for one program


@dataclass(frozen=True)
class Stored:
    """A scene with its memory image, so that no run builds the tree again."""

    path: Path
    image: Path


@dataclass(frozen=True)
class Run:
    """One finished program; `out` is the folder that it was told to write in."""

    status: int
    stdout: str
    stderr: str
    command: str
    out: Path | None = None

    def read(self, name):
        return (self.out / name).read_bytes()

    @cached_property
    def report(self):
        return json.loads(self.read("report.json"))

    @cached_property
    def prims(self):
        return np.load(self.out / "prims.npy")

    @cached_property
    def hits(self):
        return np.load(self.out / "hits.npy")

    def good(self):
        """This run, which must have ended well."""
        assert self.status == 0, self._told()
        return self

    def failed_its_checks(self):
        """This run, which must have ended with status 1: its results are not right."""
        assert self.status == 1, self._told()
        return self

    def refused(self, *words):
        """Check for bad input: one sentence with `words`, status 2, nothing written."""
        lines = [line for line in self.stderr.splitlines() if not MAKES_OWN.match(line)]
        assert self.status == 2, self._told()
        assert len(lines) == 1, self._told()
        assert not re.search(r"unexpected:|Traceback|terminate|Error:", self.stderr), self._told()
        missing = [word for word in words if word not in lines[0]]
        assert not missing, f"does not say {missing}\n{self._told()}"
        assert self.out is None or not self.out.exists(), f"left {list(self.out.iterdir())}"

    def _told(self):
        return f"{self.command}\nstatus {self.status}\n{self.stdout}{self.stderr}"


def call(command, out=None):
    """Run a command from the root of the project."""
    finished = subprocess.run(
        [str(word) for word in command],
        cwd=ROOT,
        env=_environment(),
        capture_output=True,
        text=True,
        errors="replace",
        timeout=PATIENCE,
        check=False,
    )
    text = " ".join(str(word) for word in command)
    return Run(finished.returncode, finished.stdout, finished.stderr, text, out)


def make(target, out=None, **variables):
    """`make TARGET NAME=value ...`; `out` becomes OUT."""
    values = variables | ({} if out is None else {"OUT": out})
    return call(["make", target, *(f"{name}={value}" for name, value in values.items())], out)


class Program:
    """`ti` for one configuration, with its RTL or (`rtl` false) without any."""

    path = ROOT / "build/sw/ti"

    def __init__(self, config, rtl=True):
        folder = ROOT / "build/config" / config
        self.config = folder / "config.json"
        self.library = folder / "engine/libti_rtl.so" if rtl else None
        self._engine = "rtl" if rtl else "model"

    def with_keys(self, folder, **keys):
        """Its `config.json` with other values of keys that are not of the RTL."""
        path = folder / f"config-{'-'.join(map(str, keys.values()))}.json"
        path.write_text(json.dumps(json.loads(self.config.read_text()) | keys))
        return path

    def run(self, command, *arguments, config=None):
        words = ["--config", config or self.config, *arguments]
        return call([self.path, command, *words, *self._rtl(words)])

    def trace(self, out, scene, rays, *options, **named):
        """`ti trace`; `engine` and `config` can be named."""
        return self._run("trace", out, scene, ["--rays", rays, *options], **named)

    def render(self, out, scene, *options, **named):
        return self._run("render", out, scene, options, **named)

    def _run(self, command, out, scene, options, engine=None, config=None):
        words = ["--engine", engine or self._engine, "--out", out, "--no-progress", *options]
        stored = isinstance(scene, Stored)
        words += ["--scene", scene.path, "--image", scene.image] if stored else ["--scene", scene]
        words = ["--config", config or self.config, *words]
        return call([self.path, command, *words, *self._rtl(words)], out)

    def _rtl(self, words):
        """The library of the RTL, unless the words name another."""
        return ["--rtl", self.library] if self.library and "--rtl" not in words else []


def _environment():
    """Ours, without what a `make` above would hand on to the one that a test starts."""
    made = re.findall(r"^(\w+) \?=", (ROOT / "Makefile").read_text(), re.MULTILINE)
    drop = {*made, "MAKEFLAGS", "MFLAGS", "MAKELEVEL", "MAKEOVERRIDES"}
    return {name: value for name, value in os.environ.items() if name not in drop}
