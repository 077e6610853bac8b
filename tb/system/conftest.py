# SPDX-License-Identifier: Apache-2.0
"""Builds, once in a run, of what the tests of whole programs drive."""

import fcntl
import sys

import configure
import pytest
from agents.program import BENCHMARKS, KNOT, ROOT, SCENES, Program, Stored, make


def built(*targets, **variables):
    """Let the Makefile build; one process of a parallel run at a time."""
    lock = ROOT / "build/system.lock"
    lock.parent.mkdir(exist_ok=True)
    with lock.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        for target in targets:
            run = make(target, **variables)
            if run.status != 0:
                pytest.fail(f"{run.command}\n{run.stdout}{run.stderr}", pytrace=False)


@pytest.fixture(scope="session")
def ti():
    """`ti` without RTL, for the configuration tiny."""
    built("sw", "config", CONFIG="tiny")
    return Program("tiny", rtl=False)


@pytest.fixture(scope="session")
def tiny():
    """`ti` with the RTL of the configuration tiny."""
    built("engine", "build/sw/ti", CONFIG="tiny")
    return Program("tiny")


@pytest.fixture(scope="session")
def top():
    """`ti` with the ti_top of the configuration tiny, behind its driver."""
    built("top-engine", "build/sw/ti", CONFIG="tiny")
    program = Program("tiny")
    program.library = program.library.parent / "top/libti_rtl.so"
    return program


@pytest.fixture(scope="session")
def module(ti):
    """The Python module `ti`, built with the programs."""
    del ti
    sys.path.insert(0, str(ROOT / "build/sw/python"))
    import ti as found

    return found


@pytest.fixture(scope="session")
def small():
    """`ti` with the RTL of the configuration small."""
    built("engine", "build/sw/ti", CONFIG="small")
    return Program("small")


@pytest.fixture(scope="session")
def tiny_with(ti):
    """A function that gives `ti` with the RTL of tiny with other keys, as in ["num_trv=1"]."""

    def program(keys):
        built("engine", CONFIG="tiny", SET=" ".join(keys))
        return Program(configure.load("tiny", keys).folder.name)

    return program


@pytest.fixture(scope="session")
def dram(tiny):
    """The same with a DRAM for `--mem dram`; skips where cargo is missing or finds no network."""
    run = make("dram")
    if run.status == 2 and "MEM=fixed" in run.stderr:
        pytest.skip(run.stderr.splitlines()[0])
    built("engine", CONFIG="tiny", MEM="dram")
    return tiny


@pytest.fixture(params=["tiny", "small"])
def engine(request):
    """`ti` with RTL, one configuration after the other."""
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="session")
def knot():
    """The large scene that the project makes."""
    built("build/scenes/knot.ply")
    return KNOT


@pytest.fixture(params=["cornell", "knot"])
def scene(request):
    """A small scene and a large one."""
    return (
        SCENES / "cornell.gltf" if request.param == "cornell" else request.getfixturevalue("knot")
    )


@pytest.fixture(scope="session")
def images(ti, tmp_path_factory):
    """A function that gives a scene with its memory image, made once."""
    folder = tmp_path_factory.mktemp("images")

    def stored(path):
        image = folder / f"{path.stem}.tiim"
        if not image.exists():
            ti.run("image", "--scene", path, "--out", image).good()
        return Stored(path, image)

    return stored


@pytest.fixture
def stored(scene, images):
    """The same scenes, each with its memory image."""
    return images(scene)


@pytest.fixture
def benchmark():
    """A function that gives a scene of the archive by its name, or skips."""

    def find(name):
        path = BENCHMARKS / f"{name}.ply.zst"
        if not path.is_file():
            pytest.skip(f"{path.name} is not in ../shared/scenes")
        return path

    return find


@pytest.fixture
def out(tmp_path):
    """A folder that does not exist yet."""
    return tmp_path / "out"
