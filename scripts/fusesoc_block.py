#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A FuseSoC generator: the block of a configuration, its files in the order of `rtl/ti.f`.

FuseSoC calls it in an empty folder with a YAML file.  Parameters:

  config  a name in configs/ or a file (tiny)
  set     keys of it that change, a list of KEY=VALUE
  plain   as Verilog-2001 (scripts/plain_verilog.py)
  fmax    place and route these modules behind the build: a list; of part, ecp5-85k
"""

import sys
from pathlib import Path

import configure
import plain_verilog
import wrapper
import yaml
from config_schema import ConfigError
from synthesis import MeasureError

ROOT = Path(__file__).resolve().parents[1]


def entry(path: str) -> dict:
    """A file as a core has it."""
    kind = "verilogSource" if path.endswith(".v") else "systemVerilogSource"
    if path.endswith(".svh"):
        return {path: {"file_type": kind, "is_include_file": True, "include_path": "src"}}
    return {path: {"file_type": kind}}


def files_of(here: Path, configuration: configure.Configuration, plain: bool) -> list[str]:
    """Write the block; its files, headers first."""
    wrapper.write(configuration, here)
    if plain:
        plain_verilog.write(here)
        return [f"{plain_verilog.PLAIN}.v"]
    headers = [f"src/{path.name}" for path in sorted((here / "src").glob("*.svh"))]
    listed = (here / f"{wrapper.NAME}.f").read_text().split()
    return [*headers, *(word for word in listed if not word.startswith("+"))]


def write(task: dict, here: Path) -> None:
    """Write the block and its core."""
    parameters = task["parameters"] or {}
    overrides = [str(word) for word in parameters.get("set", [])]
    configuration = configure.load(parameters.get("config", "tiny"), overrides)
    files = files_of(here, configuration, parameters.get("plain", False))
    core = {
        "name": task["vlnv"],
        "filesets": {"rtl": {"files": [entry(path) for path in files]}},
        "targets": {"default": {"filesets": ["rtl"]}},
    }
    if parameters.get("fmax"):
        configure.write(here / "config", configuration.files())
        command = [sys.executable, str(ROOT / "scripts/fmax.py"), str(here / "config")]
        command += ["--part", "ecp5-85k", "--seeds", "1", "--unit", *parameters["fmax"]]
        command += ["--json", str(here / "fmax.json")]
        core["scripts"] = {"fmax": {"cmd": command}}
        core["targets"]["default"]["hooks"] = {"post_build": ["fmax"]}
    # Or a later run would take this one's core for one of the project.
    (here / "FUSESOC_IGNORE").touch()
    name = task["vlnv"].split(":")[2]
    (here / f"{name}.core").write_text("CAPI=2:\n" + yaml.safe_dump(core, sort_keys=False))


def main() -> int:
    try:
        write(yaml.safe_load(Path(sys.argv[1]).read_text()), Path.cwd())
    except (ConfigError, MeasureError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
