# SPDX-License-Identifier: Apache-2.0
"""The instances of a replicated unit share the functions that Verilator makes of it."""

import re
import shlex
import subprocess
from collections import Counter

from agents.bench import ROOT
from configure import configure

# Functions of one class that run each cycle, however many instances and cores there are: what they
# are today and a little room.  One that is not shared would add a function an instance.
MOST = {
    "ti_fp_add": 3,
    "ti_fp_mul": 3,
    "ti_fp_rcp": 3,
    "ti_counters": 3,
    "ti_l2_bank": 9,
    "ti_ist1": 12,
    "ti_list": 12,
    "ti_memory": 9,
    "ti_trv": 12,
    "ti_core": 16,
}


def functions(folder, overrides):
    """How many functions that run each cycle each class has, by its C++ name."""
    configure("paper", overrides, folder)
    flags = re.search(
        r"^VERILATOR_FLAGS := (.*?)\n(?=[A-Z])", (ROOT / "sim/sim.mk").read_text(), re.S | re.M
    )[1]
    flags = flags.replace("$(top)", "ti_engine")
    words = shlex.split(re.sub(r"\$\(.*\)|\\\n", " ", flags))
    packages = [folder / "ti_config_pkg.sv", folder / "ti_count_pkg.sv"]
    command = [
        "verilator",
        *words,
        "--no-assert",
        f"-I{folder}",
        "--Mdir",
        folder / "cpp",
        "lint/verilator.vlt",
        "sim/sim.vlt",
    ]
    command += [*packages, "-f", "rtl/ti.f", "sim/ti_step_log.sv"]
    subprocess.run([str(word) for word in command], cwd=ROOT, check=True, capture_output=True)
    found = Counter()
    for file in (folder / "cpp").glob("*.cpp"):
        if "Slow" not in file.name:
            names = re.findall(
                r"^(?:VL_INLINE_OPT )?void Vti_engine_(ti_\w+?)___\w+\(.*\{$",
                file.read_text(),
                re.M,
            )
            found.update(names)
    return found


def test_instances_share_their_functions(tmp_path):
    found = functions(tmp_path, ["cores=2"])
    for unit, most in MOST.items():
        classes = {
            name: count for name, count in found.items() if re.sub(r"__.*", "", name) == unit
        }
        assert classes, f"{unit} is not a class: sim/sim.vlt must say no_inline"
        for name, count in classes.items():
            assert count <= most, (
                f"{name} has {count} functions; its instances share at most {most}"
            )
