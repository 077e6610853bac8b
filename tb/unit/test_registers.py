# SPDX-License-Identifier: Apache-2.0
"""What is in the tree is what `scripts/registers.py` makes of `rtl/host/ti_regs.rdl`."""

import re
import shutil
import subprocess
import sys

import pytest
import registers
from agents.bench import ROOT

FILES = registers.files(ROOT / registers.SOURCE)


@pytest.mark.parametrize("place", FILES)
def test_a_file_is_what_is_made_again(place):
    assert (ROOT / place).read_text() == FILES[place], f"{place}: run `make registers`"


def test_a_change_of_the_source_changes_all_files(tmp_path):
    (tmp_path / "rtl/host").mkdir(parents=True)
    source = tmp_path / registers.SOURCE
    text = (ROOT / registers.SOURCE).read_text()
    source.write_text(text.replace("} watchdog[2:2] = 0;", "} watchdog[5:5] = 0;"))
    command = [sys.executable, ROOT / "scripts/registers.py", "--root", tmp_path]
    subprocess.run(command, check=True)
    for place, was in FILES.items():
        now = (tmp_path / place).read_text()
        assert now != was or place.endswith("_pkg.sv"), place


def test_a_source_that_is_wrong_ends_with_its_place(tmp_path):
    shutil.copytree(ROOT / "rtl/host", tmp_path / "rtl/host")
    source = tmp_path / registers.SOURCE
    source.write_text(source.read_text().replace("addrmap ti_regs {", "addrmap {{", 1))
    command = [sys.executable, ROOT / "scripts/registers.py", "--root", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert re.search(r"ti_regs\.rdl:\d+", done.stderr)


def test_the_python_model_and_the_header_agree():
    header = FILES["sw/host/ti_regs.h"]
    model = {}
    exec(FILES["sw/host/ti_regs.py"], model)
    for name, register in model["REGISTERS"].items():
        there = re.sub(r"_(?=\d$)\d", "X", name)  # an element of an array
        for field, place in register.fields.items():
            mask = re.search(rf"TI_REGS__{there}__{field.upper()}_bm (\w+)", header)
            assert mask and int(mask[1], 16) == place.mask, (name, field)
