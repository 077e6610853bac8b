# SPDX-License-Identifier: Apache-2.0
"""A machine is built once, whole, and anew when it must be; two builds at once do not meet."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import configure
import pytest
from agents.program import PATIENCE, ROOT, SCENES, make

PARTS = ["configs", "lint", "rtl", "scripts", "sim", "sw"]
# Neither the set-up nor the C++ programs are built again in a copy.
READY = ["-o", "build/setup.stamp", "-o", "build/sw/libti_sw.a"]
COMPILES = "build: compile the RTL model"
LINKS = "build: build/engine/"


# --- On the project itself -----------------------------------------------------------------------


@pytest.mark.usefixtures("tiny")
@pytest.mark.parametrize("change", ["", "num_trv=1", "clock_mhz=600 num_list=1", "counters=true"])
def test_a_machine_that_is_there_is_not_built_again(change):
    assert LINKS not in make("engine", CONFIG="tiny", SET=change).good().stdout


# --- On a copy, with Verilator -------------------------------------------------------------------


class Copy:
    """A copy of the sources with a `build` of its own, but for the C++ programs."""

    def __init__(self, folder):
        self.folder = folder
        self.engine = folder / "build" / configure.load("tiny").engine
        for part in PARTS:
            shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("test"))
        for file in ("Makefile", "requirements.txt"):
            shutil.copy2(ROOT / file, folder)
        (folder / "build").mkdir()
        (folder / "build/sw").symlink_to(ROOT / "build/sw")
        compiler = (ROOT / "build/setup.stamp").read_text().splitlines()[0]
        (folder / "build/setup.stamp").write_text(f"{compiler}\n{folder}\n")

    def start(self, *words):
        """`make` with these words, under way."""
        drop = {"MAKEFLAGS", "MFLAGS", "MAKELEVEL", "MAKEOVERRIDES", "CONFIG", "SET"}
        environment = {k: v for k, v in os.environ.items() if k not in drop} | {
            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
            "CCACHE_DIR": os.environ.get("CCACHE_DIR", str(ROOT / "build/ccache")),
            "CCACHE_NOHASHDIR": "1",
        }
        return subprocess.Popen(
            ["make", "-C", str(self.folder), *words],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def makes(self, *commands):
        """The outputs of `make engine` with each of these words, all at once."""
        started = [self.start("engine", "CONFIG=tiny", *READY, *words) for words in commands]
        outputs = [process.communicate(timeout=PATIENCE)[0] for process in started]
        assert [process.returncode for process in started] == [0] * len(started), outputs
        ctypes.CDLL(str(self.engine / "libti_rtl.so"))  # or an OSError
        return outputs

    def make(self):
        return self.makes([])[0]


@pytest.fixture(scope="module")
def copy(tiny, tmp_path_factory):
    return Copy(tmp_path_factory.mktemp("copy") / "project")


def test_two_makes_at_once_build_one_engine_once(copy):
    outputs = copy.makes([], ["SET=clock_mhz=600 num_trv=1"], [])

    assert sum(output.count(COMPILES) for output in outputs) == 1
    assert sum(output.count(LINKS) for output in outputs) == 1
    assert [folder.name for folder in (copy.folder / "build/engine").iterdir()] == [
        copy.engine.name
    ]


def test_other_flags_make_other_objects(copy):
    copy.make()
    assert COMPILES not in copy.make()
    rules = copy.folder / "sim/sim.mk"
    text = rules.read_text()
    assert "OPT_FAST=-O2" in text
    rules.write_text(text.replace("OPT_FAST=-O2", "OPT_FAST=-O1"))

    assert COMPILES in copy.make()
    assert " -O1 " in (copy.engine / "model.log").read_text()


def test_what_a_killed_build_left_is_not_used(copy):
    copy.make()
    library = copy.engine / "verilated/libVti_engine.a"
    for file in (library, copy.engine / "obj/rtl_engine.o", copy.engine / "libti_rtl.so"):
        file.write_bytes(b"half")
    (copy.engine / "unfinished").touch()

    output = copy.make()
    assert COMPILES in output and LINKS in output
    assert library.stat().st_size > 1000
    assert not (copy.engine / "unfinished").exists()


def test_a_library_takes_up_the_dram_when_it_is_there_and_leaves_it_when_not(dram, copy, tmp_path):
    words = ["--mem", "dram", "--rtl", copy.engine / "libti_rtl.so"]

    def trace(name):
        return dram.trace(tmp_path / name, SCENES / "cornell.gltf", "random:100", *words)

    copy.make()
    trace("without").refused("without DRAMsim3", "MEM=fixed")
    (copy.folder / "build/dram").symlink_to(ROOT / "build/dram")
    output = copy.make()
    assert LINKS in output and COMPILES not in output
    assert trace("with").good().report["memory"]["dram"]["reads"] > 0
    assert LINKS not in copy.make()
    (copy.folder / "build/dram").unlink()
    assert LINKS in copy.make()
    trace("again-without").refused("without DRAMsim3", "MEM=fixed")


# --- Locks, with programs that stand for the slow ones -------------------------------------------

# Says `overlap` when another is at work in the same folder.
SLOW = """#!/bin/sh
mkdir {folder}/busy 2>/dev/null || echo overlap >>{folder}/log
echo {name} "$@" >>{folder}/log
sleep 0.2
rmdir {folder}/busy
"""


class Stage:
    """A folder for scripts of the project, and programs that write what they are told to a log."""

    def __init__(self, folder, *scripts):
        self.folder = folder
        (folder / "bin").mkdir()
        (folder / "scripts").mkdir()
        for script in scripts:
            shutil.copy2(ROOT / "scripts" / script, folder / "scripts")

    def program(self, name, more="", path=None):
        file = self.folder / (path or f"bin/{name}")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(SLOW.format(folder=self.folder, name=name) + more)
        file.chmod(0o755)

    def run(self, *commands):
        """Outputs of scripts at once, which must end well."""
        path = f"{self.folder / 'bin'}:{os.environ['PATH']}"
        started = [
            subprocess.Popen(
                [str(self.folder / "scripts" / command[0]), *command[1:]],
                cwd=self.folder,
                env=os.environ | {"PATH": path, "TI_SKIP_APT": "1"},
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
            for command in commands
        ]
        outputs = [process.communicate(timeout=PATIENCE)[0] for process in started]
        assert [process.returncode for process in started] == [0] * len(started), outputs
        return outputs

    def log(self):
        """What the programs were told since the last call, first words of each line."""
        text = (self.folder / "log").read_text()
        (self.folder / "log").unlink()
        return [line.split()[0] for line in text.splitlines()]


def test_two_makes_at_once_configure_cpp_once(tmp_path):
    stage = Stage(tmp_path, "build_cpp.sh", "logged.sh")
    stage.program("cmake", "touch build/sw/build.ninja\n")
    stage.program("ninja")
    command = ["build_cpp.sh", "build/sw", "ti", "-DA=1"]

    stage.run(command, command, command)
    assert stage.log() == ["cmake", "ninja", "ninja", "ninja"]
    stage.run(command)
    assert stage.log() == ["ninja"]
    stage.run([*command[:3], "-DA=2"])
    assert stage.log() == ["cmake", "ninja"]


def test_a_configuration_of_cpp_that_was_cut_short_is_made_again(tmp_path):
    stage = Stage(tmp_path, "build_cpp.sh", "logged.sh")
    stage.program("cmake", "touch build/sw/build.ninja\nkill -9 $PPID\n")
    stage.program("ninja")
    command = [str(tmp_path / "scripts/build_cpp.sh"), "build/sw", "ti"]
    environment = os.environ | {"PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}"}
    killed = subprocess.run(command, env=environment, capture_output=True)
    assert killed.returncode != 0
    assert stage.log() == ["cmake"]

    stage.program("cmake", "touch build/sw/build.ninja\n")
    stage.run(["build_cpp.sh", "build/sw", "ti"])
    assert stage.log() == ["cmake", "ninja"]


def test_two_makes_at_once_set_up_once(tmp_path):
    stage = Stage(tmp_path, "setup.sh", "apt-packages.txt", "repair_verilator.py")
    (tmp_path / "requirements.txt").write_text("")
    python = "/usr/bin/python3" if os.access("/usr/bin/python3", os.X_OK) else "python3"
    version = subprocess.run([python, "--version"], capture_output=True, text=True).stdout
    stage.program("python", path="build/venv/bin/python")
    (tmp_path / "build/venv/wanted.txt").write_text(f"{version}{tmp_path.resolve()}\n")
    (tmp_path / "build/venv/bin/verilator").symlink_to("/bin/true")

    stage.run(*[["setup.sh", "--if-needed"]] * 3)
    assert stage.log() == ["python"]
    compiler, folder = (tmp_path / "build/setup.stamp").read_text().splitlines()
    assert compiler and Path(folder) == tmp_path.resolve()
    (tmp_path / "build/setup.stamp").write_text(f"{compiler}\n/elsewhere\n")
    stage.run(["setup.sh", "--if-needed"])
    assert stage.log() == ["python"]
    os.utime(tmp_path / "build/setup.stamp", (0, 0))
    stage.run(["setup.sh", "--if-needed"])
    assert stage.log() == ["python"]


@pytest.mark.parametrize("killed", [False, True])
def test_an_engine_is_built_by_one_make_which_knows_a_killed_one(tmp_path, killed):
    stage = Stage(tmp_path, "build_engine.sh")
    engine = tmp_path / "engine"
    (engine / "obj").mkdir(parents=True)
    stage.program("make", f"[ -e {engine}/unfinished ] || echo lost >>{tmp_path}/log\n")
    command = ["build_engine.sh", str(engine), "make"]
    if killed:
        dying = tmp_path / "dying"
        dying.write_text("#!/bin/sh\nkill -9 $PPID\n")
        dying.chmod(0o755)
        script = [str(tmp_path / "scripts" / command[0]), str(engine), str(dying)]
        assert subprocess.run(script).returncode != 0

    stage.run(command, command)
    assert stage.log() == ["make", "make"]
    assert (engine / "obj").exists() != killed
    assert not (engine / "unfinished").exists()


@pytest.mark.parametrize("killed", [False, True])
def test_operators_are_built_by_one_make_which_knows_a_killed_one(tmp_path, killed):
    stage = Stage(tmp_path, "build_fp_rtl.sh")
    out = tmp_path / "out"
    out.mkdir()
    (out / "half.o").touch()
    if killed:
        (out / "unfinished").touch()
    stage.program("python")
    stage.program("verilator", f"[ -e {out}/unfinished ] || echo lost >>{tmp_path}/log\n")
    command = ["build_fp_rtl.sh", "5", "10", str(out)]

    stage.run(command, command)
    assert stage.log() == ["python", "python", "verilator"] * 2  # keys, then what they define
    assert (out / "half.o").exists() != killed
    assert not (out / "unfinished").exists()


def test_a_checkout_under_a_path_with_spaces_is_refused(tmp_path):
    folder = tmp_path / "my project"
    folder.mkdir()
    shutil.copy2(ROOT / "Makefile", folder)
    run = subprocess.run(["make", "help"], cwd=folder, capture_output=True, text=True)

    assert run.returncode == 2
    assert "my project' has a space" in run.stderr and len(run.stderr.splitlines()) == 1
